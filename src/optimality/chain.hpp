// Quadratic forms of inputs along a linear chain of stages, with rows that the chain's end has to keep: definite or not
// where the rows are kept, how many negative eigenvalues, the smallest one. Cost linear in the stages (chapter 6).
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lamprey::optimality {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rows that a stage keeps: by_state · y + by_input · u = 0. They may depend on each other and on those of other stages.
struct KeptRows {
  MatrixXd by_state;  // [rows][states]
  MatrixXd by_input;  // [rows][inputs]
};

/// One input u and what it leads to: y' = A y + B u. Its part of the form is yᵀQy + 2 uᵀSy + uᵀRu, of the metric
/// weight · |u|².
struct ChainStage {
  MatrixXd A;  // [states][states]
  MatrixXd B;  // [states][inputs]
  MatrixXd Q;  // [states][states] symmetric
  MatrixXd S;  // [inputs][states]
  MatrixXd R;  // [inputs][inputs] symmetric
  double weight;
  KeptRows kept = {};  // empty: none
};

/// A chain that begins at y = 0.
struct Chain {
  std::vector<ChainStage> stage;
  MatrixXd end_form;  // [states][states] symmetric: yᵀ end_form y of the last y
  MatrixXd end_rows;  // [rows][states] orthonormal: end_rows · y = 0 of the last y
};

/// Adds states after those of the chain that nothing drives, keeps or looks at.
void widen(Chain& chain, Eigen::Index states);

/// Adds rows, by (y, u), that the stage keeps.
void keep_rows(const MatrixXd& rows, ChainStage& stage);

/// What a stage's input is where the states that it leads to are of size 1: moments, and the numbers that a motion begins with, have
/// units of their own.
double input_unit(const ChainStage& stage);

/// Whether any of its stages keeps rows.
bool keeps_rows(const Chain& chain);

/// The chain with what its stages keep in the form instead, each row as large as the input that it takes and squared, times
/// `weight` of that input's metric: where this form is definite, the chain's is where its rows are kept.
Chain with_rows_weighed(const Chain& chain, double weight);

using Inputs = std::vector<VectorXd>;  // [stages][inputs]

/// What a problem pulls at: inputs, and states y at the stages' beginnings (empty: nothing).
struct ChainGradient {
  Inputs by_input;
  std::vector<VectorXd> by_state;  // [stages][states] or empty
};

/// Solves with form − shift · metric on the inputs that keep the stages' rows and the end rows.
class ChainSolver {
 public:
  ChainSolver(const Chain& chain, double penalty);

  /// One sweep from the end. The end rows count with `penalty` in the form, which changes nothing where they are kept
  /// but steadies the sweep. Returns the number of negative eigenvalues of form − shift · metric where the end rows are
  /// kept (equation 6.15); nothing where a pivot is singular to working accuracy.
  std::optional<int> factor(double shift);

  /// Inputs where form/2 − shift/2 · metric + gradient is stationary among those that keep the end rows.
  /// After a factor that returned a number.
  Inputs solve(const ChainGradient& gradient);

  /// Gradients by y at all ends of stages, [stages + 1], at what solve has just returned: the first belongs to the
  /// chain's beginning. Of a chain whose stages keep no rows. Carried along the closed loop, where errors do not grow (equation 6.12).
  std::vector<VectorXd> costates(const ChainGradient& gradient, const Inputs& solution) const;

 private:
  struct Gain {
    MatrixXd held_feedback;  // [inputs][states] what keeps the rows at the least |u|
    MatrixXd free;           // [inputs][free] orthonormal, what is left of the inputs
    MatrixXd feedback;       // [inputs][states]
    MatrixXd pivot_inverse;  // [inputs][inputs]
    MatrixXd by_multiplier;  // [inputs][rows]
    bool keeps() const { return free.cols() < free.rows(); }
  };
  void keep();
  static int invert_where_free(const MatrixXd& pivot, Gain& gain);

  const Chain& chain_;
  double penalty_;
  double shift_ = 0.0;
  std::vector<Gain> gain_;  // [stages]
  MatrixXd end_gram_;       // [rows][rows] what unit multipliers do to the end rows, sign reversed
  MatrixXd gram_inverse_;   // its inverse on the end rows that the stages' rows do not imply
  VectorXd multiplier_;
};

/// Smallest eigenvalue of a chain's form against its metric where all rows are kept.
struct SmallestEigenvalue {
  double value;  // some input attains it, to the accuracy of the sweep
  double bound;  // proven from below: form − bound · metric is positive definite
};

/// Lanczos' method with the chain's solver, then tests of definiteness until value − bound is within 1e-3 of the value
/// (or 1e-6). NaN where no shift makes the form definite.
/// With `set_aside`, an eigenvector of size 1 in the metric: the smallest of the others.
SmallestEigenvalue smallest_eigenvalue(const Chain& chain, ChainSolver& solver, const Inputs* set_aside = nullptr);

/// The eigenvector whose eigenvalue is nearest to a shift below all, found from inputs that may miss the rows a little.
struct Eigenvector {
  Inputs inputs;  // of size 1 in the metric
  double cosine;  // of its angle with where it was sought from, in the metric
};

/// By inverse iteration. Nothing where the form is not definite above the shift.
std::optional<Eigenvector> eigenvector_near(const Chain& chain, ChainSolver& solver, double shift, const Inputs& from);

}  // namespace lamprey::optimality
