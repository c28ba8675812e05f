#include "maneuver/goal_rank.hpp"

#include <Eigen/SparseLU>

#include "maneuver/row_space.hpp"

namespace lamprey::maneuver {

namespace {

// Singular directions end this far below the leading pivot; independent ones stay many orders above it.
constexpr double rank_threshold = 1e-9;

using Sparse = Eigen::SparseMatrix<double>;

// d(goal rows)/d(controls), [rows][(N+1) controls], with every other variable following the motion's equations.
MatrixXd goal_sensitivity(Transcription& transcription, const VectorXd& x, int rows, int controls, int stage_size) {
  VectorXd values;
  transcription.jacobian(x, values);
  const optimizer::SparsePattern& pattern = transcription.jacobian_pattern();
  const int dynamics = transcription.constraint_count() - rows;
  std::vector<int> place(static_cast<std::size_t>(transcription.variable_count()));
  int states = 0, moments = 0;
  for (int v = 0; v < transcription.variable_count(); ++v)
    place[static_cast<std::size_t>(v)] = v % stage_size < controls ? -1 - moments++ : states++;
  std::vector<Eigen::Triplet<double>> by_state, by_control, goal_by_state, goal_by_control;
  for (int e = 0; e < pattern.size(); ++e) {
    const auto n = static_cast<std::size_t>(e);
    const int row = pattern.rows[n];
    const int column = place[static_cast<std::size_t>(pattern.columns[n])];
    auto& target =
        row < dynamics ? (column < 0 ? by_control : by_state) : (column < 0 ? goal_by_control : goal_by_state);
    target.emplace_back(row < dynamics ? row : row - dynamics, column < 0 ? -1 - column : column, values[e]);
  }
  const auto assemble = [](int r, int c, const std::vector<Eigen::Triplet<double>>& entries) {
    Sparse matrix(r, c);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  };
  const Sparse dynamics_by_state = assemble(dynamics, states, by_state);
  Eigen::SparseLU<Sparse> solver(Sparse(dynamics_by_state.transpose()));
  const MatrixXd adjoint = solver.solve(MatrixXd(assemble(rows, states, goal_by_state).transpose()));
  return MatrixXd(assemble(rows, moments, goal_by_control)) -
         adjoint.transpose() * assemble(dynamics, moments, by_control);
}

}  // namespace

std::vector<GoalRow> independent_goal_rows(const model::System& system, const Maneuver& maneuver,
                                           const NodePath& path) {
  const std::vector<GoalRow> stated = stated_goal_rows(system, maneuver);
  Maneuver unparameterised = maneuver;
  unparameterised.spline_points = 0;
  Transcription transcription(system, unparameterised, stated);
  const int controls = system.control_count();
  const MatrixXd sensitivity =
      goal_sensitivity(transcription, transcription.pack(path), static_cast<int>(stated.size()), controls,
                       controls + 7 * system.body_count() + 3);
  std::vector<char> kept(stated.size());
  for (int r : independent_rows(sensitivity, rank_threshold)) kept[static_cast<std::size_t>(r)] = 1;
  std::vector<GoalRow> independent;
  for (std::size_t r = 0; r < stated.size(); ++r)
    if (kept[r]) independent.push_back(stated[r]);
  return independent;
}

}  // namespace lamprey::maneuver
