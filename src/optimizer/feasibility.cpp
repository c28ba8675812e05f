#include "optimizer/feasibility.hpp"

#include <Eigen/SparseCholesky>

namespace lamprey::optimizer {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
constexpr int max_passes = 6;

VectorXd violation(Program& program, const VectorXd& x) {
  VectorXd c(program.constraint_count());
  program.constraints(x, c);
  return c - program.constraint_upper();
}

Sparse jacobian(Program& program, const VectorXd& x) {
  VectorXd values;
  program.jacobian(x, values);
  const SparsePattern& pattern = program.jacobian_pattern();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(pattern.size()));
  for (int e = 0; e < pattern.size(); ++e)
    entries.emplace_back(pattern.rows[static_cast<std::size_t>(e)], pattern.columns[static_cast<std::size_t>(e)],
                         values[e]);
  Sparse matrix(program.constraint_count(), program.variable_count());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

double polish_feasibility(Program& program, VectorXd& x) {
  VectorXd c = violation(program, x);
  double size = c.lpNorm<Eigen::Infinity>();
  Eigen::SimplicialLDLT<Sparse> solver;
  for (int pass = 0; pass < max_passes && size > 0.0; ++pass) {
    const Sparse A = jacobian(program, x);
    const Sparse normal = A * A.transpose();
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
