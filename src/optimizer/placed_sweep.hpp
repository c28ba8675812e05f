// The Riccati recursion over stages whose inputs are the last of the next state's shapes, s = (shape before, shape, rest) and
// s' = (shape, input, rest'), for the sizes of the usual swimmers: products of blocks whose sizes the compiler knows. Does
// what Riccati does with such stages, but keeps nothing of the Hessian still to come.
#pragma once

#include <memory>

#include "optimizer/stage_program.hpp"

namespace lamprey::optimizer {

class PlacedSweep {
 public:
  virtual ~PlacedSweep() = default;

  /// From the Hessian of what comes after the last stage, [n][n]. Sets what inputs reach of the end rows in the metric of the
  /// Hessian, [end_rows] squared. Returns false at the first pivot that is not positive.
  virtual bool factor(const StageModel& model, double shift, const MatrixXd& P, MatrixXd& end_gram) = 0;

  /// The stage and the input whose pivot that was.
  int failed_stage() const { return failed_stage_; }
  int failed_input() const { return failed_input_; }

  /// Lower Cholesky factor of the inputs' block, the inverse of its diagonal on the diagonal, [m][m]; of the failed stage as far
  /// as it came.
  virtual void read_factor(int stage, MatrixXd& factor) const = 0;

  /// How a stage's optimal input answers its state, [m][n].
  virtual MatrixXd feedback(int stage) const = 0;

  /// From the gradient of what comes after the last stage: the stages' inputs where states and multipliers are 0. Adds what
  /// they reach to end rows.
  virtual void look_back(const StageModel& model, const VectorXd& gradient, VectorXd& end_rows) = 0;

  /// Inputs and states from a stage on, which begins at `state`, along the feedback: added to a step or put in their place;
  /// with the inputs of look_back or without.
  virtual void follow(const StageModel& model, int first, const VectorXd& state, const VectorXd& end_multiplier,
                      bool own_inputs, bool add, StageStep& step) = 0;

  /// For stages of m shifted and m placed states without gaps; nothing where these sizes are not known.
  static std::unique_ptr<PlacedSweep> of(const StageSizes& sizes);

 protected:
  int failed_stage_ = 0, failed_input_ = 0;
};

}  // namespace lamprey::optimizer
