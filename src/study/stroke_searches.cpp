#include "study/stroke_searches.hpp"

#include <algorithm>
#include <array>
#include <tuple>

#include "maneuver/gait_cycles.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/strokes.hpp"

namespace lamprey::study {

namespace {

using maneuver::NodePath;
using maneuver::Problem;

constexpr std::array stroke_counts = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
constexpr std::array cycle_counts = {2, 3, 5, 8, 16};
constexpr int guesses_of_cycle = 2;
constexpr double time_of_cycle = 0.1;  // of what is left
constexpr std::size_t solved_strokes = 4;
constexpr int least_steps_of_stroke = 12, steps_of_stroke = 20;
constexpr double goal_of_strokes = 1e-3;  // units of the end rows, what is missed

// Strokes towards the goal, and how they keep to the limits.
struct StrokesOnGrid {
  int strokes;
  bool within_limits;
  NodePath path = {};
  double missed = 0.0, broken = 0.0, cost = 0.0;
  std::tuple<bool, double, double, double> rank() const {
    return {path.rotation.empty(), missed > goal_of_strokes ? missed : 0.0, broken, cost};
  }
};

StrokesOnGrid swum(const Grids& grids, StrokesOnGrid tried) {
  const int steps = std::min(grids.problem().steps, std::max(grids.coarse(), tried.strokes * steps_of_stroke));
  Grid grid = grids.grid(steps);
  const maneuver::StrokeLimits kept =
      tried.within_limits ? maneuver::stroke_limits(grids.system(), grids.problem(), grid.maneuver, tried.strokes)
                          : maneuver::no_stroke_limits(grids.system());
  const maneuver::Strokes found =
      maneuver::strokes_to_goal(grids.system(), grid.maneuver, grids.reached().coordinates, grids.reached().rows, kept,
                                tried.strokes, seed_of_start(grids.problem(), 0));
  if (found.path.rotation.empty() || !grid.program.go_to(found.path)) return tried;
  tried.path = found.path;
  tried.missed = found.missed;
  tried.broken = grid.program.limit_violation();
  tried.cost = grid.program.cost();
  return tried;
}

// One of so many equal cycles of the gait, solved by itself in what a few such tries may take of the time.
Found smaller_gait(const Grids& grids, int cycles) {
  Problem smaller = grids.problem();
  smaller.steps = coarse_steps;  // fewer show turns that are none
  smaller.duration.value /= cycles;
  for (std::optional<double>& move : smaller.goal->move)
    if (move) *move /= cycles;
  if (smaller.goal->turn) *smaller.goal->turn /= cycles;
  if (smaller.search.time_limit)
    *smaller.search.time_limit = time_of_cycle * std::max(*smaller.search.time_limit - grids.budget().seconds(), 0.0);
  SolveOptions options;
  options.interrupted = grids.options().interrupted;
  const Budget budget(smaller, options);
  const std::unique_ptr<Method> method = newton_method(grids.system(), smaller, options, budget);
  Found found = method->solve_starts(0, 1).front();
  for (int guess = 1; guess < guesses_of_cycle && !found.converged() && !grids.budget().closing(); ++guess) {
    Found again = method->solve_starts(guess, 1).front();
    again.outcome.iterations += found.outcome.iterations;
    again.outcome.evaluations += found.outcome.evaluations;
    found = std::move(again);
  }
  return found;
}

}  // namespace

std::vector<Found> solve_swum_strokes(const Grids& grids) {
  std::vector<StrokesOnGrid> tries;
  for (int strokes : stroke_counts)
    for (const bool within_limits : {false, true})
      if (strokes * least_steps_of_stroke <= grids.problem().steps) tries.push_back({strokes, within_limits});
  grids.in_threads(static_cast<int>(tries.size()), "", [&](int n) {
    tries[static_cast<std::size_t>(n)] = swum(grids, tries[static_cast<std::size_t>(n)]);
    return Found();
  });
  std::sort(tries.begin(), tries.end(), [](const auto& a, const auto& b) { return a.rank() < b.rank(); });
  while (!tries.empty() && (tries.back().path.rotation.empty() || tries.size() > solved_strokes)) tries.pop_back();
  return grids.in_threads(static_cast<int>(tries.size()), "strokes", [&](int n) {
    const NodePath& path = tries[static_cast<std::size_t>(n)].path;
    Grid grid = grids.grid(steps_of(path));
    Found found;
    grids.solve(grid, path, fine_tolerance, found);
    return found;
  });
}

std::vector<Found> solve_cycles(const Grids& grids) {
  if (!grids.problem().start.free_shape || !grids.problem().waypoints.empty() ||
      !grids.problem().goal->rotation.empty())
    return {};
  std::vector<int> counts;
  for (int cycles : cycle_counts)
    if (cycles * least_steps_of_stroke <= grids.problem().steps) counts.push_back(cycles);
  return grids.in_threads(static_cast<int>(counts.size()), "strokes", [&](int n) {
    const int cycles = counts[static_cast<std::size_t>(n)];
    const int steps = std::min(grids.problem().steps, std::max(grids.coarse(), cycles * steps_of_stroke));
    const Found cycle = smaller_gait(grids, cycles);
    Found found;
    found.outcome = cycle.outcome;
    if (!cycle.converged()) {
      fail_for_want_of_motion(found.outcome);
      return found;
    }
    found.limit_multipliers = maneuver::repeated(cycle.limit_multipliers, cycles);
    Grid grid = grids.grid(steps);
    grids.solve(grid, maneuver::refined(grids.system(), maneuver::repeated(cycle.path, cycles), steps), fine_tolerance,
                found);
    return found;
  });
}

}  // namespace lamprey::study
