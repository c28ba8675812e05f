// A hull with two pairs of paddles on hinges, that shall turn.
#pragma once

#include <array>

#include "maneuver/problem.hpp"

namespace lamprey::tests {

/// `turn`: rad about e_3, in 20 s.
inline maneuver::Problem hull_with_paddles(double turn) {
  using Eigen::Vector3d;
  maneuver::Problem problem;
  problem.swimmer.density = 1000.0;
  problem.swimmer.bodies.resize(5);
  const std::array names = {"hull", "fl", "fr", "rl", "rr"};
  for (std::size_t i = 0; i < 5; ++i) {
    problem.swimmer.bodies[i].name = names[i];
    problem.swimmer.bodies[i].semi_axes = i == 0 ? Vector3d(0.5, 0.12, 0.12) : Vector3d(0.02, 0.15, 0.05);
    if (i == 0) continue;
    const double side = i % 2 == 1 ? 1.0 : -1.0;
    model::JointDescription joint;
    joint.name = names[i];
    joint.kind = model::JointKind::hinge;
    joint.parent = "hull";
    joint.child = names[i];
    joint.parent_offset = Vector3d(i < 3 ? 0.3 : -0.3, 0.13 * side, 0.0);
    joint.child_offset = Vector3d(0.0, -0.16 * side, 0.0);
    joint.axis = Vector3d(0, 0, 1);
    problem.swimmer.joints.push_back(joint);
  }
  problem.start.rotation.assign(5, Vector3d::Zero());
  problem.start.angular_velocity.assign(5, Vector3d::Zero());
  problem.goal = maneuver::Goal();
  problem.goal->turn = Vector3d(0.0, 0.0, turn);
  problem.duration.value = 20.0;
  return problem;
}

}  // namespace lamprey::tests
