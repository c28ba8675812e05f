// Marching a swimmer along given joint angles: total momentum fixes how the whole moves, and with it the joint moments that
// take the swimmer there (chapter 9).
#pragma once

#include <functional>
#include <vector>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::guess {

using integrator::Scheme;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Start;
using maneuver::Vectors;

/// How the joints turn in time, [joints][3] as mechanics::turn_from_zero has them.
struct JointAngles {
  std::function<Vectors(double)> turn;      // s → rad
  std::function<Vectors(double)> rate;      // s → rad/s, its derivative
  std::vector<bool> passive = {};           // [joints] of which these say nothing: no moment drives them; empty: none
  std::optional<Start> passive_start = {};  // how these are bent and turn at first; empty: as in the problem's start
};

/// Whether steps of a scheme can follow joint angles: those of order 2 and below, whose moments at the nodes they fix.
bool follows_angles(Scheme scheme);

/// Marches by the problem's scheme, duration and steps, from its root's position and attitude and with the total momentum that
/// its start carries; joint angles and rates at the start are those given, of passive joints passive_start's, which go on as fluid,
/// springs and dampers make them (equation 9.33). Moments at both ends are those that begin and end at
/// the given rates. Where no motion leads on, or a body turns beyond a quarter turn in a step, the march ends: status stalled,
/// the message says where and what to try, and the arrays hold the nodes before it. So is the status where the angles take
/// moments about axes that nothing drives.
Solution march_along(const model::System& system, const Problem& problem, const JointAngles& angles,
                     const std::function<bool()>& interrupted = {});

/// The start of such a march: the problem's, bent and moving as the angles begin.
Start start_along(const model::System& system, const Problem& problem, const JointAngles& angles);

}  // namespace lamprey::guess
