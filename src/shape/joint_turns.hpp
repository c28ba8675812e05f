// Turns of the joints over a step as the moments see them, with first and second derivatives by the shapes at its ends
// (chapter 13, equations 13.1, 13.10 and 13.11).
#pragma once

#include "shape/shape_turns.hpp"

namespace lamprey::shape {

/// A joint's turn over a step, ψ = log(Q'Qᵀ): the child's as the parent sees it, where the attitude at either end shows it
/// alike; with derivatives by turns of its bodies, body frames along exponentials: (parent, child) before, then after the step.
class BallTurn {
 public:
  /// Q = R_pᵀR_c before and after.
  BallTurn(const Matrix3d& before, const Matrix3d& after);

  const Vector3d& psi() const { return psi_; }  // rad, parent's frame
  /// Rate of ψ.
  Eigen::Matrix<double, 3, 12> derivative() const;
  /// Hessian of pull·ψ.
  Eigen::Matrix<double, 12, 12> curvature(const Vector3d& pull) const;

 private:
  Matrix3d before_, after_, turn_;  // Q, Q', Q'Qᵀ
  Vector3d psi_;
  Matrix3d tangent_;
};

/// One number for each moment along the joints' actuation: times a constant moment it is the work that the moment does.
class JointTurns {
 public:
  JointTurns(const model::System& system, const MatrixXd& shape_basis);

  int size() const { return static_cast<int>(moment_.size()); }
  int joint_of(int moment) const { return moment_[model::at(moment)].joint; }

  /// rad, [controls].
  void evaluate(const mechanics::Interval& interval, Eigen::Ref<VectorXd> turn) const;
  /// By the shapes (left, right), [controls][2 f].
  void derivative(const mechanics::Interval& interval, MatrixXd& rate);
  /// Adds the Hessian of pull·turn by the shapes along exponentials, [2 f] squared.
  void add_curvature(const mechanics::Interval& interval, const VectorXd& pull, Eigen::Ref<MatrixXd> hessian);
  /// rad/s, [controls]: the joints' rates at a node with velocity ξ.
  VectorXd rates(const mechanics::Rotations& rotation, const VectorXd& velocity) const;

 private:
  struct Moment {
    int joint;
    Vector3d direction;  // as Joint::actuation has it
  };
  void turns_of_bodies(const mechanics::Interval& interval, const model::Joint& joint);

  const model::System& system_;
  MatrixXd shape_basis_;  // [shape_size][f]
  std::vector<Moment> moment_;
  ShapeTurns turns_;
  // workspace
  MatrixXd joint_rate_;  // [3][2 f]
  MatrixXd of_bodies_,
      transposed_;  // [12][2 f] turns of (parent, child) before, then after the step, and its transpose
  MatrixXd bent_;   // [12][2 f]
  VectorXd pull_left_, pull_right_;  // [3 bodies]
};

}  // namespace lamprey::shape
