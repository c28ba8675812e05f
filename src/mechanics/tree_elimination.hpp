// Linear systems on a tree of bodies, eliminated from the leaves to the root in linear time: what moments along the
// freedoms at one node the turns and displacements at another node make (equations 8.20 to 8.26).
#pragma once

#include <vector>

#include "mechanics/rows.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::mechanics {

/// What one body's own motion does: moment about its mass centre and force by its turn and its centre's displacement.
struct BodyBlock {
  Matrix3d moment_by_turn;   // left body frame by right body frame
  Matrix3d moment_by_shift;  // left body frame by world
  Matrix3d force_by_turn;    // world by right body frame
  Matrix3d force_by_shift;   // world by world
};

/// Factors and solves K y = r. Trial motions y turn the bodies at the right node, balances r are along the freedoms at
/// the left node; both may be the same node. No allocation after construction.
class TreeElimination {
 public:
  explicit TreeElimination(const model::System& system);

  /// blocks [bodies], used up; `damping` [bodies]: moment along a body's freedoms by its turn against its parent, or empty.
  /// Returns false where a pivot is singular or not finite.
  bool factor(const model::System& system, const Rotations& left, const Rotations& right,
              std::vector<BodyBlock>& blocks, const std::vector<Matrix3d>& damping);

  /// K y = r: balances become motions, in place. Rotations are those of factor.
  void solve(const model::System& system, const Rotations& left, const Rotations& right, Freedoms& freedoms,
             Vector3d& linear);

  /// Kᵀ w = s: s along the freedoms at the right node becomes w along those at the left node.
  void solve_transposed(const model::System& system, const Rotations& left, const Rotations& right, Freedoms& freedoms,
                        Vector3d& linear);

  /// solve for many right-hand sides, rows of each [rows][3].
  void solve_rows(const model::System& system, const Rotations& left, const Rotations& right, FreedomRows& freedoms,
                  Rows3& linear);

 private:
  // A body seen from its joint (the root: from its mass centre), its subtree condensed.
  struct Node {
    Matrix3d inverse;        // free: of moment_by_turn about the joint; led: of the pivot
    Matrix3d turn_by_shift;  // free: inverse · moment_by_shift
    Matrix3d force_by_rest;  // free: force_by_turn · inverse
    bool led;                // by its joint, or damped
  };
  struct LedNode {
    BodyBlock at_joint;
    JointFrame left, right;
    Matrix3d left_axes, right_axes;
  };
  struct Walk {
    Vector3d moment, force;  // what eliminated balances leave
    Vector3d turn, shift;    // of the body and of its joint
  };
  /// Transposed, the two ends of the step change places and every block is its transpose.
  template <bool transposed>
  void solve_tree(const model::System& system, const Rotations& near, const Rotations& far, Freedoms& freedoms,
                  Vector3d& linear);
  bool eliminate(const model::System& system, const Rotations& left, const Rotations& right,
                 std::vector<BodyBlock>& condensed, const std::vector<Matrix3d>& damping, int body);

  std::vector<Node> nodes_;             // [bodies]
  std::vector<LedNode> led_nodes_;      // [bodies], or empty where all turn on their own, undamped
  std::vector<Walk> walk_;              // [bodies]
  FreedomRows row_moment_, row_force_;  // [bodies], of solve_rows; sized by its first call
  Eigen::Matrix<double, 6, 6> root_inverse_;
};

}  // namespace lamprey::mechanics
