#include "optimality/gait_phase.hpp"

#include "algebra/row_space.hpp"
#include "evidence/goal_check.hpp"
#include "lie/so3.hpp"
#include "mechanics/tree_motion.hpp"
#include "optimality/gait_ends.hpp"

namespace lamprey::optimality {

namespace {

using model::at;

// From one shape to another, along the freedoms of the bodies but the root's, rad.
VectorXd change_of_shape(const model::System& system, const mechanics::Rotations& from,
                         const mechanics::Rotations& to) {
  const Eigen::Index of_root = 3;
  VectorXd change(system.velocity_count() - 3 - of_root);
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const model::Body& child = system.body(joint.child);
    auto along = change.segment(child.velocity_offset - of_root, child.freedoms);
    if (child.freedoms == 3) {  // it turns on its own
      const Matrix3d before = from[0].transpose() * from[at(joint.child)],
                     after = to[0].transpose() * to[at(joint.child)];
      along = lie::log(before.transpose() * after);
    } else {
      const Vector3d before = mechanics::joint_angles(joint, mechanics::child_to_parent(from, joint));
      const Vector3d after = mechanics::joint_angles(joint, mechanics::child_to_parent(to, joint));
      for (int f = 0; f < child.freedoms; ++f) along[f] = lie::shorter_way(after[f] - before[f]);
    }
  }
  return change;
}

// Whether the same gait, begun a step later where the problem begins, does all that is asked for, and goes as far where that counts in
// the cost: then it is another answer at the same cost.
bool begins_anywhere(const StoredMotion& motion) {
  constexpr double same = 1e-7;  // rad, units of length
  const maneuver::Problem& problem = motion.problem;
  if (!problem.waypoints.empty() || !problem.limits.spheres.empty() || !problem.limits.half_spaces.empty())
    return false;
  const auto root = [&](int k) -> const Matrix3d& { return motion.solution.rotation[at(k)][0]; };
  const auto place = [&](int k) -> const Vector3d& { return motion.solution.position[at(k)]; };
  const Matrix3d cycle = root(motion.steps) * root(0).transpose(), back = root(0) * root(1).transpose();
  const Vector3d way = place(motion.steps) - place(0);
  const Vector3d later = back * (place(motion.steps) + cycle * (place(1) - place(0)) - place(1));
  const double length = motion.system.length_unit();
  for (int c = 0; c < 3; ++c) {
    const bool told = problem.goal->move[at(c)] || problem.cost_weights.displacement[c] != 0.0;
    if (told && std::abs(later[c] - way[c]) > same * length) return false;
  }
  const bool by_distance = problem.cost_weights.transport > 0.0;
  if (by_distance && std::abs(later.norm() - way.norm()) > same * length) return false;
  const bool turns = evidence::asked_rotations(motion.system, problem).front().has_value();
  return !turns || lie::rotation_angle((cycle * root(0)).transpose() * (back * cycle * root(1))) <= same;
}

}  // namespace

std::optional<Inputs> phase_direction(const StoredMotion& motion, const EffortChain& effort) {
  if (!periodic(motion) || !motion.problem.start.free_shape || motion.steps < 2) return std::nullopt;
  if (!begins_anywhere(motion)) return std::nullopt;
  const std::vector<integrator::State> states = node_states(motion);
  const integrator::State &before = states[at(motion.steps - 1)], &after = states[1];
  const Eigen::Index freedoms = shape_freedoms(motion);
  VectorXd change(2 * freedoms);
  change << change_of_shape(motion.system, before.rotation, after.rotation),
      (after.momentum - before.momentum).segment(3, freedoms);
  const VectorXd first = periodic_start(motion, states.front(), VectorXd::Ones(freedoms)) * change;
  const Eigen::Index N = motion.steps;
  Inputs direction = {algebra::least_squares(effort.start, first.cwiseQuotient(effort.tangents.scale))};
  for (Eigen::Index k = 0; k <= N; ++k)
    direction.emplace_back(effort.input.col(k < N ? k + 1 : 1) - effort.input.col(k > 0 ? k - 1 : N - 1));
  for (const VectorXd& part : direction)
    if (!part.isZero(0.0)) return direction;
  return std::nullopt;
}

}  // namespace lamprey::optimality
