#include "optimizer/feasibility.hpp"

#include <Eigen/SparseCholesky>

namespace lamprey::optimizer {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
constexpr int max_passes = 6;

// How far each constraint is from what is allowed; 0 where it is met.
VectorXd violation(Program& program, const VectorXd& x) {
  VectorXd c(program.constraint_count());
  program.constraints(x, c);
  return (c - program.constraint_upper()).cwiseMax(0.0) + (c - program.constraint_lower()).cwiseMin(0.0);
}

// Rows of equations and of limits that are broken; others are left out.
Sparse jacobian(Program& program, const VectorXd& x, const VectorXd& violated) {
  VectorXd values;
  program.jacobian(x, values);
  const SparsePattern& pattern = program.jacobian_pattern();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(pattern.size()));
  for (int e = 0; e < pattern.size(); ++e) {
    const int row = pattern.rows[static_cast<std::size_t>(e)];
    const bool equation = program.constraint_lower()[row] == program.constraint_upper()[row];
    const bool counts = equation || violated[row] != 0.0;
    entries.emplace_back(row, pattern.columns[static_cast<std::size_t>(e)], counts ? values[e] : 0.0);
  }
  Sparse matrix(program.constraint_count(), program.variable_count());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// Rows that are left out stand for themselves.
Sparse with_empty_rows(Sparse normal) {
  for (Eigen::Index r = 0; r < normal.rows(); ++r)
    if (normal.coeff(r, r) == 0.0) normal.coeffRef(r, r) = 1.0;
  return normal;
}

}  // namespace

double largest_violation(Program& program, const VectorXd& x) {
  return violation(program, x).lpNorm<Eigen::Infinity>();
}

double polish_feasibility(Program& program, VectorXd& x) {
  VectorXd c = violation(program, x);
  double size = c.lpNorm<Eigen::Infinity>();
  Eigen::SimplicialLDLT<Sparse> solver;
  for (int pass = 0; pass < max_passes && size > 0.0; ++pass) {
    const Sparse A = jacobian(program, x, c);
    const Sparse normal = with_empty_rows(A * A.transpose());
    if (pass == 0) solver.analyzePattern(normal);
    solver.factorize(normal);
    if (solver.info() != Eigen::Success) break;
    const VectorXd moved = x - A.transpose() * solver.solve(c);
    const VectorXd c_moved = violation(program, moved);
    const double size_moved = c_moved.lpNorm<Eigen::Infinity>();
    if (!(size_moved < size)) break;
    const bool slow = size_moved > 0.5 * size;
    x = moved;
    c = c_moved;
    size = size_moved;
    if (slow) break;
  }
  return size;
}

}  // namespace lamprey::optimizer
