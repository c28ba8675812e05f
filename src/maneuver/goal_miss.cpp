#include "maneuver/goal_miss.hpp"

#include <cmath>

#include "lie/so3.hpp"
#include "maneuver/asked_attitudes.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::maneuver {

std::optional<GoalMiss> goal_miss(const model::System& system, const Problem& problem, const Solution& motion) {
  if (!problem.goal || problem.goal->periodic || motion.rotation.empty()) return std::nullopt;
  mechanics::Rotations start;
  for (const Vector3d& vector : problem.start.rotation) start.push_back(lie::exp(vector));
  const AskedAttitudes asked = asked_attitudes(system, *problem.goal, start);
  const mechanics::Rotations& end = motion.rotation.back();
  GoalMiss miss;
  const auto count = [&](int body, int joint, const Matrix3d& wanted, const Matrix3d& found) {
    const double off = lie::rotation_angle(wanted.transpose() * found);
    if (miss.turns() && off <= miss.rotation) return;
    miss.rotation = off;
    miss.body = body;
    miss.joint = joint;
  };
  for (int i = 0; i < system.body_count(); ++i)
    if (const auto& rotation = asked.rotation[model::at(i)]) count(i, -1, *rotation, end[model::at(i)]);
  for (int j = 0; j < system.joint_count(); ++j)
    if (const auto& joint = asked.joint[model::at(j)])
      count(-1, j, *joint, mechanics::child_to_parent(end, system.joint(j)));
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
