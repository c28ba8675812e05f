// Nodes of a motion, whatever found it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "mechanics/tree_motion.hpp"

namespace lamprey::maneuver {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Nodes of a motion: what guesses are made of and what solutions are read from. By schemes above order 2 the nodes are
/// those of all stages, N = steps · stages.
struct NodePath {
  std::vector<mechanics::Rotations> rotation;  // [N+1][bodies]
  std::vector<Vector3d> position;              // [N+1] m
  std::vector<std::vector<Vector3d>> cayley;   // [N][bodies] ζ: R_{k+1} = R_k cayley(ζ)
  std::vector<VectorXd> control;               // [N+1][control_count] N m, along the joints' actuation columns
  /// Above order 2 alone: [steps][terms · control_count] coefficients of the moments in each step (step_polynomial.hpp);
  /// where two steps meet, `control` is the mean of both.
  std::vector<VectorXd> polynomial;
};

}  // namespace lamprey::maneuver
