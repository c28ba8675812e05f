// A maneuver in the shapes of its nodes alone (chapter 9): total momentum fixes the root's motion, inverse dynamics the
// moments, so that every point of the search is a motion of the swimmer and only the goal remains to be met. As an optimizer::StageProgram: state s_k = (shape k − 1, shape k, root's turn ρ and position χ in the
// world), input = shape k + 1 where moments can take the joints anywhere and cost effort alone, else moments along the joints'
// actuation at node k. A free duration adds its logarithm τ to the state, a
// periodic motion its first two shapes; stages before the first step set them (chapter 10). Costs beside effort may add more
// states (chapter 13).
#pragma once

#include "maneuver/end_rows.hpp"
#include "maneuver/node_path.hpp"
#include "mechanics/compliant_time.hpp"
#include "mechanics/resting_joints.hpp"
#include "optimizer/stage_program.hpp"
#include "shape/cost_terms.hpp"
#include "shape/four_steps.hpp"
#include "shape/limit_terms.hpp"
#include "shape/moment_basis.hpp"
#include "shape/pose_at_end.hpp"

namespace lamprey::shape {

using maneuver::EndCurvature;
using maneuver::EndRow;
using maneuver::limit_rows;
using maneuver::NodePath;

/// Faithful steps show motions alone: beyond a quarter turn of a body in one step momentum falls as the turn grows, and half
/// a turn carries none. Rough ones are few and long, and a search may pass through such turns.
enum class Steps { faithful, rough };

class ShapeProgram : public optimizer::StageProgram {
 public:
  /// Control is free at each node. A start that carries total momentum is not for rest and periodic goals.
  ShapeProgram(const model::System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
               std::vector<EndRow> end_rows, std::vector<LimitRow> limits = {}, Steps use = Steps::faithful);

  /// Takes over another start, other targets of the end rows and another duration, of as many steps and the same kind; a start may
  /// carry momentum where the first one does. A motion there is gets measured anew by them; where start or duration differ go_to must follow.
  void retarget(const Maneuver& maneuver);

  /// Goes to a motion: its shapes and, as a first guess, its root's motion. Returns false where none is found.
  bool go_to(const NodePath& path);
  NodePath path() const;
  /// The same into a path of the program's size, without allocation.
  void write_path(NodePath& path) const;
  /// Whether its first start carries total momentum, and others may.
  bool carries_momentum() const { return drifts_; }
  /// The root's turns (rad, world) and displacements (m) that moments change, orthonormal columns.
  const MatrixXd& pose_basis() const { return pose_basis_; }
  double duration() const { return h_ * now_.stretch * steps_; }
  /// Starts from another duration, where it is free. Before go_to.
  void take_duration(double duration) { now_.stretch = duration / (h_ * steps_); }
  /// Takes over other bounds of a free duration, s. Before go_to.
  void bound_duration(double least, double most) { limits_.bound_duration(least, most); }
  /// The cost by its rule, without what limits add.
  double cost() const override { return now_.cost; }
  /// What it is made of, before weighting.
  CostParts cost_parts() const;

  /// Takes over the end rows' multipliers, of any grid; empty: none. Before go_to.
  void take_end_multipliers(const VectorXd& multipliers) { end_start_ = multipliers; }
  const VectorXd& end_multipliers() const { return end_multiplier_; }
  /// Takes over limits' multipliers, of any grid; empty ones before a first search. Before go_to.
  void take_limit_multipliers(const LimitMultipliers& multipliers) { limit_start_ = multipliers; }
  const LimitMultipliers& limit_multipliers() const { return limits_.multipliers(); }
  LimitError worst_limit() const { return limits_.error(now_.limit_value); }
  void take_work_multipliers(const WorkMultipliers& multipliers) { work_start_ = multipliers; }
  const WorkMultipliers& work_multipliers() const { return terms_.multipliers(); }
  const std::vector<LimitRow>& limit_rows() const { return limits_.rows(); }
  /// Values of the limits' rows at the trial point, [rows][N + 1].
  const MatrixXd& trial_limit_values() const { return trial_.limit_value; }
  /// Moments at the trial point's nodes, actuated ones, then idle ones, [N + 1][f] N m.
  const std::vector<VectorXd>& trial_moments() const { return trial_.moment; }
  /// What they change by along a step, to first order; 0 of rows that do not pull.
  const MatrixXd& limit_changes(const optimizer::StageStep& step) {
    foresee_limits(step);
    return limits_.changes();
  }
  /// Largest miss of all conditions that the goal states, those that follow from others included; units of the end rows.
  double stated_goal_error() { return worst_stated().value; }
  /// And which it is, in words.
  std::string stated_goal_miss();
  /// The end row that is missed most, in words; empty where the goal is met.
  std::string largest_miss() const;
  /// The limit that is broken most, in words; empty where all are kept. `cut_short`: the search could not go on to keep it.
  std::string largest_violation(bool cut_short) const;

