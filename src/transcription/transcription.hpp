// The full-resolution transcription of a maneuver as an optimizer::Program with exact first and second derivatives (chapter 5).
//
// Variables, for each step k: ω̃_i (F_i = cayley(h ω̃_i/2)), the next node's quaternions q_i and position x, and at each node a
// control vector (in units of control_unit) and the moments of joints that lead their child. All bodies turn freely: what a joint
// holds are constraints, and the moments that hold it are variables. The six momentum equations stand in place of the root's
// balance, so no constraint is redundant; end conditions that momentum conservation or symmetry make dependent are dropped by
// rank. A free duration adds one variable, the logarithm of its stretch; a free start its quaternions.
#pragma once

#include <utility>
#include <vector>

#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"
#include "mechanics/discrete_lagrangian_derivatives.hpp"
#include "optimizer/program.hpp"
#include "shape/cost_terms.hpp"
#include "shape/limit_terms.hpp"
#include "transcription/block_sink.hpp"

namespace lamprey::transcription {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using maneuver::CostParts;
using maneuver::LimitedNode;
using maneuver::LimitRow;
using maneuver::Maneuver;
using maneuver::NodePath;
using shape::BallTurn;
using shape::LimitMultipliers;
using shape::NodePower;
using shape::WorkMultipliers;

/// One scalar end condition.
struct GoalRow {
  enum class Kind {
    rotation,  // 2 vec(q*_goal ∘ q_N)_c of a body
    position,  // a coordinate of x_N against the goal's
    rest,      // a component of a body's end momentum after the last moments' half impulse, kg m²/s
    closure,   // 2 vec(Q_0* ∘ Q_N)_c of a body seen from the root
    joint,     // 2 vec(Q*_goal ∘ Q_N)_c of a body seen from its parent
    recurrence  // a component of a body's momentum at the end against that at the start, each without its moments' half impulse
  } kind;
  int body;       // of all but position
  int component;  // 0, 1, 2
};

/// Moments that turn the whole about in the time, in units of 100 N m: 1 for the paper's swimmer.
double inertia_scale(const model::System& system, const Maneuver& maneuver);

/// Every end condition a maneuver states, redundant ones included.
std::vector<GoalRow> stated_goal_rows(const model::System& system, const Maneuver& maneuver);

class Transcription : public optimizer::Program {
 public:
  Transcription(const model::System& system, const Maneuver& maneuver, std::vector<GoalRow> goal_rows,
                std::vector<LimitRow> limits = {});

  int variable_count() const override { return variable_count_; }
  int constraint_count() const override { return constraint_count_; }
  const VectorXd& constraint_lower() const override { return lower_; }
  const VectorXd& constraint_upper() const override { return upper_; }
  /// Lengths in the swimmer's.
  VectorXd variable_units() const override;
  VectorXd constraint_units() const override;
  double objective(const VectorXd& x) override;
  void gradient(const VectorXd& x, VectorXd& g) override;
  void constraints(const VectorXd& x, VectorXd& c) override;
  const optimizer::SparsePattern& jacobian_pattern() const override { return jacobian_pattern_; }
  void jacobian(const VectorXd& x, VectorXd& values) override;
  const optimizer::SparsePattern& hessian_pattern() const override { return hessian_pattern_; }
  void hessian(const VectorXd& x, double factor, const VectorXd& multiplier, VectorXd& values) override;
  double goal_error(const VectorXd& x) override;

  /// Where the goal's rows begin among the constraints.
  int goal_row() const { return cost_row_ + cost_row_count(); }

  /// The point of a motion of this duration, s; 0: of the maneuver's. Quaternions follow the motion without jumps of sign,
  /// what holds joints follows from the motion.
  VectorXd pack(const NodePath& path, double duration = 0.0);
  NodePath unpack(const VectorXd& x) const;
  /// What the cost is made of, where more than effort and time is asked for.
  std::optional<CostParts> cost_parts(const VectorXd& x);
  /// The cost of a point's motion, in the units of the problem: where a search ends early the objective's own powers are not that.
  double cost(const VectorXd& x);
  /// s, of the motion.
  double duration(const VectorXd& x) const { return maneuver_.duration * stretch(x); }
  /// What the constraints' multipliers say about limits, as LimitTerms has it.
  LimitMultipliers limit_multipliers(const VectorXd& x, const VectorXd& multiplier);
  /// And about the signs of powers, as CostTerms has it.
  WorkMultipliers work_multipliers(const VectorXd& x, const VectorXd& multiplier) const;

