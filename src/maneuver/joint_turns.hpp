// Turns of the joints over a step as the moments see them, with first and second derivatives by the shapes at its ends
// (chapter 13, equations 13.1, 13.8 and 13.9).
#pragma once

#include "maneuver/shape_step.hpp"

namespace lamprey::maneuver {

/// One number for each moment along the joints' actuation: times a constant moment it is the work that the moment does.
class JointTurns {
 public:
  JointTurns(const model::System& system, const MatrixXd& shape_basis);

  int size() const { return static_cast<int>(moment_.size()); }
  int joint_of(int moment) const { return moment_[model::at(moment)].joint; }

  /// rad, [controls].
  void evaluate(const mechanics::Interval& interval, Eigen::Ref<VectorXd> turn) const;
  /// By the shapes (left, right), [controls][2 f].
  void derivative(const mechanics::Interval& interval, MatrixXd& rate) const;
  /// Adds the Hessian of pull·turn by the shapes along exponentials, [2 f] squared.
  void add_curvature(const mechanics::Interval& interval, const VectorXd& pull, MatrixXd& hessian) const;
  /// rad/s, [controls]: the joints' rates at a node with velocity ξ.
  VectorXd rates(const mechanics::Rotations& rotation, const VectorXd& velocity) const;

 private:
  struct Moment {
    int joint;
    Vector3d direction;  // as Joint::actuation has it
  };
  struct BallStep;
  /// How a body turns by the coordinates of the shape, body frame: [3][f].
  MatrixXd turns_of(const mechanics::Rotations& R, int body) const;

  const model::System& system_;
  MatrixXd shape_basis_;  // [shape_size][f]
  std::vector<Moment> moment_;
};

}  // namespace lamprey::maneuver