  optimizer::StageSizes sizes() const override;
  const optimizer::Merit& merit() const override { return now_.merit; }
  bool has_multipliers() const override { return end_start_.size() == end_multiplier_.size() && idle() == 0; }
  void linearize(optimizer::StageModel& model) override;
  /// For effort alone, without momentum, limits, free durations, idle joints and periodic goals.
  bool differentiate(optimizer::StageSlopes& slopes) override;
  const optimizer::Merit* try_step(const optimizer::StageStep& step, double length) override;
  const VectorXd& end_rows() const override { return now_.end_rows; }
  const VectorXd& trial_end_rows() const override { return trial_.end_rows; }
  void accept() override { std::swap(now_, trial_); }
  bool takes_costates() const override { return idle() > 0; }
  void take_multipliers(const optimizer::StageStep& step, double length) override;
  double longest(const optimizer::StageStep& step, const optimizer::Promise& promise) override;
  double idle_violation() const override { return idle_violation_; }
  double goal_error() const override;
  double drift() const override { return momentum_left(system_, now_.step, now_.rotation, now_.position, total_); }
  bool limited() const override { return !limits_.empty() || terms_.of_work(); }
  double limit_error() const override {
    return std::max(limits_.empty() ? 0.0 : worst_limit().value, terms_.error(now_.terms));
  }
  double limit_violation() const override { return limits_.empty() ? 0.0 : worst_limit().value; }
  void renew_limits(bool heavier) override;
  bool pulled_as_answer() const override { return limits_.pull_as_answer(); }
  bool ease_limits(double times) override;
  bool bend_limits(const optimizer::StageStep& step, double length, optimizer::StageModel& model) override;
  void unbend_limits(optimizer::StageModel& model) override { add_limit_bends(-1.0, model); }
  bool has_gaps() const override { return idle() > 0; }
  void bend_gaps(double length, optimizer::StageModel& model) override;
  void unbend_gaps(optimizer::StageModel& model) override;
  bool land() override;
  bool landed() const override { return limits_.landed(); }
  void take_off() override;
  void keep_worth() override;
  void take_kept_worth() override;
  void weigh_landed(double times) override;

 private:
  // A motion through given shapes.
  struct Motion {
    double stretch = 1.0;                        // of the time step, exp(τ)
    std::vector<mechanics::Rotations> shape;     // [N + 1][bodies] seen from the root
    std::vector<mechanics::Rotations> rotation;  // [N + 1][bodies] body → world
    mechanics::Vectors position;                 // [N + 1] m, root, world
    std::vector<ShapeStep> step;                 // [N]
    // [N + 1][f][f] impulse along the coordinates by moments, N m s/(N m); joint_by_joint: at the end alone
    std::vector<MatrixXd> impulse;
    std::vector<VectorXd> moment;  // [N + 1][f] N m by inverse dynamics: actuated ones, then idle ones
    VectorXd end_rows;
    MatrixXd limit_value;  // [limits][N + 1]
    CostValues terms;      // of costs beside effort and time
    double cost = 0.0;     // by its rule alone
    optimizer::Merit merit;
  };
  // What the root's pose at the beginning of a step that carries momentum changes.
  struct PoseStep {
    Matrix6d pose;    // at the end
    Vector6d moment;  // of the Lagrangian, by what it takes of moments at both ends
  };
  // A node's part in the model.
  struct NodeModel {
    MatrixXd control_by_shape;  // [controls][f] second derivative of the Lagrangian by controls and shape
    VectorXd multiplier;        // [f] of the balance of impulses at the node
    VectorXd by_control;        // [controls] derivative of the cost, limits included
    MatrixXd by_control_twice;  // [controls] squared
    mechanics::Moments control;
    NodeModel(const model::System& system, int shape);
  };

