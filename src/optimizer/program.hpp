// Program: a sparse nonlinear program, minimise f(x) with lower ≤ c(x) ≤ upper, as any solver of this room takes it.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lamprey::optimizer {

using Eigen::VectorXd;

/// Positions of the entries of a sparse matrix; several entries at one place add up.
struct SparsePattern {
  std::vector<int> rows;
  std::vector<int> columns;
  int size() const { return static_cast<int>(rows.size()); }
  void add(int row, int column) {
    rows.push_back(row);
    columns.push_back(column);
  }
};

/// Implementations may cache by point: solvers call the functions below at one point after another.
class Program {
 public:
  virtual ~Program() = default;

  virtual int variable_count() const = 0;
  virtual int constraint_count() const = 0;
  virtual const VectorXd& constraint_lower() const = 0;
  virtual const VectorXd& constraint_upper() const = 0;
  /// Whether any constraint is more than an equation.
  bool has_inequalities() const { return constraint_lower() != constraint_upper(); }

  /// What solvers measure variables and constraints in, so that they are of order one; empty: in 1.
  virtual VectorXd variable_units() const { return {}; }
  virtual VectorXd constraint_units() const { return {}; }

  virtual double objective(const VectorXd& x) = 0;
  virtual void gradient(const VectorXd& x, VectorXd& g) = 0;
  virtual void constraints(const VectorXd& x, VectorXd& c) = 0;
  virtual const SparsePattern& jacobian_pattern() const = 0;
  virtual void jacobian(const VectorXd& x, VectorXd& values) = 0;

  /// Whether hessian() is exact; where it is not, solvers build their own approximation.
  virtual bool has_hessian() const { return true; }
  /// Lower triangle of factor · ∇²f + Σ multiplier_r ∇²c_r.
  virtual const SparsePattern& hessian_pattern() const = 0;
  virtual void hessian(const VectorXd& x, double factor, const VectorXd& multiplier, VectorXd& values) = 0;

  /// A number a person understands: how far x is from the goal.
  virtual double goal_error(const VectorXd& x) = 0;
};

}  // namespace lamprey::optimizer
