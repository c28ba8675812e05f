// The full-resolution transcription of a maneuver as an optimizer::Program with exact first and second derivatives (chapter 5).
//
// Variables, for each step k: ω̃_i (F_i = cayley(h ω̃_i/2)), the next node's quaternions q_i and position x, and a control
// vector at each node (unit: control_unit N m). The six momentum equations stand in place of the root's balance, so no
// constraint is redundant; goal rows that momentum conservation or symmetry make dependent are dropped by rank.
#pragma once

#include <vector>

#include "maneuver/block_sink.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"
#include "mechanics/discrete_lagrangian_derivatives.hpp"
#include "optimizer/program.hpp"

namespace lamprey::maneuver {

/// One scalar end condition: 2 vec(q*_goal ∘ q_N)_c of a body, a coordinate of x_N, or a component of a body's end momentum.
struct GoalRow {
  enum class Kind { rotation, position, rest } kind;
  int body;       // of rotation and rest
  int component;  // 0, 1, 2
};

/// Every end condition a maneuver states, redundant ones included.
std::vector<GoalRow> stated_goal_rows(const model::System& system, const Maneuver& maneuver);

class Transcription : public optimizer::Program {
 public:
  Transcription(const model::System& system, const Maneuver& maneuver, std::vector<GoalRow> goal_rows);

  int variable_count() const override { return variable_count_; }
  int constraint_count() const override { return constraint_count_; }
  const VectorXd& constraint_lower() const override { return zero_; }
  const VectorXd& constraint_upper() const override { return zero_; }
  optimizer::StageOrder stages() const override;
  double objective(const VectorXd& x) override;
  void gradient(const VectorXd& x, VectorXd& g) override;
  void constraints(const VectorXd& x, VectorXd& c) override;
  const optimizer::SparsePattern& jacobian_pattern() const override { return jacobian_pattern_; }
  void jacobian(const VectorXd& x, VectorXd& values) override;
  const optimizer::SparsePattern& hessian_pattern() const override { return hessian_pattern_; }
  void hessian(const VectorXd& x, double factor, const VectorXd& multiplier, VectorXd& values) override;
  double goal_error(const VectorXd& x) override;

  /// The point of a motion; quaternions follow the motion without jumps of sign.
  VectorXd pack(const NodePath& path) const;
  NodePath unpack(const VectorXd& x) const;

  static constexpr double control_unit = 100.0;  // N m

 private:
  // positions of variables: control, turns, next quaternions, next position of each stage; then the last control; then the spline
  int turn_variable(int k, int body) const { return k * stage_size_ + controls_ + 3 * body; }
  int quaternion_variable(int node, int body) const {
    return (node - 1) * stage_size_ + controls_ + 3 * bodies_ + 4 * body;
  }
  int position_variable(int node) const { return (node - 1) * stage_size_ + controls_ + 7 * bodies_; }
  int control_variable(int node) const { return node * stage_size_; }
  int spline_variable() const { return steps_ * stage_size_ + controls_; }
  // positions of constraints: kinematics, momentum and balances of each stage; then the goal; then the spline
  int kinematic_row(int k, int body) const { return k * stage_rows_ + 4 * body; }
  int momentum_row(int k) const { return k * stage_rows_ + 4 * bodies_; }
  int balance_row(int node, int body) const { return node * stage_rows_ + 4 * bodies_ + 6 + 3 * (body - 1); }
  int goal_row() const { return steps_ * stage_rows_; }
  int spline_row() const { return goal_row() + static_cast<int>(goal_rows_.size()); }

  void lay_out();
  void lay_patterns();
  void move_to(const VectorXd& x);
  Eigen::Vector4d quaternion(int node, int body) const;
  Vector3d position(int node) const;
  mechanics::Moments moments(int node) const;
  mechanics::Rotations rotations(int node) const;
  double force_weight(int node) const { return node == 0 || node == steps_ ? 0.5 * h_ : h_; }
  bool balance_at(int node) const { return node < steps_ || rests_; }

  void emit_step_jacobian(int k, BlockSink& sink);
  void emit_kinematics(int k, BlockSink& sink) const;
  void emit_force_jacobian(int node, BlockSink& sink) const;
  void emit_goal_jacobian(BlockSink& sink) const;
  void emit_step_hessian(int k, const VectorXd& multiplier, BlockSink& sink);
  void expand_step(int k, const VectorXd& multiplier);
  void scatter_step_hessian(int k, const MatrixXd& local, BlockSink& sink) const;
  void add_kinematic_curvature(int k, const VectorXd& multiplier, MatrixXd& local) const;
  void emit_force_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const;
  mechanics::StepDirection direction_of(int k, const VectorXd& multiplier) const;
  Vector3d balance_multiplier(int node, int body, const VectorXd& multiplier) const;

  const model::System& system_;
  Maneuver maneuver_;
  std::vector<GoalRow> goal_rows_;
  int bodies_, steps_, controls_;
  double h_;
  bool rests_ = false;
  int stage_size_ = 0, stage_rows_ = 0, variable_count_ = 0, constraint_count_ = 0;
  std::vector<std::vector<char>> related_;  // [bodies][bodies] whether one is an ancestor of the other
  MatrixXd spline_basis_;                   // [N+1][points]
  VectorXd zero_;
  optimizer::SparsePattern jacobian_pattern_, hessian_pattern_;
  VectorXd point_;
  std::vector<mechanics::Interval> intervals_;
  std::vector<mechanics::DiscreteMomenta> momenta_;
  mechanics::DerivativeWorkspace work_;
  mechanics::StepQuadratic lagrangian_, directional_;
  mechanics::MomentumJacobian jacobian_;
};

}  // namespace lamprey::maneuver
