#include "maneuver/goal_miss.hpp"

#include <cmath>

#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"

namespace lamprey::maneuver {

std::optional<GoalMiss> goal_miss(const model::System& system, const Problem& problem, const Solution& motion) {
  if (!problem.goal || problem.goal->periodic || motion.rotation.empty()) return std::nullopt;
  mechanics::Rotations start;
  for (const Vector3d& vector : problem.start.rotation) start.push_back(lie::exp(vector));
  const auto asked = end_rotations(system, *problem.goal, start);
  GoalMiss miss;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (!asked[i]) continue;
    const double off = lie::rotation_angle(asked[i]->transpose() * motion.rotation.back()[i]);
    if (miss.body >= 0 && off <= miss.rotation) continue;
    miss.rotation = off;
    miss.body = static_cast<int>(i);
  }
  Vector3d off = Vector3d::Zero();
  for (int c = 0; c < 3; ++c)
    if (const auto& move = problem.goal->move[model::at(c)]) {
      off[c] = motion.position.back()[c] - problem.start.position[c] - *move;
      miss.moves = true;
    }
  miss.position = off.norm();
  return miss;
}

}  // namespace lamprey::maneuver