  /// N m, of the control variables; (N m)² s, of the objective.
  double control_unit() const { return unit * scale_; }
  double cost_unit() const { return unit * scale_ * scale_; }

 private:
  // A limit at one node.
  struct Limited {
    std::size_t row;
    int node;
  };
  // A variable's vector that body coordinates of a node depend on: d(coordinates) = by_variable d(variable).
  struct Charted {
    int variable;
    Eigen::Index coordinate;
    MatrixXd by_variable;
    int node, body;  // of a quaternion, else −1
  };
  // A node as limits see it.
  struct Seen {
    mechanics::Rotations rotation, before;
    Vector3d position;
    VectorXd moment;
    LimitedNode node;
    Seen(const Transcription& from, int k);
    Seen(const Seen&) = delete;
    Seen& operator=(const Seen&) = delete;
  };

  // A step that a node's power sees, and whether it is before the node, −1, or after it, 1.
  struct StepAbout {
    int step;
    double side;
  };

  // Costs beside effort and time, weighted, in units of control_unit.
  struct OtherCosts {
    double work = 0.0, power = 0.0, smoothness = 0.0, angular_velocity = 0.0, transport = 0.0;
    double sum() const { return work + power + smoothness + angular_velocity + transport; }
  };

  // positions of variables: node, turns, next quaternions, next position of each stage; then the last node; then the shape at the
  // start; the stretch; those of costs; the spline. −1: given, or none
  int node_size() const { return controls_ + reactions_; }
  int turn_variable(int k, int body) const { return k * stage_size_ + node_size() + 3 * body; }
  int quaternion_variable(int node, int body) const {
    if (node == 0) return body > 0 && maneuver_.free_shape ? start_variable_ + 4 * (body - 1) : -1;
    return (node - 1) * stage_size_ + node_size() + 3 * bodies_ + 4 * body;
  }
  int position_variable(int node) const {
    return node == 0 ? -1 : (node - 1) * stage_size_ + node_size() + 7 * bodies_;
  }
  int control_variable(int node) const { return node * stage_size_; }
  int joint_turn_variable(int k, int moment) const { return joint_turn_variable_ + k * controls_ + moment; }
  int power_variable(int node, std::size_t powered) const { return place_of(power_variable_, node, powered); }
  int change_variable(int node, std::size_t powered) const { return place_of(change_variable_, node, powered); }
  int size_variable(int node, std::size_t powered) const { return place_of(size_variable_, node, powered); }
  int sign_variable(int node, std::size_t powered) const { return place_of(sign_variable_, node, powered); }
  double work_at(const VectorXd& x, int node, std::size_t powered) const {
    return 0.5 * x[size_variable(node, powered)] * (1.0 + std::pow(x[sign_variable(node, powered)], 2));
  }
  // A joint's places among a node's controls: the first, and how many.
  std::pair<int, int> controls_of(int joint) const {
    return {system_.joint(joint).first_control, static_cast<int>(system_.joint(joint).actuation.cols())};
  }
  int place_of(int first, int node, std::size_t powered) const {
    return first + node * static_cast<int>(powered_.size()) + static_cast<int>(powered);
  }
  int moment_variable(int node, int joint) const { return node * stage_size_ + moment_place_[model::at(joint)]; }
  // positions of constraints: kinematics, momentum, moments about axes, joints at the next node and balances of each stage; then
  // moments about axes at the end, or none through joints where nothing is asked of it; joints and lengths of quaternions at a free
  // start; moments of a periodic motion's ends; limits; costs; the goal; the spline
  int stage_row(int k) const { return k * stage_rows_ - (k > 0 && maneuver_.periodic ? 3 * (bodies_ - 1) : 0); }
  int kinematic_row(int k, int body) const { return stage_row(k) + 4 * body; }
  int momentum_row(int k) const { return stage_row(k) + 4 * bodies_; }
  int axis_row(int node) const { return stage_row(node) + (node < steps_ ? 4 * bodies_ + 6 : 0); }
  int joint_row(int node) const { return node == 0 ? start_row_ : momentum_row(node - 1) + 6 + axis_rows_; }
  int balance_row(int node, int body) const {
    return momentum_row(node) + 6 + axis_rows_ + joint_rows_ + 3 * (body - 1);
  }
  int length_row(int body) const { return start_row_ + joint_rows_ + body - 1; }
  int ends_row() const { return limit_row_ - (maneuver_.periodic ? free_.control_count() : 0); }
  int limit_row() const { return limit_row_; }
  int spline_row() const { return goal_row() + static_cast<int>(goal_rows_.size()); }

