// A maneuver in the shapes of its nodes alone (chapter 9): total momentum zero fixes the root's motion, inverse dynamics the
// moments, so that every point of the search is a motion of the swimmer and only the goal remains to be met. As an optimizer::StageProgram: state s_k = (shape k − 1, shape k, root's turn ρ and position χ in the
// world), input = moments along the joints' actuation at node k.
#pragma once

#include "maneuver/end_rows.hpp"
#include "maneuver/moment_basis.hpp"
#include "maneuver/node_path.hpp"
#include "optimizer/stage_program.hpp"

namespace lamprey::maneuver {

class ShapeProgram : public optimizer::StageProgram {
 public:
  /// Start must carry no total momentum. Control is free at each node.
  ShapeProgram(const model::System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
               std::vector<EndRow> end_rows);

  /// Goes to a motion: its shapes and, as a first guess, its root's motion. Returns false where none is found.
  bool go_to(const NodePath& path);
  NodePath path() const;

  optimizer::StageSizes sizes() const override;
  const optimizer::Merit& merit() const override { return now_.merit; }
  void linearize(optimizer::StageModel& model) override;
  const optimizer::Merit* try_step(const optimizer::StageStep& step, double length) override;
  const VectorXd& trial_end_rows() const override { return trial_.end_rows; }
  void accept() override { std::swap(now_, trial_); }
  void take_multipliers(const optimizer::StageStep& step, double length) override;
  double longest(const optimizer::StageStep& step) const override;
  double goal_error() const override;

 private:
  // A motion through given shapes.
  struct Motion {
    std::vector<mechanics::Rotations> shape;     // [N + 1][bodies] seen from the root
    std::vector<mechanics::Rotations> rotation;  // [N + 1][bodies] body → world
    mechanics::Vectors position;                 // [N + 1] m, root, world
    std::vector<ShapeStep> step;                 // [N]
    std::vector<MatrixXd> impulse;               // [N + 1][f][f] impulse along the coordinates by moments, N m s/(N m)
    std::vector<VectorXd> moment;                // [N + 1][f] N m by inverse dynamics: actuated ones, then idle ones
    VectorXd end_rows;
    optimizer::Merit merit;
  };
  // A node's part in the model.
  struct NodeModel {
    MatrixXd control_by_shape;  // [controls][f] second derivative of the Lagrangian by controls and shape
    VectorXd multiplier;        // [f] of the balance of impulses at the node
    mechanics::Moments control;
  };

  bool roll_out(Motion& motion);
  void measure(Motion& motion);
  void impulse_by_moments(const mechanics::Rotations& rotation, int node, MatrixXd& impulse);
  void model_node(int k, NodeModel& node);
  void model_step(int k, const NodeModel& node, const NodeModel& next, const Eigen::Vector3d& turn,
                  const Eigen::Vector3d& shift, optimizer::StageModel& model);
  void model_stage(int k, const NodeModel& node, optimizer::Stage& stage);
  void model_end(const NodeModel& node, optimizer::StageModel& model) const;
  void model_goal(optimizer::StageModel& model) const;
  VectorXd idle_multiplier(const optimizer::StageStep& step, int k) const;
  double impulse_time(int node) const { return node == 0 || node == steps_ ? 0.5 * h_ : h_; }
  int idle() const { return shape_ - controls_; }

  const model::System& system_;
  Maneuver maneuver_;
  std::vector<EndRow> end_rows_;
  MatrixXd shape_basis_, pose_basis_;  // [shape_size][f], [6][p]
  int steps_, shape_, pose_, controls_;
  double h_;
  ShapeKernel kernel_;
  MomentBasis moments_;
  Motion now_, trial_;
  VectorXd end_multiplier_;
  std::vector<VectorXd> idle_multiplier_;  // [N][idle]
  std::vector<MatrixXd> next_by_idle_;     // [N][n][idle] next state by idle moments
  double metric_scale_ = 1.0;              // N m, what moments are like
  mechanics::Interval buffer_;
  ShapeTangent before_, after_;
  MatrixXd hessian_;
};

}  // namespace lamprey::maneuver
