// The paper's own method as an optimizer::Program: spline controls alone are variables, the motion is marched, gradients come
// from the adjoint. Very sensitive in space (chapter 5): from random starts it seldom arrives, so it begins at another's answer.
#pragma once

#include "integrator/step_derivatives.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

class Shooting : public optimizer::Program {
 public:
  /// The maneuver must have spline control.
  Shooting(const model::System& system, const Maneuver& maneuver, std::vector<GoalRow> goal_rows);

  int variable_count() const override { return points_ * controls_; }
  int constraint_count() const override { return static_cast<int>(goal_rows_.size()); }
  const VectorXd& constraint_lower() const override { return zero_; }
  const VectorXd& constraint_upper() const override { return zero_; }
  VectorXd constraint_units() const override;
  double objective(const VectorXd& x) override;
  void gradient(const VectorXd& x, VectorXd& g) override;
  /// Not a number where the march fails: solvers take a shorter step then.
  void constraints(const VectorXd& x, VectorXd& c) override;
  const optimizer::SparsePattern& jacobian_pattern() const override { return jacobian_pattern_; }
  void jacobian(const VectorXd& x, VectorXd& values) override;
  bool has_hessian() const override { return false; }
  const optimizer::SparsePattern& hessian_pattern() const override { return no_pattern_; }
  void hessian(const VectorXd&, double, const VectorXd&, VectorXd&) override {}
  double goal_error(const VectorXd& x) override;

  /// Spline values of a motion, and the motion marched under spline values.
  VectorXd pack(const NodePath& path) const;
  NodePath unpack(const VectorXd& x);

 private:
  VectorXd node_control(const VectorXd& x, int node) const;
  bool march(const VectorXd& x);
  MatrixXd end_rows() const;
  Eigen::Vector4d joint_error(int body) const;

  const model::System& system_;
  Maneuver maneuver_;
  double scale_;  // inertia_scale
  double unit_;   // N m, of the variables
  std::vector<GoalRow> goal_rows_;
  int points_, controls_;
  MatrixXd basis_;  // [N+1][points]
  VectorXd zero_;
  optimizer::SparsePattern jacobian_pattern_, no_pattern_;
  VectorXd point_;
  bool marched_ = false;
  NodePath path_;
  integrator::State end_;
};

}  // namespace lamprey::transcription
