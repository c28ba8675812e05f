// Small programs with known answers.
#pragma once

#include <cmath>
#include <functional>

#include "optimizer/program.hpp"

namespace lamprey::tests {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A dense program put together from functions.
class DenseProgram : public optimizer::Program {
 public:
  using Scalar = std::function<double(const VectorXd&)>;
  using Vector = std::function<VectorXd(const VectorXd&)>;
  using Matrix = std::function<MatrixXd(const VectorXd&)>;
  using Hessian = std::function<MatrixXd(const VectorXd& x, double factor, const VectorXd& multiplier)>;

  int variables = 0;
  VectorXd lower, upper;  // [constraints]
  Scalar f;
  Vector df, c;
  Matrix dc;
  Hessian curvature;  // empty: the solver approximates
  int hessians = 0;   // how often it was asked for

  /// Call once the functions stand.
  void lay_patterns() {
    for (int col = 0; col < variables; ++col) {
      for (int row = 0; row < constraint_count(); ++row) jacobian_pattern_.add(row, col);
      for (int row = col; row < variables; ++row) hessian_pattern_.add(row, col);
    }
  }

  int variable_count() const override { return variables; }
  int constraint_count() const override { return static_cast<int>(lower.size()); }
  const VectorXd& constraint_lower() const override { return lower; }
  const VectorXd& constraint_upper() const override { return upper; }
  double objective(const VectorXd& x) override { return f(x); }
  void gradient(const VectorXd& x, VectorXd& g) override { g = df(x); }
  void constraints(const VectorXd& x, VectorXd& values) override { values = c(x); }
  const optimizer::SparsePattern& jacobian_pattern() const override { return jacobian_pattern_; }
  void jacobian(const VectorXd& x, VectorXd& values) override { values = dc(x).reshaped(); }
  bool has_hessian() const override { return bool(curvature); }
  const optimizer::SparsePattern& hessian_pattern() const override { return hessian_pattern_; }
  void hessian(const VectorXd& x, double factor, const VectorXd& multiplier, VectorXd& values) override {
    ++hessians;
    const MatrixXd full = curvature(x, factor, multiplier);
    values.resize(hessian_pattern_.size());
    for (int e = 0; e < hessian_pattern_.size(); ++e)
      values[e] = full(hessian_pattern_.rows[static_cast<std::size_t>(e)],
                       hessian_pattern_.columns[static_cast<std::size_t>(e)]);
  }
  double goal_error(const VectorXd& x) override { return x.norm(); }

 private:
  optimizer::SparsePattern jacobian_pattern_, hessian_pattern_;
};

/// ½|x − a|² on the plane Σ x = 1: x = a − (Σ a − 1)/n, multiplier (Σ a − 1)/n.
inline DenseProgram nearest_on_a_plane(const VectorXd& a) {
  DenseProgram program;
  const auto n = a.size();
  program.variables = static_cast<int>(n);
  program.lower = program.upper = VectorXd::Ones(1);
  program.f = [a](const VectorXd& x) { return 0.5 * (x - a).squaredNorm(); };
  program.df = [a](const VectorXd& x) { return VectorXd(x - a); };
  program.c = [](const VectorXd& x) { return VectorXd::Constant(1, x.sum()); };
  program.dc = [n](const VectorXd&) { return MatrixXd::Ones(1, n); };
  program.curvature = [n](const VectorXd&, double factor, const VectorXd&) {
    return MatrixXd(factor * MatrixXd::Identity(n, n));
  };
  program.lay_patterns();
  return program;
}

/// Rosenbrock's valley with lower ≤ x² + y² ≤ upper.
inline DenseProgram rosenbrock(double lower, double upper) {
  DenseProgram program;
  program.variables = 2;
  program.lower = VectorXd::Constant(1, lower);
  program.upper = VectorXd::Constant(1, upper);
  program.f = [](const VectorXd& x) { return std::pow(1.0 - x[0], 2) + 100.0 * std::pow(x[1] - x[0] * x[0], 2); };
  program.df = [](const VectorXd& x) {
    const double v = x[1] - x[0] * x[0];
    return VectorXd(Eigen::Vector2d(-2.0 * (1.0 - x[0]) - 400.0 * x[0] * v, 200.0 * v));
  };
  program.c = [](const VectorXd& x) { return VectorXd::Constant(1, x.squaredNorm()); };
  program.dc = [](const VectorXd& x) { return MatrixXd(2.0 * x.transpose()); };
  program.curvature = [](const VectorXd& x, double factor, const VectorXd& multiplier) {
    MatrixXd H(2, 2);
    H << 2.0 - 400.0 * (x[1] - 3.0 * x[0] * x[0]), -400.0 * x[0], -400.0 * x[0], 200.0;
    return MatrixXd(factor * H + 2.0 * multiplier[0] * MatrixXd::Identity(2, 2));
  };
  program.lay_patterns();
  return program;
}

}  // namespace lamprey::tests
