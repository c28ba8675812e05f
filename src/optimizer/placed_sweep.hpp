// The Riccati recursion over stages whose inputs are the last of the next state's shapes, s = (shape before, shape, rest) and
// s' = (shape, input, rest'), for the sizes of the usual swimmers: products of blocks whose sizes the compiler knows. Says
// what Riccati::factor says of such stages, but keeps nothing of the Hessian still to come.
#pragma once

#include <memory>

#include "optimizer/stage_program.hpp"

namespace lamprey::optimizer {

class PlacedSweep {
 public:
  virtual ~PlacedSweep() = default;

  /// Begins from the end: Hessian of what is still to come [n][n], sensitivity of the end rows [end_rows][n].
  virtual void begin(const MatrixXd& P, const MatrixXd& end) = 0;

  /// One stage further back. Sets the lower Cholesky factor of the inputs' block with the inverse of its diagonal on the
  /// diagonal [m][m], and inputs by end rows' multipliers and state with their signs reversed [end_rows + n][m]. Returns the
  /// number of inputs that were eliminated: m, or those before the first pivot that is not positive.
  virtual int step(const Stage& stage, double shift, MatrixXd& factor, MatrixXd& by_back) = 0;

  /// What inputs reach of the end rows since the beginning, in the metric of the Hessian: [end_rows] squared.
  virtual void read_end_gram(MatrixXd& gram) const = 0;

  /// For stages of m shifted and m placed states; nothing where these sizes are not known.
  static std::unique_ptr<PlacedSweep> of(const StageSizes& sizes);
};

}  // namespace lamprey::optimizer
