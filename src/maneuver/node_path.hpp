// Nodes of a motion, whatever found it.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "lie/so3.hpp"
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

/// ζ of all bodies between two nodes.
inline void cayley_between(const mechanics::Rotations& from, const mechanics::Rotations& to,
                           mechanics::Vectors& cayley) {
  cayley.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) cayley[i] = lie::inverse_cayley(from[i].transpose() * to[i]);
}

/// Where a node lies on another grid over the same time: a share of the way from node `left` to the next.
struct GridPlace {
  int left;
  double share;
};

inline GridPlace place_on_grid(int node, int steps, int other_steps) {
  const double place = static_cast<double>(node) * other_steps / steps;
  const int left = std::min(static_cast<int>(place), other_steps - 1);
  return {left, place - left};
}

}  // namespace lamprey::maneuver