  void lay_out();
  void lay_patterns();
  void move_to(const VectorXd& x);
  double stretch(const VectorXd& x) const;
  double stretch() const { return stretch(point_); }
  Eigen::Vector4d quaternion(int node, int body) const;
  Vector3d position(int node) const;
  VectorXd controls(int node) const;
  mechanics::Moments moments(int node) const;
  mechanics::Rotations rotations(int node) const;
  double force_weight(int node) const { return node == 0 || node == steps_ ? 0.5 * h_ : h_; }
  bool balance_at(int node) const;
  std::vector<Vector3d> start_momenta() const;
  void pack_reactions(const NodePath& path, VectorXd& x) const;
  std::vector<std::pair<int, double>> end_force_rows(int node, int body, int component) const;

  double value_of(const GoalRow& row) const;
  Eigen::Vector4d end_of_joint(int body) const;
  int parent_of(int body) const { return system_.body(body).parent; }
  void emit_step_jacobian(int k, BlockSink& sink);
  void emit_kinematics(int k, BlockSink& sink) const;
  void emit_force_jacobian(int node, BlockSink& sink) const;
  void emit_goal_jacobian(BlockSink& sink) const;
  void emit_closure_jacobian(int constraint, const GoalRow& row, BlockSink& sink) const;
  void emit_joint_jacobian(int constraint, const GoalRow& row, BlockSink& sink) const;
  void emit_step_hessian(int k, const VectorXd& multiplier, BlockSink& sink);
  void expand_step(int k, const VectorXd& multiplier);
  void scatter_step_hessian(int k, const MatrixXd& local, BlockSink& sink) const;
  void add_kinematic_curvature(int k, const VectorXd& multiplier, MatrixXd& local) const;
  void emit_force_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const;
  void emit_closure_hessian(const VectorXd& multiplier, BlockSink& sink) const;
  void emit_joint_hessian(const VectorXd& multiplier, BlockSink& sink) const;
  std::optional<Eigen::Vector4d> pull_of_goal(GoalRow::Kind kind, int body, const VectorXd& multiplier) const;
  mechanics::StepDirection direction_of(int k, const VectorXd& multiplier) const;
  Vector3d balance_multiplier(int node, int body, const VectorXd& multiplier) const;

  // joints that lead their child (transcription_joints.cpp)
  int end_axis_rows() const { return rests_ ? axis_rows_ : reactions_; }
  void joint_values(int node, VectorXd& c) const;
  void axis_values(int node, VectorXd& c) const;
  void emit_joint_jacobian(int node, BlockSink& sink) const;
  void emit_axis_jacobian(int node, BlockSink& sink) const;
  void emit_joint_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const;
  void emit_axis_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const;

  // springs and dampers (transcription_compliance.cpp)
  // Whether the moment through a joint is more than what is actuated: a variable of its own.
  static bool carries(const model::Joint& joint) { return !joint.free() || compliant(joint); }
  static bool compliant(const model::Joint& joint) { return joint.stiffness > 0.0 || joint.damping > 0.0; }
  // A turn, rad, that the moment grows with: by how much, in units of control_unit for each rad; derivatives by turns of bodies.
  struct Compliance {
    double spring, damper;
    double turn;
    VectorXd gradient;
    MatrixXd hessian;
    std::vector<Charted> charts;
  };
  // Row: axis of a led joint, component of a ball joint's moment.
  std::vector<Compliance> compliance(int node, const model::Joint& joint, int row) const;
  double compliant_moment(int node, const model::Joint& joint, int row) const;
  void emit_compliance_jacobian(int constraint, int node, const model::Joint& joint, int row, BlockSink& sink) const;
  void emit_compliance_hessian(double lambda, int node, const model::Joint& joint, int row, BlockSink& sink) const;
  Matrix3d child_to_parent(int node, const model::Joint& joint) const;
  std::vector<Charted> charted_at(int node, const model::Joint& joint) const;