  void take_start_impulse();
  void find_idle_violation();
  bool roll_out(Motion& motion);
  bool solve_step(int k, Motion& motion);
  void measure(Motion& motion);
  void weigh_idle(Motion& motion) const;
  void impulse_by_moments(const Motion& motion, int node, MatrixXd& impulse);
  void model_node(int k, NodeModel& node);
  void model_controls(int k, NodeModel& node);
  void solve_moments(VectorXd& values);
  Vector6d spread_pose(const Eigen::Ref<const VectorXd>& pose) const;
  const VectorXd& spread_shape(double factor, const Eigen::Ref<const VectorXd>& shape);
  void model_impulses_in_time(int k, const NodeModel& node, const NodeModel& next, MatrixXd& Q);
  void along_shape(const mechanics::Freedoms& freedoms, VectorXd& shape);
  void find_end_moments_by_duration();
  void model_duration(int k, const NodeModel& node, optimizer::Stage& stage);
  void add_duration(const NodeModel& node, const VectorXd& moment, double weight, MatrixXd& Q, VectorXd& q);
  void add_effort_mixed(const NodeModel& node, const VectorXd& moment, int place, MatrixXd& Q);
  void carry_on(int k, MatrixXd& A) const;
  void add_limit_models(optimizer::StageModel& model) const;
  bool solve_four(int first, Motion& motion);
  void follow_root(int k, Motion& motion) const;
  void differentiate_four(int first, optimizer::StageModel* model);
  void turn_to_end(const ShapeStep& step, ShapeTangent& tangent, MatrixXd& hessian);
  void add_carried_in_time(const ShapeMultipliers& multipliers, const ShapeTangent& tangent, MatrixXd& hessian);
  MatrixXd& end_form(int k, optimizer::StageModel& model) const;
  void add_effort(int first, std::vector<optimizer::Stage>& stages);
  void add_effort(int first, std::vector<optimizer::StageSlopes::Slope>& stages);
  template <typename Stages>
  void add_effort_of_four(int first, Stages& stages);
  ForFour<NodeEffort> node_efforts(int first) const;
  void model_step(int k, const NodeModel& node, const NodeModel& next, optimizer::StageModel& model);
  void model_motion(int k, MatrixXd& A, MatrixXd& B);
  void find_impulses_by_pose(int k, Eigen::Ref<MatrixXd> impulses);
  void model_pose_by_shapes(int k, MatrixXd& A, MatrixXd& B);
  void find_moments_by_shapes(int k);
  void model_stage_by_shapes(int k, const NodeModel& node, optimizer::Stage& stage);
  void model_stage(int k, const NodeModel& node, optimizer::Stage& stage);
  void model_first_shapes(optimizer::Stage& stage);
  void model_leads(optimizer::StageModel& model) const;
  void find_end_moments_by_state();
  double value_of(const EndRow& row, const Motion& motion);
  struct Miss {
    double value = 0.0;   // units of the row
    std::size_t row = 0;  // of stated_rows_
  };
  Miss worst_stated();
  void model_end(const NodeModel& node, optimizer::StageModel& model);
  void add_displacement(VectorXd& gradient) const;
  void model_goal(MatrixXd& C, VectorXd& c);
  void model_limits();
  void foresee_limits(const optimizer::StageStep& step);
  void foresee_moments(int k, const optimizer::StageStep& step);
  void add_gap(int k, const Eigen::Ref<const VectorXd>& idle_moment, optimizer::Stage& stage) const;
  void add_limit_bends(double factor, optimizer::StageModel& model);
  void lay_pose_multipliers(const optimizer::StageModel& model);
  void learn_pulls_of_carried(int first);
  void take_total();
  Vector6d total_at_end(const Motion& motion) const;
  Vector3d angular_about_end() const;
  void add_carried_at_end(const Motion& motion, VectorXd& moment);
  void find_carried_at_end();
  void pull_carried_at_end(const VectorXd& multiplier);
  void see_by_pose(const MatrixXd& by_total);
  void add_carried_curvature(const VectorXd& multiplier, MatrixXd& Q);
  LimitedNode limited_node(const Motion& motion, int k) const;
  void add_limits(Motion& motion);
  double won(const Motion& motion) const;  // (N m)² s, by the displacement
  double cost_of_time(const Motion& motion) const;
  double spent(const Motion& motion) const;
  CostedMotion costed(const Motion& motion) const;
  void add_terms(Motion& motion);
  double worth_of_moments() const;
  void prepare_terms(optimizer::StageModel& model);
  void add_term_models(optimizer::StageModel& model);
  double at_once(const Motion& motion) const;
  double least_moment() const;  // N m, that the cost's gradient counts with at least
  double impulse_time(const Motion& motion, int node) const {
    return (node == 0 || node == steps_ ? 0.5 : 1.0) * h_ * motion.stretch;
  }
  double node_weight(const Motion& motion, int node) const { return maneuver_.node_weight[node] * motion.stretch; }
  int tau() const { return 2 * shape_ + pose_; }                            // its place in a state
  int copies() const { return tau() + (maneuver_.free_duration ? 1 : 0); }  // likewise of the first two shapes
  int own_states() const { return copies() + (maneuver_.periodic ? 2 * shape_ : 0); }
  int states() const { return own_states() + terms_.states(); }
  int limited_states() const {
    return maneuver_.free_duration ? tau() + 1 : tau();
  }  // first of a state, that limits see
  // What a step's derivatives are by beside its shapes: of the root's pose its turn at least, of time what is carried.
  int step_columns() const { return !drifts_ ? 3 : drifts_in_free_time() ? 7 : 6; }
  bool drifts_in_free_time() const { return drifts_ && maneuver_.free_duration; }
  TotalMomentum carries() const {
    if (!drifts_) return TotalMomentum::zero;
    return drifts_in_free_time() ? TotalMomentum::any_in_free_time : TotalMomentum::any;
  }
  // States that a node's moments depend on: shapes, and the root's pose, which says what momentum a step carries.
  int felt() const { return 2 * shape_ + (drifts_ ? pose_ : 0); }
  // Whether a node's moments follow from the last state: a periodic motion begins with those of its end.
  bool of_the_end(int k) const { return k == steps_ || (k == 0 && maneuver_.periodic); }
  int idle() const { return shape_ - controls_; }
  int first_idle_node() const { return maneuver_.periodic ? 1 : 0; }  // the first of a periodic motion is the last
  // Whether more than the root's motion is asked of a step.
  bool wants_intervals() const { return !terms_.empty() || compliant_time_; }
  bool keeps_roots_alone() const { return four_steps_ && use_ == Steps::faithful && !wants_intervals(); }
  bool by_shapes() const { return idle() == 0 && terms_.empty() && !maneuver_.free_duration && !maneuver_.periodic; }
  // Where the pose's first coordinates are the root's turn, four steps write their Hessians where the model wants them.
  bool hessians_in_place() const { return four_steps_ && all_poses_; }
  bool joint_by_joint() const { return moments_.joint_by_joint() && effort_in_fours(); }
  bool effort_in_fours() const {
    return four_steps_ && four_steps_->takes_effort() && by_shapes() && !limits_.of_moments();
  }

