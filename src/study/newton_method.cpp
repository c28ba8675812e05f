#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <tuple>

#include "integrator/scheme.hpp"
#include "maneuver/composed_program.hpp"
#include "maneuver/gait_cycles.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/passive_joints.hpp"
#include "maneuver/reach.hpp"
#include "maneuver/shape_program.hpp"
#include "maneuver/strokes.hpp"
#include "optimizer/limited_newton.hpp"
#include "study/method.hpp"
#include "study/workers.hpp"

namespace lamprey::study {

namespace {

using maneuver::EndRow;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;
using maneuver::ShapeCoordinates;
using maneuver::ShapeProgram;
using model::System;
using optimizer::Outcome;
using optimizer::Termination;

constexpr std::array reach_steps = {20, 40, 80};  // rank and reach do not depend on the resolution; motions may need it
constexpr int reach_guesses = 4;                  // first guesses, on each of these grids, until one is a motion
constexpr int first_steps = 25;                   // of the grid on which a first guess becomes a maneuver
constexpr int finest_first_steps = 4 * coarse_steps;  // where those show too little
constexpr int most_refinement = 10;                   // times as many steps from one grid to the next
constexpr int composed_steps = 50;                    // of the first grid of a scheme above order 2
constexpr int most_iterations = 500;
constexpr int patience = 6;              // times as many, along valleys that go on falling
constexpr int carried_iterations = 100;  // to another grid, where the same solution is near or is not found
constexpr double rough_tolerance = 1e-4;
constexpr double fine_tolerance = 1e-7;  // before a last Newton step
constexpr double rough_limits = 1e-3;    // error of limits, in units of their rows
constexpr double fine_limits = 1e-9;
constexpr std::array stroke_counts = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
constexpr std::array cycle_counts = {2, 3, 5, 8, 16};
constexpr int guesses_of_cycle = 2;
constexpr double time_of_cycle = 0.1;  // of what is left
constexpr std::size_t solved_strokes = 4;
constexpr int least_steps_of_stroke = 12, steps_of_stroke = 20;
constexpr double goal_of_strokes = 1e-3;  // units of the end rows, what is missed
constexpr double same_solution = 0.1;     // relative difference of cost between grids
constexpr double limited_share = 1e-2;    // of the tolerance: a last Newton step is no good where limits begin to hold

// A program and its solver at one resolution.
struct Grid {
  Maneuver maneuver;
  ShapeProgram program;
  optimizer::StageNewton newton;
  Grid(const System& system, const Problem& problem, int steps, const ShapeCoordinates& coordinates,
       const std::vector<EndRow>& rows, const std::vector<maneuver::LimitRow>& limits)
      : maneuver(maneuver::make_maneuver(system, problem, steps)),
        program(system, maneuver, coordinates, rows, limits, steps_for(steps)),
        newton(program.sizes()) {}
};

// The problem whose coarse answers a search begins with: above order 2 that of the trapezoid.
Problem coarse_problem(const Problem& problem) {
  Problem coarse = problem;
  if (integrator::single_step(problem.scheme)) return coarse;
  coarse.scheme = maneuver::Scheme::trapezoid;
  coarse.steps = coarse_steps;
  return coarse;
}

class NewtonMethod : public Method {
 public:
  NewtonMethod(const System& system, const Problem& problem, const SolveOptions& options, const Budget& budget)
      : system_(system),
        asked_(problem),
        problem_(coarse_problem(problem)),
        options_(options),
        budget_(budget),
        reached_(system, problem_) {
    limits_ = maneuver::limit_rows(system, problem);
  }

  std::string name() const override { return "lamprey newton"; }
  std::string out_of_reach() const override { return reached_.out_of_reach; }

  std::vector<Found> solve_starts(int first, int count) override {
    return in_threads(count, "start", [&](int n) { return solve_start(first + n); });
  }