  // limits (transcription_limits.cpp)
  std::pair<int, int> limited_moments(const LimitRow& row) const;
  double value_of(const Limited& limited) const;
  std::vector<Charted> charted(const Limited& limited) const;
  void expand_limit(const Limited& limited, VectorXd& gradient, MatrixXd& hessian) const;
  static void emit_charted(int row, const VectorXd& gradient, const std::vector<Charted>& charts, BlockSink& sink);
  void emit_charted(double factor, const VectorXd& gradient, const MatrixXd& hessian,
                    const std::vector<Charted>& charts, BlockSink& sink) const;
  void emit_limit_jacobian(BlockSink& sink) const;
  void emit_limit_hessian(const VectorXd& multiplier, BlockSink& sink) const;

  // costs (transcription_costs.cpp)
  void lay_costs();
  int cost_row_count() const;
  double power_time(int node) const;
  std::vector<StepAbout> steps_about(int node) const;
  NodePower joint_rate(int node, int moment) const;
  BallTurn turn_over(int k, const model::Joint& joint) const;
  std::vector<Charted> charted(int k, const model::Joint& joint) const;
  OtherCosts other_costs(const VectorXd& x) const;
  double rate_weight(double stretch) const;
  double won(const VectorXd& x) const;  // by the displacement, in units of cost_unit
  void add_cost_gradient(const VectorXd& x, VectorXd& g) const;
  void emit_cost_hessian(double factor, BlockSink& sink) const;
  void emit_work_hessian(double factor, int node, std::size_t powered, BlockSink& sink) const;
  void cost_values(VectorXd& c) const;
  void emit_cost_rows_jacobian(BlockSink& sink) const;
  void emit_cost_rows_hessian(const VectorXd& multiplier, BlockSink& sink) const;
  void pack_costs(VectorXd& x);

  // Numbers of order one for a swimmer of this inertia in this time: rows see moments over scale_, on bodies so much lighter.
  static constexpr double unit = 100.0;  // N m

  const model::System& system_;
  double scale_;
  model::System free_;  // its bodies on ball joints, 1/scale_ times as heavy
  Maneuver maneuver_;
  std::vector<GoalRow> goal_rows_;
  std::vector<LimitRow> limits_;
  std::vector<Limited> limited_;
  int bodies_, steps_, controls_;
  double h_;
  bool rests_ = false;
  int reactions_ = 0;  // moments of joints that carry more than what is actuated, at a node
  std::vector<int>
      moment_place_;  // [joints] where a joint's moment begins at a node: its controls, or all three of one that carries more
  int axis_rows_ = 0, joint_rows_ = 0;  // at a node
  int stage_size_ = 0, stage_rows_ = 0, start_variable_ = 0, stretch_variable_ = -1, spline_variable_ = 0;
  std::vector<int> powered_;  // joints with moments, where powers cost
  bool worked_ = false;       // whether work does
  int joint_turn_variable_ = -1, power_variable_ = 0, change_variable_ = 0, size_variable_ = 0, sign_variable_ = 0;
  int whole_variable_ = -1;
  VectorXd start_rate_;  // [controls] rad/s, of the joints at the start
  int start_row_ = 0, limit_row_ = 0, cost_row_ = 0, variable_count_ = 0, constraint_count_ = 0;
  std::vector<std::vector<char>> related_;  // [bodies][bodies] whether one is an ancestor of the other
  std::vector<Vector3d> start_momentum_;    // [bodies] kg m²/s, body frames
  MatrixXd spline_basis_;                   // [N+1][points]
  VectorXd lower_, upper_;
  optimizer::SparsePattern jacobian_pattern_, hessian_pattern_;
  VectorXd point_;
  std::vector<mechanics::Interval> intervals_;
  std::vector<mechanics::DiscreteMomenta> momenta_;
  mechanics::DerivativeWorkspace work_;
  mechanics::StepQuadratic lagrangian_, directional_;
  mechanics::MomentumJacobian jacobian_;
};

}  // namespace lamprey::transcription