  const model::System& system_;
  Maneuver maneuver_;
  std::vector<EndRow> end_rows_;
  std::vector<EndRow> stated_rows_;    // dependent ones too
  MatrixXd shape_basis_, pose_basis_;  // [shape_size][f], [6][p]
  bool all_shapes_, all_poses_;        // whether they are identities
  int steps_;
  Steps use_;
  bool drifts_;                       // whether total momentum may be carried
  mechanics::SpatialMomentum total_;  // what is, about the root's first place
  double begun_ = 0.0;                // kg m²/s, of bodies at a start in motion
  int shape_, pose_, controls_;
  CostTerms terms_;
  int leads_;  // stages before the first step
  double h_;
  double turned_inertia_;  // kg m², the largest about the root
  ShapeKernel kernel_;
  std::optional<FourSteps> four_steps_;                     // where it serves
  std::optional<mechanics::CompliantTime> compliant_time_;  // of springs and dampers where the duration is free
  MomentBasis moments_;
  EndCurvature end_curvature_;
  LimitTerms limits_;
  std::optional<LimitMultipliers> limit_start_;  // for the next go_to
  WorkMultipliers work_start_;                   // likewise
  std::vector<LimitModel> limit_model_;          // [N + 1]
  // [N][controls][f + s] by the s first states, which they feel, and shape k + 1, where limits are of moments
  std::vector<MatrixXd> moments_of_stage_;
  mechanics::Vectors pose_turn_, pose_shift_;  // [N + 1] multipliers of the root's pose at the nodes, world
  Motion now_, trial_;
  Motion aloft_;  // from where a search went on without the barrier of limits
  bool has_motion_ = false;
  std::vector<NodeModel> node_;  // [5] of four steps
  VectorXd start_impulse_;       // [f] momentum along the shape's coordinates that the start brings
  double idle_violation_ = 0.0;  // of a motion that stays as it starts
  VectorXd end_multiplier_;
  VectorXd end_start_;                     // for the next go_to
  VectorXd end_kept_;                      // of a barrier's answer
  std::vector<VectorXd> idle_multiplier_;  // [N][idle]
  std::vector<VectorXd> idle_bend_;        // [N][idle] N m, idle moments of trial points beyond first order
  VectorXd missed_idle_;                   // [idle] N m
  std::vector<MatrixXd> next_by_idle_;     // [N][n][idle] next state by idle moments
  double metric_scale_ = 1.0;              // N m times effort's weight, what moments are worth
  mechanics::Interval buffer_;
  VectorXd along_;                            // [shape_size]
  mechanics::Freedoms spread_, spread_next_;  // [bodies]
  mechanics::Vectors spread_turn_;            // [bodies]
  MatrixXd work_, by_shape_;                  // [shape_size][f], [controls][shape_size]
  MatrixXd equations_;                        // [f, up to a multiple of four][2 f + s]
  MatrixXd pose_step_;                        // [p][2 f]
  MatrixXd pose_moments_;                     // [f][6] impulses by the root's pose, where momentum is carried
  MatrixXd moments_by_shapes_, weighed_;      // [f][f + s] by shapes k − 1 and k, what is carried, and shape k + 1
  MatrixXd transposed_;                       // [f + s][f]
  MatrixXd moment_form_;                      // [f + s] squared
  VectorXd pull_;                             // [p]
  MatrixXd end_by_state_;                     // [f][n] the last node's moments by the last state
  MatrixXd end_weighed_, end_transposed_;     // [controls][n], [n][controls]
  MatrixXd end_mixed_;                        // [n][f]
  VectorXd rate_, ends_rate_;                 // [f], [2 f] of shapes and impulses by the logarithm of the duration
  VectorXd step_rate_;           // [2 f + 7] of a step's impulses by it, weighed, where momentum is carried
  VectorXd mixed_, by_moments_;  // [f], [controls]
  MatrixXd timed_equations_;     // [f, up to a multiple of four][f + 1]
  // [f] what impulses of springs and dampers change by with the duration's logarithm: at the beginning of a step, at the end
  // of the one before and of this one, at the beginning of the first; and all of a node
  VectorXd timed_minus_, timed_before_, timed_plus_, timed_first_, timed_;
  Eigen::RowVectorXd by_first_, by_last_;  // [shape_size + 6]
  ShapeTangent before_, after_;
  std::vector<ShapeTangent> four_tangents_;  // [4]
  // [4][2 f + 3] squared, by the root's turn at the end; where momentum is carried [2 f + 6], by its pose there, in free time
  // [2 f + 7]
  std::vector<MatrixXd> four_hessians_;
  PoseAtEnd pose_at_end_;            // where momentum is carried
  std::vector<PoseStep> pose_pull_;  // [N] the same
  // What joints carry that end at rest on a whole that drifts, and how it answers to the end: along all coordinates by the shape,
  // by the total as the root sees it, by the last state; what the root sees by its pose
  std::optional<mechanics::RestingJoints> resting_;
  MatrixXd resting_rates_, resting_form_;   // [shape_size] squared
  MatrixXd resting_by_total_;               // [shape_size][6]
  MatrixXd carried_at_end_, carried_bend_;  // [f][f + p]
  MatrixXd along_shapes_, along_poses_;     // [shape_size][f], [shape_size][p]
  MatrixXd seen_along_poses_, pose_bend_;   // [6][p], [p] squared
  Matrix6d seen_by_pose_;
  Vector6d end_pull_ = Vector6d::Zero();  // of the Lagrangian, by the pose at the end
  MatrixXd end_impulses_;                 // [f][s] that the last moments answer, by the last state
  MatrixXd first_minus_;                  // [f][2 f] of the first step
  NodeModel first_node_;                  // of periodic motions
};

}  // namespace lamprey::shape
