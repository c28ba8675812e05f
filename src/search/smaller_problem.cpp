#include "search/smaller_problem.hpp"

#include <algorithm>

#include <Eigen/QR>

#include "lie/so3.hpp"

namespace lamprey::search {

namespace {

using maneuver::Goal;
using maneuver::Problem;

constexpr int first_guesses = 4;
constexpr double share_of_time = 0.1;  // of what is left

// The n-th part of a displacement, m: the first of n that follow each other, each turned by `turn` (rad) from the one before. Where
// nothing is asked along an axis of the world the shortest one serves, or if nothing turns any.
std::array<std::optional<double>, 3> part_of_move(const std::array<std::optional<double>, 3>& move,
                                                  const Eigen::Vector3d& turn, int parts) {
  std::array<std::optional<double>, 3> part = move;
  if (turn.isZero(0.0)) {
    for (std::optional<double>& along : part)
      if (along) *along /= parts;
    return part;
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int n = 0; n < parts; ++n) sum += lie::exp(n * turn);
  Eigen::MatrixX3d rows(0, 3);
  Eigen::VectorXd asked(0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto& along = move[static_cast<std::size_t>(axis)];
    if (!along) continue;
    rows.conservativeResize(rows.rows() + 1, Eigen::NoChange);
    asked.conservativeResize(asked.size() + 1);
    rows.bottomRows<1>() = sum.row(axis);
    asked(asked.size() - 1) = *along;
  }
  if (asked.size() == 0) return part;
  const Eigen::Vector3d first = rows.completeOrthogonalDecomposition().solve(asked);
  for (int axis = 0; axis < 3; ++axis) part[static_cast<std::size_t>(axis)] = first(axis);
  return part;
}

void shorten(maneuver::Duration& duration, int parts) {
  for (double* seconds : {&duration.value, &duration.min, &duration.max}) *seconds /= parts;
}

}  // namespace

Problem cycle_of(const Problem& whole, int cycles, double strokes) {
  Problem cycle = whole;
  cycle.steps = coarse_steps;  // fewer show turns that are none
  shorten(cycle.duration, cycles);
  for (std::optional<double>& move : cycle.goal->move)
    if (move) *move /= strokes;
  if (cycle.goal->turn) *cycle.goal->turn /= strokes;
  cycle.goal->periodic = cycle.start.free_shape = true;
  cycle.goal->rest = cycle.goal->joints_rest = false;
  cycle.goal->shape_of_start = false;  // as gaits do anyway
  return cycle;
}

bool has_parts(const Problem& whole) {
  if (!whole.goal || !whole.goal->stills_joints() || whole.goal->periodic) return false;
  const auto still = [](const Eigen::Vector3d& rate) { return rate.isZero(0.0); };
  return whole.goal->rotation.empty() && whole.goal->angle.empty() && whole.waypoints.empty() &&
         whole.start.linear_velocity.isZero(0.0) &&
         std::all_of(whole.start.angular_velocity.begin(), whole.start.angular_velocity.end(), still);
}

Problem part_of(const Problem& whole, int parts) {
  Problem part = whole;
  Goal& goal = *part.goal;
  part.steps = coarse_steps;  // fewer show turns that are none
  shorten(part.duration, parts);
  goal.turn = goal.turn.value_or(Eigen::Vector3d::Zero()) / parts;
  goal.move = part_of_move(goal.move, *goal.turn, parts);
  return part;
}

Found solve_smaller(const Grids& grids, Problem smaller) {
  if (smaller.search.time_limit)
    *smaller.search.time_limit = share_of_time * std::max(*smaller.search.time_limit - grids.budget().seconds(), 0.0);
  SolveOptions options;
  options.interrupted = grids.options().interrupted;
  options.hurried = grids.options().hurried;
  const Budget budget(smaller, options, grids.budget());
  const std::unique_ptr<Method> method = newton_method(grids.system(), smaller, options, budget);
  const bool wins = smaller.cost_weights.of_displacement();  // then most arrive, and it is the cheapest that counts
  Found best = method->solve_starts(0, 1).front();
  for (int guess = 1; guess < first_guesses && (wins || !best.converged()) && !budget.closing(); ++guess) {
    Found other = method->solve_starts(guess, 1).front();
    if (!best.converged() || (other.converged() && other.cost < best.cost)) std::swap(best, other);
    count_effort(other.outcome, best.outcome);
  }
  return best;
}

}  // namespace lamprey::search
