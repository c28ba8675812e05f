// A motion that someone has, as the first guess of a search.
#pragma once

#include "maneuver/node_path.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"
#include "shape/cost_terms.hpp"
#include "shape/limit_terms.hpp"

namespace lamprey::search {

struct FirstMotion {
  maneuver::NodePath path;                    // on as many steps as it was stored with
  double duration = 0.0;                      // s
  shape::LimitMultipliers limit_multipliers;  // of those of the problem's limits that it was found within
  shape::WorkMultipliers work_multipliers;
  double left_out = 0.0;  // rad, the most of a joint's turn that the problem's joint cannot take
  int left_out_by = -1;   // that joint
};

/// The nodes and moments of a solution or march of a swimmer of the same tree, placed and headed as the problem starts: joints turn
/// as they did, about the axes that the problem's have, and, unless its first shape is free, from its first shape by less and less
/// of the difference. Multipliers of limits of the same names come along, so that an answer within limits is where the search
/// begins, or near. Goal, limits, bodies, steps and scheme may be others than those it was found for.
FirstMotion first_motion(const model::System& system, const maneuver::Problem& problem,
                         const maneuver::Solution& solution);

}  // namespace lamprey::search