  std::vector<Found> solve_strokes() override {
    const bool single = reached_.coordinates.shape.cols() == 1;  // which wins nothing by strokes
    if (budget_.closing() || single || problem_.duration.free || !problem_.goal) return {};
    if (problem_.goal->periodic) return solve_cycles();
    if (passive()) return {};
    return solve_swum_strokes();
  }

  // Few strokes or many, more than once each; the most promising are solved.
  std::vector<Found> solve_swum_strokes() {
    std::vector<StrokesOnGrid> tries;
    for (int strokes : stroke_counts)
      for (const bool within_limits : {false, true})
        if (strokes * least_steps_of_stroke <= problem_.steps) tries.push_back({strokes, within_limits});
    in_threads(static_cast<int>(tries.size()), "", [&](int n) {
      tries[static_cast<std::size_t>(n)] = swum(tries[static_cast<std::size_t>(n)]);
      return Found();
    });
    std::sort(tries.begin(), tries.end(), [](const auto& a, const auto& b) { return a.rank() < b.rank(); });
    while (!tries.empty() && (tries.back().path.rotation.empty() || tries.size() > solved_strokes)) tries.pop_back();
    return in_threads(static_cast<int>(tries.size()), "strokes", [&](int n) {
      const NodePath& path = tries[static_cast<std::size_t>(n)].path;
      Grid grid(system_, problem_, steps_of(path), reached_.coordinates, reached_.rows, limits_);
      Found found;
      solve(grid, path, fine_tolerance, found);
      return found;
    });
  }

  // From a smaller gait, done several times over.
  std::vector<Found> solve_cycles() {
    if (!problem_.start.free_shape || !problem_.waypoints.empty() || !problem_.goal->rotation.empty()) return {};
    std::vector<int> counts;
    for (int cycles : cycle_counts)
      if (cycles * least_steps_of_stroke <= problem_.steps) counts.push_back(cycles);
    return in_threads(static_cast<int>(counts.size()), "strokes", [&](int n) {
      const int cycles = counts[static_cast<std::size_t>(n)];
      const int steps = std::min(problem_.steps, std::max(coarse_of(problem_.steps), cycles * steps_of_stroke));
      const Found cycle = smaller_gait(cycles);
      Found found;
      found.outcome = cycle.outcome;
      if (!cycle.converged()) {
        fail_for_want_of_motion(found.outcome);
        return found;
      }
      found.limit_multipliers = maneuver::repeated(cycle.limit_multipliers, cycles);
      Grid grid(system_, problem_, steps, reached_.coordinates, reached_.rows, limits_);
      solve(grid, maneuver::refined(system_, maneuver::repeated(cycle.path, cycles), steps), fine_tolerance, found);
      return found;
    });
  }

  // One of so many equal cycles of the gait, solved by itself in what a few such tries may take of the time.
  Found smaller_gait(int cycles) const {
    Problem smaller = problem_;
    smaller.steps = coarse_steps;  // fewer show turns that are none
    smaller.duration.value /= cycles;
    for (std::optional<double>& move : smaller.goal->move)
      if (move) *move /= cycles;
    if (smaller.goal->turn) *smaller.goal->turn /= cycles;
    if (smaller.search.time_limit)
      *smaller.search.time_limit = time_of_cycle * std::max(*smaller.search.time_limit - budget_.seconds(), 0.0);
    SolveOptions options;
    options.interrupted = options_.interrupted;
    const Budget budget(smaller, options);
    NewtonMethod method(system_, smaller, options, budget);
    Found found = method.solve_starts(0, 1).front();
    for (int guess = 1; guess < guesses_of_cycle && !found.converged() && !budget_.closing(); ++guess) {
      Found again = method.solve_starts(guess, 1).front();
      again.outcome.iterations += found.outcome.iterations;
      again.outcome.evaluations += found.outcome.evaluations;
      found = std::move(again);
    }
    return found;
  }

