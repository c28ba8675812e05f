#include "search/grids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "guess/guess.hpp"
#include "integrator/scheme.hpp"
#include "optimizer/limited_newton.hpp"
#include "search/workers.hpp"
#include "shape/composed_program.hpp"
#include "shape/reach.hpp"
#include "shape/single_angle.hpp"

namespace lamprey::search {

namespace {

using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;
using model::System;
using optimizer::Outcome;
using optimizer::Termination;
using shape::ShapeProgram;

constexpr std::array reach_steps = {20, 40, 80};  // rank and reach do not depend on the resolution; motions may need it
constexpr int reach_guesses = 4;                  // first guesses, on each of these grids, until one is a motion
constexpr int most_refinement = 10;               // times as many steps from one grid to the next
constexpr int composed_steps = 50;                // of the first grid of a scheme above order 2
constexpr int most_iterations = 500;
constexpr int patience = 6;            // times as many, along valleys that go on falling
constexpr double rough_limits = 1e-3;  // error of limits, in units of their rows
constexpr double fine_limits = 1e-9;
constexpr double same_solution = 0.1;   // relative difference of cost between grids
constexpr double limited_share = 1e-2;  // of the tolerance: a last Newton step is no good where limits begin to hold

// The problem whose coarse answers a search begins with: above order 2 that of the trapezoid.
Problem coarse_problem(const Problem& problem) {
  Problem coarse = problem;
  if (integrator::single_step(problem.scheme)) return coarse;
  coarse.scheme = maneuver::Scheme::trapezoid;
  coarse.steps = coarse_steps;
  return coarse;
}

// By each of which a body may turn by a quarter.
int steps_of_scheme(const Problem& problem) {
  return integrator::single_step(problem.scheme) ? problem.steps
                                                 : problem.steps * integrator::composition(problem.scheme).stages();
}

}  // namespace

Grid::Grid(const System& system, const Problem& problem, int steps, const Reached& reached,
           const std::vector<maneuver::LimitRow>& limits)
    : maneuver(maneuver::make_maneuver(system, problem, steps)),
      program(system, maneuver, reached.coordinates, reached.rows, limits, steps_for(steps)),
      newton(program.sizes()) {}

int steps_of(const NodePath& path) { return static_cast<int>(path.rotation.size()) - 1; }

Grids::Grids(const System& system, const Problem& problem, const SolveOptions& options, const Budget& budget)
    : system_(system),
      asked_(problem),
      problem_(coarse_problem(problem)),
      options_(options),
      budget_(budget),
      reached_(system, problem),
      limits_(maneuver::limit_rows(system, problem)) {}

bool Grids::composed() const { return !integrator::single_step(asked_.scheme); }

Grids Grids::with(const Problem& problem) const {
  Grids of = *this;
  of.problem_ = problem;
  of.limits_ = maneuver::limit_rows(system_, problem);
  return of;
}

Grid Grids::grid(int steps) const { return {system_, problem_, steps, reached_, limits_}; }

Grid Grids::grid(const Problem& problem, int steps) const {
  return {system_, problem, steps, reached_, maneuver::limit_rows(system_, problem)};
}

int Grids::coarse() const { return std::min(problem_.steps, coarse_steps); }

int Grids::finer_than(int steps) const {
  if (steps == coarse_steps && problem_.steps >= 4 * coarse_steps) return 2 * coarse_steps;
  return std::min(problem_.steps, steps * most_refinement);
}

optimizer::Options Grids::within(double tolerance) const {
  optimizer::Options options = budget_.optimizer_options(most_iterations, tolerance);
  options.patience = patience;
  return options;
}

void Grids::solve(Grid& grid, const NodePath& from, double tolerance, Found& found) const {
  solve(grid, from, within(tolerance), found);
}

void Grids::solve(Grid& grid, const NodePath& from, const optimizer::Options& within, Found& found) const {
  fail_for_want_of_motion(found.outcome);
  if (!begin(grid, from, found)) return;
  solve_program(grid.newton, grid.program, within, found.outcome);
  read(grid, found);
}

bool Grids::hold(Grid& grid, const NodePath& motion, Found& found) const {
  if (!begin(grid, motion, found)) return false;
  read(grid, found);
  return true;
}

// At a motion, with what a search has found before. Returns false where there is none.
bool Grids::begin(Grid& grid, const NodePath& from, Found& found) const {
  if (found.duration == 0.0) found.duration = problem_.duration.value;
  grid.program.take_duration(found.duration);
  grid.program.take_end_multipliers(found.end_multipliers);
  grid.program.take_limit_multipliers(found.limit_multipliers);
  grid.program.take_work_multipliers(found.work_multipliers);
  return grid.program.go_to(from);
}

// Where the program is.
void Grids::read(const Grid& grid, Found& found) const {
  found.path = grid.program.path();
  found.cost = grid.program.cost();
  found.end_multipliers = grid.program.end_multipliers();
  found.duration = grid.program.duration();
  found.limit_multipliers = grid.program.limit_multipliers();
  found.work_multipliers = grid.program.work_multipliers();
  if (problem_.cost_weights.any()) found.cost_parts = grid.program.cost_parts();
}

Found Grids::carry_on(const Found& from, int steps, double tolerance) const {
  return carry_on(from, steps, within(tolerance));
}

Found Grids::carry_on(const Found& from, int steps, const optimizer::Options& within) const {
  Grid grid = this->grid(steps);
  Found found = from;
  found.path = NodePath();
  solve(grid, on_grid(from, steps), within, found);
  const int from_steps = steps_of(from.path);
  found.coarser = from.converged() && from_steps < steps && steps % from_steps == 0 ? from.path : NodePath();
  return found;
}

Found Grids::carry_on_composed(const Found& from, int steps) const {
  const int stages = integrator::composition(asked_.scheme).stages();
  const NodePath nodes = from.path.polynomial.empty() ? from.path : guess::nodes_of_steps(from.path, stages);
  const Maneuver maneuver = maneuver::make_maneuver(system_, asked_, steps);
  shape::ComposedProgram program(system_, maneuver, asked_.scheme, reached_.coordinates, reached_.rows);
  Found found = from;
  found.path = NodePath();
  fail_for_want_of_motion(found.outcome);
  program.take_end_multipliers(from.end_multipliers);
  if (program.go_to(guess::refined(system_, nodes, steps, asked_.scheme))) {
    optimizer::StageNewton(program.sizes()).solve(program, within(fine_tolerance), found.outcome);
    found.path = program.path();
    found.cost = program.cost();
    found.end_multipliers = program.end_multipliers();
  }
  return found;
}

Found Grids::refine(const Found& coarse) const {
  if (composed()) return refine_composed(coarse);
  Found found = coarse;
  if (steps_of(found.path) < asked_.steps) add_coarser(found);
  for (int steps = std::max(this->coarse(), steps_of(found.path));
       steps < problem_.steps && !found.path.rotation.empty();) {
    steps = finer_than(steps);
    found = carry_on(found, steps, fine_tolerance);
  }
  return found;
}

std::vector<Found> Grids::in_threads(int count, const char* what, const std::function<Found(int)>& task) const {
  std::vector<std::optional<Found>> all(static_cast<std::size_t>(count));
  int done = 0;
  std::mutex telling;
  run_in_threads(count, options_.workers, [&](int n) {
    if (budget_.closing() && n > 0) return;
    all[static_cast<std::size_t>(n)] = task(n);
    const Found& found = *all[static_cast<std::size_t>(n)];
    if (found.converged() || found.held()) budget_.arrived();
    const std::scoped_lock lock(telling);
    ++done;
    if (options_.progress && *what != '\0')
      options_.progress(std::string(what) + " " + std::to_string(done) + " of " + std::to_string(count));
  });
  std::vector<Found> begun;
  for (std::optional<Found>& found : all)
    if (found) begun.push_back(std::move(*found));
  return begun;
}

NodePath Grids::on_grid(const Found& from, int steps) const {
  if (from.coarser.rotation.empty()) return guess::refined(system_, from.path, steps);
  return guess::extrapolated(system_, from.path, from.coarser, integrator::order(problem_.scheme), steps);
}

// The same solution with half the steps, from which finer grids can be foretold.
void Grids::add_coarser(Found& found) const {
  const int steps = steps_of(found.path);
  if (!found.converged() || steps % 2 != 0) return;
  Found half = found;
  half.coarser = NodePath();
  half = carry_on(half, steps / 2, fine_tolerance);
  found.outcome.history = half.outcome.history;
  found.outcome.iterations = half.outcome.iterations;
  found.outcome.evaluations = half.outcome.evaluations;
  if (half.converged() &&
      std::abs(half.cost - found.cost) < same_solution * std::abs(found.cost - problem_.cost_of_given_duration()))
    found.coarser = half.path;
}

// On to the scheme above order 2, from coarse to fine.
Found Grids::refine_composed(const Found& coarse) const {
  Found found = coarse;
  for (int steps = std::min(asked_.steps, composed_steps); !found.path.rotation.empty();
       steps = std::min(asked_.steps, steps * most_refinement)) {
    found = carry_on_composed(found, steps);
    if (steps == asked_.steps) break;
  }
  return found;
}

void fail_for_want_of_motion(Outcome& outcome) {
  outcome.termination = Termination::stalled;
  outcome.reason = "no motion was found through the first guess of the shapes";
  outcome.infeasibility = std::numeric_limits<double>::infinity();
}

void take_effort(const Found& tried, Found& found) {
  found.outcome.history = tried.outcome.history;
  found.outcome.iterations = tried.outcome.iterations;
  found.outcome.evaluations = tried.outcome.evaluations;
}

shape::Steps steps_for(int steps) { return steps < coarse_steps ? shape::Steps::rough : shape::Steps::faithful; }

Reached::Reached(const System& system, const Problem& asked) : coordinates(system) {
  const Problem problem = coarse_problem(asked);
  for (const int steps : reach_steps) {
    const Maneuver probe = maneuver::make_maneuver(system, problem, steps);
    Maneuver swinging = probe;  // as moments bend joints, not as the goal asks of them
    swinging.end_joint.clear();
    for (int start = 0; start < reach_guesses; ++start) {
      const NodePath guess = guess::random_guess(system, swinging, seed_of_start(problem, start));
      const auto moved = shape::reachable_coordinates(system, probe, guess);
      if (!moved) continue;
      const auto met = shape::independent_end_rows(system, probe, *moved, guess);
      if (!met) continue;
      coordinates = *moved;
      rows = *met;
      shape::refuse_price_of_no_displacement(system, probe, coordinates);
      shape::refuse_price_of_no_whole_turn(system, probe, problem.limits, steps_of_scheme(asked));
      out_of_reach = shape::out_of_reach(system, probe, problem.waypoints, coordinates, guess);
      if (out_of_reach.empty())
        out_of_reach = shape::beyond_single_angle(system, probe, problem.limits, steps_of_scheme(asked));
      return;
    }
  }
  rows = shape::all_end_rows(system, maneuver::make_maneuver(system, problem, reach_steps[0]), coordinates);
}

void solve_program(optimizer::StageNewton& newton, ShapeProgram& program, optimizer::Options options,
                   optimizer::Outcome& outcome) {
  const bool rough = options.tolerance > fine_tolerance;
  if (!rough && program.limited()) options.tolerance *= limited_share;
  if (rough) options.exact_limits = false;
  optimizer::solve_within_limits(newton, program, options, rough ? rough_limits : fine_limits, outcome);
  const bool cut_short = outcome.termination == optimizer::Termination::time_limit ||
                         outcome.termination == optimizer::Termination::interrupted;
  for (const std::string& detail : {program.largest_violation(cut_short), program.largest_miss()})
    if (!detail.empty()) outcome.reason += "; " + detail;
}

}  // namespace lamprey::search
