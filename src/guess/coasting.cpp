#include "guess/coasting.hpp"

#include <memory>

#include "guess/angle_march.hpp"
#include "guess/guess.hpp"
#include "maneuver/control_path.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::cayley_between;
using maneuver::ControlPath;
using maneuver::Interpolation;
using maneuver::Status;
using model::at;
using model::System;

constexpr int halvings_of_turns = 3;  // of what the guess's joints turn

// How the joints turn along a motion, as splines through its nodes.
JointAngles angles_along(const System& system, const Problem& problem, const NodePath& path) {
  const auto nodes = static_cast<Eigen::Index>(path.rotation.size());
  const int joints = system.joint_count();
  MatrixXd turns = MatrixXd::Zero(Eigen::Index{3} * joints, nodes);
  JointAngles angles;
  for (int j = 0; j < joints; ++j) {
    angles.passive.push_back(problem.swimmer.joints[at(j)].passive());
    Vector3d turn = Vector3d::Zero();
    for (Eigen::Index k = 0; k < nodes; ++k) {
      const Matrix3d Q = mechanics::child_to_parent(path.rotation[static_cast<std::size_t>(k)], system.joint(j));
      turns.col(k).segment<3>(Eigen::Index{3} * j) = turn = mechanics::turn_from_zero(system.joint(j), Q, turn);
    }
  }
  const auto spline = std::make_shared<const ControlPath>(
      Interpolation::not_a_knot_cubic, VectorXd::LinSpaced(nodes, 0.0, problem.duration.value), turns);
  const auto by_joint = [joints](const VectorXd& all) {
    Vectors each;
    for (int j = 0; j < joints; ++j) each.emplace_back(all.segment<3>(Eigen::Index{3} * j));
    return each;
  };
  angles.turn = [spline, by_joint](double t) { return by_joint(spline->value(t)); };
  angles.rate = [spline, by_joint](double t) { return by_joint(spline->slope(t)); };
  return angles;
}

NodePath path_of(const System& system, const Solution& marched) {
  NodePath path;
  path.rotation = marched.rotation;
  path.position = marched.position;
  for (std::size_t k = 0; k < path.rotation.size(); ++k) {
    if (k > 0) cayley_between(path.rotation[k - 1], path.rotation[k], path.cayley.emplace_back());
    path.control.push_back(mechanics::along_actuation(
        system, mechanics::moments_of_applied(system, path.rotation[k], marched.control[k])));
  }
  return path;
}

}  // namespace

std::optional<NodePath> coasting(const System& system, const Problem& problem, const NodePath& guess, double share) {
  if (!follows_angles(problem.scheme)) return std::nullopt;
  Problem march = problem;
  march.steps = static_cast<int>(guess.rotation.size()) - 1;
  for (int n = 0; n <= halvings_of_turns; ++n, share *= 0.5) {
    const NodePath calm = calmed(system, guess, share);
    const Solution marched = march_along(system, march, angles_along(system, problem, calm));
    if (marched.rotation.size() == guess.rotation.size() && marched.status == Status::simulated)
      return path_of(system, marched);
  }
  return std::nullopt;
}

}  // namespace lamprey::guess
