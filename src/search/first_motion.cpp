#include "search/first_motion.hpp"

#include <algorithm>

#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "mechanics/joint_moments.hpp"
#include "search/found.hpp"

namespace lamprey::search {

namespace {

using maneuver::NodePath;
using mechanics::Rotations;
using model::at;
using model::System;

// The shape of stored bodies, as far as the system's joints can take it; notes what they cannot.
Rotations jointed(const System& system, const Rotations& stored, FirstMotion& first) {
  Rotations R = stored;
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent < 0) continue;
    const model::Joint& joint = system.joint(body.joint);
    const Eigen::Matrix3d Q = mechanics::child_to_parent(stored, joint);
    const Eigen::Matrix3d taken =
        joint.free() ? Q : mechanics::joint_rotation(joint, mechanics::joint_angles(joint, Q));
    R[at(i)] = R[at(body.parent)] * taken;
    const double left = lie::rotation_angle(taken.transpose() * Q);
    if (left <= first.left_out) continue;
    first.left_out = left;
    first.left_out_by = body.joint;
  }
  return R;
}

}  // namespace

FirstMotion first_motion(const System& system, const maneuver::Problem& problem, const maneuver::Solution& solution) {
  const maneuver::Maneuver grid = maneuver::make_maneuver(system, problem, static_cast<int>(solution.time.size()) - 1);
  const Rotations& start = grid.start.rotation;
  const Eigen::Matrix3d heading = start[0] * solution.rotation.front()[0].transpose();
  FirstMotion first;
  NodePath& path = first.path;
  for (std::size_t k = 0; k < solution.rotation.size(); ++k) {
    Rotations R = jointed(system, solution.rotation[k], first);
    path.control.push_back(mechanics::along_actuation(
        system, mechanics::moments_of_applied(system, solution.rotation[k], solution.control[k])));
    for (Eigen::Matrix3d& body : R) body = heading * body;
    path.rotation.push_back(std::move(R));
    path.position.push_back(problem.start.position + heading * (solution.position[k] - solution.position.front()));
    if (k > 0) maneuver::cayley_between(path.rotation[k - 1], path.rotation[k], path.cayley.emplace_back());
  }
  if (!problem.start.free_shape) path = guess::led_to_start(system, path, start);
  first.duration = problem.duration.value;
  if (problem.duration.free)
    first.duration =
        std::clamp(solution.time.back() - solution.time.front(), problem.duration.min, problem.duration.max);
  const Found found = found_in(system, grid, maneuver::limit_rows(system, problem), solution);
  if (found.limit_multipliers.weight > 0.0) first.limit_multipliers = found.limit_multipliers;
  if (found.work_multipliers.weight > 0.0) first.work_multipliers = found.work_multipliers;
  return first;
}

}  // namespace lamprey::search
