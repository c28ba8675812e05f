// Quadratic forms of inputs along a linear chain of stages, with rows that the chain's end has to keep: definite or not
// where the rows are kept, how many negative eigenvalues, the smallest one. Cost linear in the stages (chapter 6).
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lamprey::certificate {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// One input u and what it leads to: y' = A y + B u. Its part of the form is yᵀQy + 2 uᵀSy + uᵀRu, of the metric
/// weight · |u|².
struct ChainStage {
  MatrixXd A;  // [states][states]
  MatrixXd B;  // [states][inputs]
  MatrixXd Q;  // [states][states] symmetric
  MatrixXd S;  // [inputs][states]
  MatrixXd R;  // [inputs][inputs] symmetric
  double weight;
};

/// A chain that begins at y = 0.
struct Chain {
  std::vector<ChainStage> stage;
  MatrixXd end_form;  // [states][states] symmetric: yᵀ end_form y of the last y
  MatrixXd end_rows;  // [rows][states] orthonormal: end_rows · y = 0 of the last y
};

/// Adds states after those of the chain that nothing drives, keeps or looks at.
void widen(Chain& chain, Eigen::Index states);

using Inputs = std::vector<VectorXd>;  // [stages][inputs]

/// What a problem pulls at: inputs, and states y at the stages' beginnings (empty: nothing).
struct ChainGradient {
  Inputs by_input;
  std::vector<VectorXd> by_state;  // [stages][states] or empty
};

/// Solves with form − shift · metric on the inputs that keep the end rows.
class ChainSolver {
 public:
  explicit ChainSolver(const Chain& chain, double penalty) : chain_(chain), penalty_(penalty) {}

  /// One sweep from the end. The end rows count with `penalty` in the form, which changes nothing where they are kept
  /// but steadies the sweep. Returns the number of negative eigenvalues of form − shift · metric where the end rows are
  /// kept (equation 6.15); nothing where a pivot is singular to working accuracy.
  std::optional<int> factor(double shift);

  /// Inputs where form/2 − shift/2 · metric + gradient is stationary among those that keep the end rows.
  /// After a factor that returned a number.
  Inputs solve(const ChainGradient& gradient);

  /// Gradients by y at all ends of stages, [stages + 1], at what solve has just returned: the first belongs to the
  /// chain's beginning. Carried along the closed loop, where errors do not grow (equation 6.12).
  std::vector<VectorXd> costates(const ChainGradient& gradient, const Inputs& solution) const;

 private:
  struct Gain {
    MatrixXd feedback;       // [inputs][states]
    MatrixXd pivot_inverse;  // [inputs][inputs]
    MatrixXd by_multiplier;  // [inputs][rows]
  };
  const Chain& chain_;
  double penalty_;
  double shift_ = 0.0;
  std::vector<Gain> gain_;  // [stages]
  MatrixXd end_gram_;       // [rows][rows] what unit multipliers do to the end rows, sign reversed
  VectorXd multiplier_;
};

/// Smallest eigenvalue of a chain's form against its metric where the end rows are kept.
struct SmallestEigenvalue {
  double value;  // some input attains it, to the accuracy of the sweep
  double bound;  // proven from below: form − bound · metric is positive definite
};

/// Lanczos' method with the chain's solver, then tests of definiteness until value − bound is within 1e-3 of the value
/// (or 1e-6). NaN where no shift makes the form definite.
SmallestEigenvalue smallest_eigenvalue(const Chain& chain, ChainSolver& solver);

}  // namespace lamprey::certificate
