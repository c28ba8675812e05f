// From derivatives by the root's pose at the beginning of a step to those by its pose at the end, which is a stage's state.
#pragma once

#include "shape/shape_step.hpp"

namespace lamprey::shape {

/// What a root, turned so and at `place` from where angular momentum is about, sees of total momentum about itself (equation 9.34).
Vector6d seen_from_root(const mechanics::SpatialMomentum& total, const Matrix3d& root, const Vector3d& place);

/// How what a root sees of total momentum answers to its world turn and position (equation 9.35): angular momentum about it and linear
/// momentum, both in the world.
Matrix6d seen_by_pose(const Matrix3d& root, const Vector3d& angular, const Vector3d& linear);

/// Second derivative of spin · (angular) + push · (linear), of what a root sees of total momentum (equation 9.36), by its world turn
/// and position; all four in the world, angular momentum about the root.
Matrix6d bend_of_seen(const Vector3d& spin, const Vector3d& push, const Vector3d& angular, const Vector3d& linear);

/// How the root's pose at the end of a step by `displacement` answers to that at its beginning where nothing else changes.
Matrix6d carried_pose(const Vector3d& displacement);

/// A step's Hessian by (left shape, right shape, root's world turn at its beginning), [2 f + 3] squared, becomes that by the
/// turn at its end, which is the one at its beginning and what the step adds.
void turn_at_end(const ShapeTangent& tangent, MatrixXd& hessian);

/// The same where momentum is carried: derivatives by (left shape, right shape, root's world turn and position, in free time the
/// logarithm of what is carried) of a step that moves the root by `displacement`, and E⁺ with them.
class PoseAtEnd {
 public:
  /// `shapes`: 2 f; d: as of ShapeTangent.
  PoseAtEnd(Eigen::Index shapes, Eigen::Index d) : shapes_(shapes), before_(d, d), half_(d, d) {}
  /// Takes over how the pose at the end follows from that at the beginning.
  void take(const ShapeTangent& tangent, const Vector3d& displacement);
  void turn(MatrixXd& hessian);
  void turn_rows(MatrixXd& rows);

 private:
  Eigen::Index shapes_;
  MatrixXd before_;  // [d][d] shapes and the pose at the beginning by shapes and the pose at the end
  MatrixXd half_;
};

}  // namespace lamprey::shape
