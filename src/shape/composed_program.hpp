// A maneuver by a scheme above order 2, in the shapes at all nodes of its stages and the polynomials of the moments in its
// steps (chapter 12). Total momentum zero fixes the root's motion, so every point of the search is a motion that
// conserves it; what a point may miss, beside the goal, is that the moments which its shapes need are the polynomials.
// As an optimizer::StageProgram: a stage is a whole step, its state (shape, momenta of the shape, root's turn ρ and
// position χ in the world), its input the coefficients of the moments.
#pragma once

#include <optional>

#include "maneuver/end_rows.hpp"
#include "maneuver/node_path.hpp"
#include "maneuver/step_polynomial.hpp"
#include "optimizer/stage_program.hpp"
#include "shape/condensed_step.hpp"
#include "shape/four_steps.hpp"
#include "shape/moment_basis.hpp"
#include "shape/pose_at_end.hpp"

namespace lamprey::shape {

using integrator::Scheme;
using maneuver::EndCurvature;
using maneuver::EndRow;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::ShapeCoordinates;

class ComposedProgram : public optimizer::StageProgram {
 public:
  /// Start must carry no total momentum. `end_rows` as of ShapeProgram; those of moments are left out, for rest is asked of all momenta.
  ComposedProgram(const model::System& system, const Maneuver& maneuver, Scheme scheme,
                  const ShapeCoordinates& coordinates, const std::vector<EndRow>& end_rows);

  /// Multipliers of the end rows as given, from another grid or scheme, to begin with at go_to; empty: none are known.
  void take_end_multipliers(const VectorXd& multipliers);
  /// Those at the point, likewise; 0 for rows of moments.
  VectorXd end_multipliers() const;
  /// Goes to a motion at the nodes of all stages, with its polynomials. Returns false where no motion is found through its shapes.
  bool go_to(const NodePath& path);
  /// The motion at the nodes of all stages.
  NodePath path() const;

  optimizer::StageSizes sizes() const override;
  const optimizer::Merit& merit() const override { return now_.merit; }
  bool has_multipliers() const override { return end_start_.size() > 0; }
  void linearize(optimizer::StageModel& model) override;
  const optimizer::Merit* try_step(const optimizer::StageStep& step, double length) override;
  const VectorXd& end_rows() const override { return now_.end_rows; }
  const VectorXd& trial_end_rows() const override { return trial_.end_rows; }
  void accept() override { std::swap(now_, trial_); }
  void take_multipliers(const optimizer::StageStep& step, double length) override;
  double longest(const optimizer::StageStep& step, const optimizer::Promise& promise) override;
  double goal_error() const override;
  double drift() const override { return momentum_left(system_, now_.stage, now_.rotation, now_.position); }

  /// Impulse along the shape's coordinates that is missing at a trial point's nodes, [steps · stages][f], and the
  /// multipliers that the Lagrangian of linearize gives them.
  const std::vector<VectorXd>& trial_gaps() const { return trial_.missing; }
  const std::vector<VectorXd>& gap_multipliers() const { return multiplier_; }
  /// What the polynomials cost, and the same at the trial point.
  double cost() const override { return now_.cost; }
  double trial_cost() const { return trial_.cost; }
  /// Largest missing impulse at the point, as a share of the largest momentum.
  double gap() const;

 private:
  // A motion through given shapes, and the polynomials beside it. Nodes are those of all stages, 0 … steps · stages.
  struct Motion {
    std::vector<mechanics::Rotations> shape;     // [nodes][bodies] seen from the root
    std::vector<mechanics::Rotations> rotation;  // [nodes][bodies] body → world
    mechanics::Vectors position;                 // [nodes] m, root, world
    std::vector<ShapeStep> stage;                // [nodes − 1]
    std::vector<VectorXd> polynomial;            // [steps][terms · m] N m
    std::vector<MatrixXd> impulse;               // [nodes][f][all moments] by unit moments over unit time
    std::vector<VectorXd> missing;               // [nodes − 1][f]
    VectorXd end_momentum;                       // [f]
    VectorXd end_rows;
    double cost = 0.0;  // of the polynomials
    optimizer::Merit merit;
  };

  bool roll_out(Motion& motion);
  bool solve_stage(int n, Motion& motion);
  bool solve_four(int first, int s, Motion& motion);
  void measure(Motion& motion);
  void weigh_gaps(Motion& motion) const;
  void read_moments(const Motion& motion, int step, int node, VectorXd& moment) const;
  template <typename Of>
  auto of_four(int first, const Of& of) const;
  double stage_time(int stage) const { return layout_.time[static_cast<std::size_t>(stage % stages_)]; }
  double half_time_before(int node) const { return 0.5 * stage_time(node - 1); }
  double half_time_after(int node) const { return 0.5 * stage_time(node); }
  void guess_multipliers();
  void lay_forces(int k);
  void find_control_by_shape(int node, MatrixXd& by_shape);
  void differentiate_four(int first, int s, const Vector6d& pose_multiplier);
  void model_step(int k, optimizer::Stage& stage);
  void model_goal(optimizer::StageModel& model);
  void add_metrics(optimizer::StageModel& model);

  const model::System& system_;
  Maneuver maneuver_;
  std::vector<EndRow> given_rows_, end_rows_;
  MatrixXd shape_basis_, pose_basis_;  // [shape_size][f], [6][p]
  EndCurvature end_curvature_;
  int steps_, stages_, shape_, pose_, controls_;
  int rest_rows_;  // behind the end rows
  double h_;
  StepLayout layout_;
  std::vector<double> fraction_;  // [stages + 1] of the step at the stages' nodes
  std::vector<VectorXd> value_;   // [stages + 1][terms] of the polynomials there
  VectorXd inertia_;              // [f] kg m², along the shape's coordinates: makes turns of momenta
  double effort_;                 // s, weight of a step
  ShapeKernel kernel_;
  std::optional<FourSteps> four_steps_;  // where it serves
  MomentBasis moments_;
  Motion now_, trial_;
  CondensingSpace space_;
  std::vector<CondensedStep> condensed_;  // [steps]
  std::vector<VectorXd> multiplier_;      // [nodes][f] of the missing impulse, at the end of the momentum
  bool multipliers_known_ = false;
  VectorXd end_multiplier_, end_start_;
  std::vector<std::vector<mechanics::Moments>> control_;  // [steps][stages + 1] N m, by joint
  std::vector<StepCostate> costate_;                      // [stages]
  VectorXd moment_, all_moments_;                         // [controls], [all moments] N m
  MatrixXd work_;                                         // [shape_size][all moments]
  MatrixXd by_shape_;                                     // [controls][shape_size]
  VectorXd along_, ends_, packed_;                        // [shape_size], [2 f], [columns of a condensed step]
  mechanics::Freedoms spread_;                            // [bodies]
  mechanics::Vectors spread_turn_;                        // [bodies]
  mechanics::Interval buffer_;
  Eigen::RowVectorXd end_derivative_;  // [shape_size + 6]
};

}  // namespace lamprey::shape
