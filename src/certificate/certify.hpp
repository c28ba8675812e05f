// Certificate of an answer from its plain data alone: rotations, positions and controls at the nodes, and the problem.
#pragma once

#include <functional>
#include <optional>

#include "certificate/certificate.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::certificate {

struct Options {
  bool optimality = true;  // compute kkt,
  bool of_misses = true;   // of motions that miss the goal, too
  bool second_order = true;
  bool replay = true;
  double replay_tolerance = 1e-12;  // of a step of the reference integrator
  std::function<bool()> stopped{};  // ends the replays without servos, whose numbers then stay NaN; empty: nothing does
};

/// Everything that can be checked of the answer. `system` is that of the problem's swimmer; `solution` has its shapes.
/// Without a goal, or for a motion that was only simulated, the laws alone: drifts, equation residual, start, clearance. Left NaN:
/// all but goal_error, start_error, clearance and the drifts where a march divided its steps, since nodes alone do not tell
/// then whether the steps between them obey the law (above order 2 each step is marched again); kkt above order 2 or of moments on
/// splines where more than effort and time counts.
Certificate certify(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                    const Options& options = {});

/// The replay of a certificate alone: with Options::replay off, certify does the rest beside it. Nothing where there is no motion.
std::optional<Replay> certify_replay(const model::System& system, const maneuver::Problem& problem,
                                     const maneuver::Solution& solution, const Options& options = {});

/// Adds what second derivatives say, and the verdict, to a certificate of the same answer. Once `stopped` says so (it may be
/// empty) the test with all axes does not begin; returns whether all was done.
bool add_second_order(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                      Certificate& certificate, const std::function<bool()>& stopped = {});

/// Adds the replay with feedback to that of a solution which was given its gains since.
void certify_feedback(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                      Replay& replay, const Options& options = {});

}  // namespace lamprey::certificate
