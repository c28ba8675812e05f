// Newton's linear system of a step, p⁻ and p_x by the next node, eliminated from the leaves to the root in linear time.
#pragma once

#include <vector>

#include "mechanics/discrete_lagrangian_derivatives.hpp"

namespace lamprey::integrator {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What elimination leaves of a body's subtree, seen from its joint (equation 4.17).
struct TreeNewtonWorkspace {
  struct Node {
    Matrix3d force_by_joint;  // Φ: linear momentum of the subtree by the joint's displacement
    Vector3d force;           // ψ: the part that the residuals fix
    Matrix3d turn_by_joint;   // −dη'/dJ
    Vector3d turn;            // η' at rest of the joint
  };
  std::vector<Node> nodes;                  // [bodies]
  std::vector<Vector3d> centre_correction;  // [bodies] m, world
  explicit TreeNewtonWorkspace(int bodies);
};

/// Solves for the body-side corrections η'_i and the correction of Δx that cancel the given residuals to first order.
/// `missing` holds target − p⁻ for each body, `missing_linear` target − p_x. Returns false where a pivot is singular.
bool solve_tree_newton(const model::System& system, mechanics::DiscreteLagrangian lagrangian, double time_step,
                       const mechanics::Interval& interval, const std::vector<Vector3d>& missing,
                       const Vector3d& missing_linear, TreeNewtonWorkspace& work, std::vector<Vector3d>& turns,
                       Vector3d& shift);

}  // namespace lamprey::integrator
