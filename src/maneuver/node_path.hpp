// Nodes of a motion, whatever found it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "mechanics/tree_motion.hpp"

namespace lamprey::maneuver {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Nodes of a motion: what guesses are made of and what solutions are read from.
struct NodePath {
  std::vector<mechanics::Rotations> rotation;  // [N+1][bodies]
  std::vector<Vector3d> position;              // [N+1] m
  std::vector<std::vector<Vector3d>> cayley;   // [N][bodies] ζ: R_{k+1} = R_k cayley(ζ)
  std::vector<VectorXd> control;               // [N+1][control_count] N m, along the joints' actuation columns
};

}  // namespace lamprey::maneuver
