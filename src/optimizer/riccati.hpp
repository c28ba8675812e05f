// Linear-quadratic models along a chain of stages, solved by the Riccati recursion: cost linear in the stages.
#pragma once

#include <Eigen/Cholesky>

#include "optimizer/placed_sweep.hpp"

namespace lamprey::optimizer {

/// Factors and solves models of one size.
class Riccati {
 public:
  explicit Riccati(const StageSizes& sizes);

  /// Whether find_costates will be called; by default it may be. Without, sweeps over placed states take less.
  void want_costates(bool wanted) { with_costates_ = wanted; }

  /// One sweep from the end. The Hessian counts with `shift` × the states' metric added, the end rows with `penalty`: with a large
  /// enough penalty the sweep succeeds where the Hessian is positive definite on the tangent space of the end rows, and
  /// only there. Returns false where it is not.
  bool factor(const StageModel& model, double shift, double penalty);

  /// After factor: how a stage's optimal input answers its state, [m][n].
  MatrixXd feedback(int stage) const;

  /// The end rows' multipliers of the step that solve() finds with this share.
  const VectorXd& look_back(const StageModel& model, double share);

  /// What the end rows' multipliers change by when a whole step is to take `end_rows` away, from a step that leaves them.
  void end_response(const VectorXd& end_rows, VectorXd& multipliers) const;

  /// The step whose end rows come to (1 − share) of what they are; costates are left as they are.
  void solve(const StageModel& model, double share, StageStep& step);

  /// The costates of the step that solve() has found.
  void find_costates(StageStep& step) const;

  /// The least step, in the metric of the factored Hessian, that brings the end rows from `end_rows` to 0: no cost, no
  /// gaps; added to `step`, without its multipliers.
  void correct(const StageModel& model, const VectorXd& end_rows, StageStep& step);

  /// After a factor that returned false: whether its sweep met negative curvature. Otherwise its end rows depend on each other.
  bool met_curvature() const { return failed_stage_ >= 0; }

  /// Where met_curvature: a direction of negative curvature, small in the end rows, with inputs of `size` where the sweep
  /// met it. Not for shifted Hessians.
  void bend(const StageModel& model, double size, StageStep& step);

 private:
  struct Gain {
    MatrixXd P;        // [n][n] Hessian of what is still to come
    MatrixXd factor;   // [m][m] lower Cholesky factor of R + BᵀPB, the inverse of its diagonal on the diagonal
    MatrixXd by_back;  // [end_rows + n][m] inputs, sign reversed: by the end rows' multipliers and by the state
    MatrixXd end;      // [end_rows][n] closed-loop sensitivity of the end rows
    VectorXd p;        // [n] gradient of what is still to come at s = 0
    VectorXd input;    // [m] at s = 0
  };
  bool placed_alone(const StageModel& model) const;
  bool sweep(const StageModel& model, double shift);
  void make_room();
  void find_failed_input(const MatrixXd& factor, int input);
  void carry_hessian(const Stage& stage, double shift, const Gain& next, Gain& gain);
  int seen_states(const Stage& stage) const;
  void carry_end(const Stage& stage, const Gain& next, Gain& gain);
  bool eliminate_inputs(Gain& gain);
  void follow(const StageModel& model, int first, const VectorXd& state, const VectorXd& end_multiplier,
              bool own_inputs, bool add, StageStep& step);
  void move(const Stage& stage, const VectorXd& input, const VectorXd& state, VectorXd& next) const;

  StageSizes sizes_;
  std::vector<Gain> gain_;  // [N + 1], the last without gains; none where a PlacedSweep does it all
  MatrixXd transposed_;     // [n + m][n] of the rows of (A, B) that are not shifted ones
  MatrixXd PA_, PB_;        // P A, P B
  MatrixXd by_input_;  // [end_rows + n + m][m] what inputs do to end rows, to the states' gradient and to their own
  MatrixXd end_gram_;  // [end_rows] squared
  Eigen::LLT<MatrixXd> end_solver_;
  VectorXd ahead_, state_, input_, back_, reached_, multiplier_;
  std::unique_ptr<PlacedSweep> placed_sweep_;
  bool placed_ = false;  // whether it has factored the latest model
  bool with_costates_ = true;
  MatrixXd P_end_;   // [n][n]
  VectorXd p_end_;   // [n]
  MatrixXd factor_;  // [m][m]
  double penalty_ = 0.0;
  int failed_stage_ = -1;
  VectorXd failed_input_;  // [m] along which the sweep met negative curvature
};

}  // namespace lamprey::optimizer
