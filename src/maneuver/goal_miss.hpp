// How far a motion ends from a goal that it did not seek.
#pragma once

#include <optional>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

/// What is free counts as met.
struct GoalMiss {
  double rotation = 0.0;  // rad, of the body that is off most
  int body = -1;          // which that is; −1: a joint, or the goal asks for no attitude
  int joint = -1;         // which joint that is; −1: a body
  double position = 0.0;  // m, the root's, along the axes that the goal asks for
  bool moves = false;     // whether it asks for any
  bool turns() const { return body >= 0 || joint >= 0; }
};

/// Of a problem's goal, seen from the problem's own start; nothing where it has none or where that is a gait's.
std::optional<GoalMiss> goal_miss(const model::System& system, const Problem& problem, const Solution& motion);

}  // namespace lamprey::maneuver