  std::vector<Found> hop(const Found& from, int first, int count) override {
    return in_threads(count, "", [&](int n) {
      Grid grid(system_, problem_, steps_of(from.path), reached_.coordinates, reached_.rows, limits_);
      Found found;
      found.duration = from.duration;
      solve(grid, maneuver::perturbed(system_, from.path, seed_of_hop(problem_, first + n)), fine_tolerance, found);
      return found;
    });
  }

  std::vector<Found> refine(const std::vector<const Found*>& coarse) override {
    return in_threads(static_cast<int>(coarse.size()), "refined", [&](int n) {
      const Found& from = *coarse[static_cast<std::size_t>(n)];
      Found found = from;
      const bool to_refine = steps_of(from.path) < asked_.steps;
      if (to_refine && integrator::single_step(asked_.scheme)) add_coarser(found);
      if (!integrator::single_step(asked_.scheme))
        found = refine_composed(found);
      else
        for (int steps = std::max(coarse_of(problem_.steps), steps_of(found.path));
             steps < problem_.steps && !found.path.rotation.empty();) {
          steps = finer_of(steps);
          found = carry_on(found, steps, fine_tolerance);
        }
      found.outcome.iterations -= from.outcome.iterations;  // which the search has counted
      found.outcome.evaluations -= from.outcome.evaluations;
      return found;
    });
  }

  Found carry(const Found& from, int steps) override {
    if (!from.path.polynomial.empty()) return carry_on_composed(from, steps);
    optimizer::Options within = options(fine_tolerance);
    within.exact_limits = steps == steps_of(from.path);  // else cost and nodes are asked for, not multipliers
    if (limits_.empty()) {                               // else rounds within limits have their own numbers
      within.max_iterations = carried_iterations;
      within.patience = 1;
    }
    return carry_on(from, steps, within);
  }
  bool carries_cheaply() const override { return true; }

 private:
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

  StrokesOnGrid swum(StrokesOnGrid tried) const {
    const int steps = std::min(problem_.steps, std::max(coarse_of(problem_.steps), tried.strokes * steps_of_stroke));
    Grid grid(system_, problem_, steps, reached_.coordinates, reached_.rows, limits_);
    const maneuver::StrokeLimits kept = tried.within_limits
                                            ? maneuver::stroke_limits(system_, problem_, grid.maneuver, tried.strokes)
                                            : maneuver::no_stroke_limits(system_);
    const maneuver::Strokes found = maneuver::strokes_to_goal(
        system_, grid.maneuver, reached_.coordinates, reached_.rows, kept, tried.strokes, seed_of_start(problem_, 0));
    if (found.path.rotation.empty() || !grid.program.go_to(found.path)) return tried;
    tried.path = found.path;
    tried.missed = found.missed;
    tried.broken = grid.program.limit_violation();
    tried.cost = grid.program.cost();
    return tried;
  }

  static int coarse_of(int steps) { return std::min(steps, coarse_steps); }

  // From a coarse grid first to twice as many steps: what it foretold wrongly is cheaper to mend there.
  int finer_of(int steps) const {
    if (steps == coarse_steps && problem_.steps >= 4 * coarse_steps) return 2 * coarse_steps;
    return std::min(problem_.steps, steps * most_refinement);
  }

