#include "transcription/goal_rank.hpp"

#include <Eigen/SparseQR>

#include "algebra/row_space.hpp"

namespace lamprey::transcription {

namespace {

// Singular directions end this far below the leading pivot; independent ones stay many orders above it.
constexpr double rank_threshold = 1e-9;

using Sparse = Eigen::SparseMatrix<double>;

// What goal rows see of the changes that keep every other row, [rows][variables].
MatrixXd left_to_goal(Transcription& transcription, const VectorXd& x, int rows) {
  VectorXd values;
  transcription.jacobian(x, values);
  const optimizer::SparsePattern& pattern = transcription.jacobian_pattern();
  const int others = transcription.goal_row(), variables = transcription.variable_count();
  std::vector<Eigen::Triplet<double>> kept, goal;  // transposed
  for (int e = 0; e < pattern.size(); ++e) {
    const auto n = static_cast<std::size_t>(e);
    if (pattern.rows[n] < others)
      kept.emplace_back(pattern.columns[n], pattern.rows[n], values[e]);
    else
      goal.emplace_back(pattern.columns[n], pattern.rows[n] - others, values[e]);
  }
  Sparse by_kept(variables, others), by_goal(variables, rows);
  by_kept.setFromTriplets(kept.begin(), kept.end());
  by_goal.setFromTriplets(goal.begin(), goal.end());
  const Eigen::SparseQR<Sparse, Eigen::COLAMDOrdering<int>> factors(by_kept);
  const MatrixXd turned = factors.matrixQ().transpose() * MatrixXd(by_goal);
  return turned.bottomRows(variables - factors.rank()).transpose();
}

}  // namespace

std::vector<GoalRow> independent_goal_rows(const model::System& system, const Maneuver& maneuver,
                                           const NodePath& path) {
  const std::vector<GoalRow> stated = stated_goal_rows(system, maneuver);
  Maneuver unparameterised = maneuver;
  unparameterised.spline_points = 0;
  unparameterised.cost_weights = {};
  Transcription transcription(system, unparameterised, stated);
  const MatrixXd left = left_to_goal(transcription, transcription.pack(path), static_cast<int>(stated.size()));
  std::vector<char> kept(stated.size());
  for (int r : algebra::independent_rows(left, rank_threshold)) kept[static_cast<std::size_t>(r)] = 1;
  std::vector<GoalRow> independent;
  for (std::size_t r = 0; r < stated.size(); ++r)
    if (kept[r]) independent.push_back(stated[r]);
  return independent;
}

}  // namespace lamprey::transcription