  // Tasks 0 … count − 1, each by itself, so that results do not depend on the number of threads; told of by name if any.
  // Results of those that began before the search had to stop; of the first always.
  std::vector<Found> in_threads(int count, const char* what, const std::function<Found(int)>& task) const {
    std::vector<std::optional<Found>> all(static_cast<std::size_t>(count));
    int done = 0;
    std::mutex telling;
    run_in_threads(count, options_.workers, [&](int n) {
      if (budget_.closing() && n > 0) return;
      all[static_cast<std::size_t>(n)] = task(n);
      if (all[static_cast<std::size_t>(n)]->converged()) budget_.arrived();
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

  // With what the motion to begin with comes with.
  Found begun_as_asked() const {
    Found found;
    found.duration = options_.first->duration;
    found.limit_multipliers = options_.first->limit_multipliers;
    found.work_multipliers = options_.first->work_multipliers;
    return found;
  }

  // The motion to begin with may be an answer on these very steps: then it is found again, and not another one from coarser ones.
  Found answer_at_hand() const {
    Found found;
    if (steps_of(options_.first->path) != asked_.steps || !integrator::single_step(asked_.scheme)) return found;
    found = begun_as_asked();
    optimizer::Options within = options(fine_tolerance);
    within.most_iterations = within.max_iterations = carried_iterations;
    within.exact_limits = false;  // an answer has what its limits are worth
    Grid grid(system_, problem_, asked_.steps, reached_.coordinates, reached_.rows, limits_);
    solve(grid, options_.first->path, within, found);
    return found;
  }

  Found solve_start(int start) const {
    const Found at_hand = begins_as_asked(start) ? answer_at_hand() : Found();
    if (at_hand.converged()) return at_hand;
    const int coarse = coarse_of(problem_.steps);
    const int first = begins_as_asked(start) ? coarse : std::min(coarse, first_steps);
    Found found = solve_guess(start, first, first < coarse ? rough_tolerance : fine_tolerance, at_hand.outcome);
    if (coarse <= first_steps) return found;
    if (found.outcome.termination == Termination::infeasible)
      found.limit_multipliers = {};  // those of limits never kept
    if (first < coarse && !found.path.rotation.empty()) found = carry_on(found, coarse, fine_tolerance);
    found.coarser = NodePath();                                     // a rough answer foretells nothing
    const bool composed = !integrator::single_step(asked_.scheme);  // a step is many of these
    const int finest = composed ? finest_first_steps : std::min(problem_.steps, finest_first_steps);
    for (int steps = coarse; may_need_more_steps(found); steps = std::min(2 * steps, finest)) {
      const Found again = solve_guess(start, steps, fine_tolerance, found.outcome);
      if (again.converged()) return again;
      add_effort(again, found);
      if (steps == finest) break;
    }
    if (!problem_.duration.free) return found;
    const maneuver::Duration& asked = problem_.duration;  // which may lead astray
    for (const double duration : {std::sqrt(asked.min * asked.max), asked.value}) {
      if (found.converged() || budget_.closing()) break;
      const Found again = solve_held(start, coarse, duration, found.outcome);
      if (again.converged()) return again;
      add_effort(again, found);
    }
    return found;
  }

  // Of another try, which did not arrive.
  static void add_effort(const Found& tried, Found& found) {
    found.outcome.history = tried.outcome.history;
    found.outcome.iterations = tried.outcome.iterations;
    found.outcome.evaluations = tried.outcome.evaluations;
  }

  // From a first guess in a given duration, which then is set free.
  Found solve_held(int start, int steps, double duration, const Outcome& before) const {
    Problem held = problem_;
    held.duration.free = false;
    held.duration.value = duration;
    Found found;
    found.outcome = before;
    found.duration = duration;
    Grid grid(system_, held, steps, reached_.coordinates, reached_.rows, maneuver::limit_rows(system_, held));
    solve(grid, first_guess(grid, start), fine_tolerance, found);
    if (!found.converged()) return found;
    const NodePath path = std::move(found.path);
    found.limit_multipliers = {};  // of fewer rows
    Grid freed(system_, problem_, steps, reached_.coordinates, reached_.rows, limits_);
    solve(freed, path, fine_tolerance, found);
    return found;
  }

  // Whether some coordinates are moved by no moment.
  bool passive() const { return reached_.coordinates.shape.cols() > system_.control_count(); }

  // Few steps may have led to turns that more steps do not show, or do not show turns that the motion takes.
  bool may_need_more_steps(const Found& found) const {
    if (found.converged() || found.outcome.termination == Termination::infeasible || budget_.closing()) return false;
    return passive() || found.path.rotation.empty() || largest_turn(found.path.rotation).angle > nearly_quarter_turn;
  }

  // From a first guess; effort and history of `before` go on.
  Found solve_guess(int start, int steps, double tolerance, const Outcome& before) const {
    Found found = begins_as_asked(start) ? begun_as_asked() : Found();
    found.outcome = before;
    Grid grid(system_, problem_, steps, reached_.coordinates, reached_.rows, limits_);
    const NodePath guess = first_guess(grid, start);
    solve(grid, guess, tolerance, found);
    const bool led = begins_as_asked(start) && options_.first->limit_multipliers.weight > 0.0;
    if (!led || found.converged() || budget_.closing()) return found;
    Found again;  // multipliers of other limits lead astray
    again.outcome = found.outcome;
    again.duration = options_.first->duration;
    solve(grid, guess, tolerance, again);
    if (again.converged()) return again;
    add_effort(again, found);
    return found;
  }

  bool begins_as_asked(int start) const { return start == 0 && options_.first.has_value(); }

  NodePath first_guess(const Grid& grid, int start) const {
    if (begins_as_asked(start)) return maneuver::refined(system_, options_.first->path, grid.maneuver.steps);
    NodePath guess = maneuver::random_guess(system_, grid.maneuver, seed_of_start(problem_, start));
    if (passive() && !problem_.goal->periodic)
      guess = maneuver::with_passive_joints(system_, grid.maneuver, reached_.coordinates, guess).value_or(guess);
    return guess;
  }

  Found carry_on(const Found& from, int steps, double tolerance) const {
    return carry_on(from, steps, options(tolerance));
  }

  Found carry_on(const Found& from, int steps, const optimizer::Options& within) const {
    Grid grid(system_, problem_, steps, reached_.coordinates, reached_.rows, limits_);
    Found found = from;
    found.path = NodePath();
    solve(grid, on_grid(from, steps), within, found);
    const int from_steps = steps_of(from.path);
    found.coarser = from.converged() && from_steps < steps && steps % from_steps == 0 ? from.path : NodePath();
    return found;
  }

  static int steps_of(const NodePath& path) { return static_cast<int>(path.rotation.size()) - 1; }

  NodePath on_grid(const Found& from, int steps) const {
    if (from.coarser.rotation.empty()) return maneuver::refined(system_, from.path, steps);
    return maneuver::extrapolated(system_, from.path, from.coarser, integrator::order(problem_.scheme), steps);
  }

  // The same solution with half the steps, from which finer grids can be foretold.
  void add_coarser(Found& found) const {
    const int steps = steps_of(found.path);
    if (!found.converged() || steps % 2 != 0) return;
    Found half = found;
    half.coarser = NodePath();
    half = carry_on(half, steps / 2, fine_tolerance);
    found.outcome.history = half.outcome.history;
    found.outcome.iterations = half.outcome.iterations;
    found.outcome.evaluations = half.outcome.evaluations;
    if (half.converged() && std::abs(half.cost - found.cost) < same_solution * std::abs(found.cost))
      found.coarser = half.path;
  }

  // On to the scheme above order 2, from coarse to fine.
  Found refine_composed(const Found& coarse) const {
    Found found = coarse;
    for (int steps = std::min(asked_.steps, composed_steps); !found.path.rotation.empty();
         steps = std::min(asked_.steps, steps * most_refinement)) {
      found = carry_on_composed(found, steps);
      if (steps == asked_.steps) break;
    }
    return found;
  }

  Found carry_on_composed(const Found& from, int steps) const {
    const int stages = integrator::composition(asked_.scheme).stages();
    const NodePath nodes = from.path.polynomial.empty() ? from.path : maneuver::nodes_of_steps(from.path, stages);
    const Maneuver maneuver = maneuver::make_maneuver(system_, asked_, steps);
    maneuver::ComposedProgram program(system_, maneuver, asked_.scheme, reached_.coordinates, reached_.rows);
    Found found = from;
    found.path = NodePath();
    fail_for_want_of_motion(found.outcome);
    program.take_end_multipliers(from.end_multipliers);
    if (program.go_to(maneuver::refined(system_, nodes, steps, asked_.scheme))) {
      optimizer::StageNewton(program.sizes()).solve(program, options(fine_tolerance), found.outcome);
      found.path = program.path();
      found.cost = program.cost();
      found.end_multipliers = program.end_multipliers();
    }
    return found;
  }

  optimizer::Options options(double tolerance) const {
    optimizer::Options options = budget_.optimizer_options(most_iterations, tolerance);
    options.patience = patience;
    return options;
  }

  static void fail_for_want_of_motion(optimizer::Outcome& outcome) {
    outcome.termination = optimizer::Termination::stalled;
    outcome.reason = "no motion was found through the first guess of the shapes";
    outcome.infeasibility = std::numeric_limits<double>::infinity();
  }

  // Effort and history of `found` go on.
  void solve(Grid& grid, const NodePath& from, double tolerance, Found& found) const {
    solve(grid, from, options(tolerance), found);
  }

  void solve(Grid& grid, const NodePath& from, const optimizer::Options& within, Found& found) const {
    fail_for_want_of_motion(found.outcome);
    if (found.duration == 0.0) found.duration = problem_.duration.value;
    grid.program.take_duration(found.duration);
    grid.program.take_end_multipliers(found.end_multipliers);
    grid.program.take_limit_multipliers(found.limit_multipliers);
    grid.program.take_work_multipliers(found.work_multipliers);
    if (grid.program.go_to(from)) {
      solve_program(grid.newton, grid.program, within, found.outcome);
      found.path = grid.program.path();
      found.cost = grid.program.cost();
      found.end_multipliers = grid.program.end_multipliers();
      found.duration = grid.program.duration();
      found.limit_multipliers = grid.program.limit_multipliers();
      found.work_multipliers = grid.program.work_multipliers();
      if (problem_.cost_weights.any()) found.cost_parts = grid.program.cost_parts();
    }
  }

  const System& system_;
  const Problem& asked_;
  Problem problem_;  // of the grids up to order 2
  const SolveOptions& options_;
  const Budget& budget_;
  Reached reached_;
  std::vector<maneuver::LimitRow> limits_;
};

}  // namespace

maneuver::Steps steps_for(int steps) {
  return steps < coarse_steps ? maneuver::Steps::rough : maneuver::Steps::faithful;
}

Reached::Reached(const System& system, const Problem& problem) : coordinates(system) {
  for (const int steps : reach_steps) {
    const Maneuver probe = maneuver::make_maneuver(system, problem, steps);
    for (int start = 0; start < reach_guesses; ++start) {
      const NodePath guess = maneuver::random_guess(system, probe, seed_of_start(problem, start));
      const auto moved = maneuver::reachable_coordinates(system, probe, guess);
      if (!moved) continue;
      const auto met = maneuver::independent_end_rows(system, probe, *moved, guess);
      if (!met) continue;
      coordinates = *moved;
      rows = *met;
      maneuver::refuse_price_of_no_displacement(probe, coordinates);
      out_of_reach = maneuver::out_of_reach(system, probe, coordinates, guess);
      return;
    }
  }
  rows = maneuver::all_end_rows(system, maneuver::make_maneuver(system, problem, reach_steps[0]), coordinates);
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

bool newton_takes(const System& system, const Problem& problem) {
  if (problem.control != maneuver::ControlKind::steps) return false;
  const bool more = problem.limits.any() || problem.cost_weights.any() || problem.duration.free ||
                    !problem.waypoints.empty() || (problem.goal && problem.goal->periodic);
  if (!integrator::single_step(problem.scheme) && more) return false;
  return !maneuver::has_momentum(system, problem.start);
}

std::unique_ptr<Method> newton_method(const System& system, const Problem& problem, const SolveOptions& options,
                                      const Budget& budget) {
  return std::make_unique<NewtonMethod>(system, problem, options, budget);
}

}  // namespace lamprey::study
