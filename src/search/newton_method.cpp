#include <algorithm>
#include <array>
#include <cmath>

#include "guess/guess.hpp"
#include "guess/passive_joints.hpp"
#include "integrator/scheme.hpp"
#include "search/drifting.hpp"
#include "search/grids.hpp"
#include "search/parts.hpp"
#include "search/slower_joints.hpp"
#include "search/stroke_searches.hpp"

namespace lamprey::search {

namespace {

using maneuver::NodePath;
using maneuver::Problem;
using model::System;
using optimizer::Outcome;
using optimizer::Termination;

constexpr int first_steps = 25;                       // of the grid on which a first guess becomes a maneuver
constexpr int finest_first_steps = 4 * coarse_steps;  // where those show too little
constexpr int carried_iterations = 100;  // to another grid, where the same solution is near or is not found
constexpr double rough_tolerance = 1e-4;
constexpr std::array strokes_of_gaits = {0.5, 1.0, 0.0};  // of a guess, that passive joints go along with; 0: none
constexpr double more_worth = 10.0;                       // times what a displacement is

// Van der Corput's sequence: ½, ¼, ¾, ⅛, …
double radical_inverse(int n) {
  double value = 0.0;
  for (double digit = 0.5; n > 0; n /= 2, digit *= 0.5) value += n % 2 == 1 ? digit : 0.0;
  return value;
}

class NewtonMethod : public Method {
 public:
  NewtonMethod(const System& system, const Problem& problem, const SolveOptions& options, const Budget& budget)
      : grids_(system, problem, options, budget), drifts_(maneuver::has_momentum(system, problem.start)) {}

  std::string name() const override { return "lamprey newton"; }
  std::string out_of_reach() const override { return grids_.reached().out_of_reach; }

  std::vector<Found> solve_starts(int first, int count) override {
    return grids_.in_threads(count, "first guess", [&](int n) { return solve_start(first + n); });
  }

  bool has_strokes() const override {
    const bool single = grids_.reached().coordinates.shape.cols() == 1;  // which wins nothing by strokes
    const Problem& problem = grids_.problem();
    return !single && problem.goal && !drifts_;
  }

  std::vector<Found> solve_strokes() override {
    if (!has_strokes() || grids_.budget().closing()) return {};
    if (grids_.problem().goal->periodic) return solve_cycles(grids_);
    std::vector<Found> found = solve_in_parts(grids_);
    const auto ends = [&] { return any_converged(found) || grids_.budget().closing(); };
    if (!ends() && !grids_.passive()) append(solve_swum_strokes(grids_), found);  // which bend every joint
    if (!ends() && !grids_.passive()) append(solve_whole_turns(grids_), found);
    if (!ends()) append(solve_gaits_from_rest(grids_), found);
    return found;
  }

  std::vector<Found> solve_more_cycles() override {
    const bool wins = grids_.problem().cost_weights.of_displacement() && grids_.problem().goal->periodic;
    return wins && has_strokes() ? search::solve_more_cycles(grids_) : std::vector<Found>();
  }

  std::vector<Found> hop(const Found& from, int first, int count) override {
    return grids_.in_threads(count, "", [&](int n) {
      Grid grid = grids_.grid(steps_of(from.path));
      Found found;
      found.duration = from.duration;
      grids_.solve(grid, guess::perturbed(grids_.system(), from.path, seed_of_hop(grids_.problem(), first + n)),
                   fine_tolerance, found);
      return found;
    });
  }

  std::vector<Found> refine(const std::vector<const Found*>& coarse) override {
    return grids_.in_threads(static_cast<int>(coarse.size()), "refined", [&](int n) {
      const Found& from = *coarse[static_cast<std::size_t>(n)];
      Found found = from.joint_rate ? refine_with_slower_joints(grids_, from) : grids_.refine(from);
      return without_effort_of(from, std::move(found));
    });
  }

  std::optional<Found> as_begun() const override {
    if (!first_fits()) return std::nullopt;
    Found found = begun_as_asked();
    Grid grid = grids_.grid(grids_.asked().steps);
    if (!grids_.hold(grid, first().path, found)) return std::nullopt;
    found.outcome.termination = Termination::feasible;
    found.outcome.reason =
        "no motion that the search came to is better than the one that it began with, which is shown";
    if (grids_.problem().search.time_limit && grids_.problem().search.starts > 1)
      found.outcome.reason += "; with search.starts = 1 all of the time is spent on the way from there";
    return found;
  }

  Found carry(const Found& from, int steps) override {
    if (!from.path.polynomial.empty()) return without_effort_of(from, grids_.carry_on_composed(from, steps));
    optimizer::Options within = grids_.within(fine_tolerance);
    within.exact_limits = steps == steps_of(from.path);  // else cost and nodes are asked for, not multipliers
    if (!grids_.limited()) {                             // else rounds within limits have their own numbers
      within.max_iterations = carried_iterations;
      within.patience = 1;
    }
    return without_effort_of(from, grids_.carry_on(from, steps, within));
  }
  bool carries_cheaply() const override { return true; }

 private:
  // Iterations and evaluations of what was begun with have been counted.
  static Found without_effort_of(const Found& from, Found found) {
    found.outcome.iterations -= from.outcome.iterations;
    found.outcome.evaluations -= from.outcome.evaluations;
    return found;
  }

  const FirstMotion& first() const { return *grids_.options().first; }

  // With what the motion to begin with comes with.
  Found begun_as_asked() const {
    Found found;
    found.duration = first().duration;
    found.limit_multipliers = first().limit_multipliers;
    found.work_multipliers = first().work_multipliers;
    return found;
  }

  // Whether the motion to begin with is one on these very steps.
  bool first_fits() const {
    return grids_.options().first && steps_of(first().path) == grids_.asked().steps && !grids_.composed();
  }

  // The motion to begin with may be an answer, or near one, on its own steps: then that is found, and not another one from coarser
  // ones.
  Found answer_at_hand() const {
    const int own = steps_of(first().path), steps = std::min(own, grids_.asked().steps);
    if (grids_.composed() || steps < grids_.coarse()) return {};
    Found found = begun_as_asked();
    optimizer::Options within = grids_.within(fine_tolerance);
    within.most_iterations = within.max_iterations = carried_iterations;
    Grid grid = grids_.grid(steps);
    grids_.solve(grid, steps == own ? first().path : guess::refined(grids_.system(), first().path, steps), within,
                 found);
    return found;
  }

  // Of the first guesses the last so many, but never the first one.
  bool begins_with_turns(int start) const {
    const Problem& problem = grids_.problem();
    return start > 0 && start >= problem.search.starts - problem.search.whole_turns && problem.goal &&
           !problem.goal->periodic && !grids_.passive() && !drifts_;
  }

  Found solve_start(int start) const {
    if (!begins_with_turns(start)) return solve_random(start);
    Found found = solve_whole_turns(grids_, seed_of_start(grids_.problem(), start));
    if (found.converged() || grids_.budget().closing()) return found;
    Found other = solve_random(start);
    count_effort(found.outcome, other.outcome);
    return other;
  }

  Found solve_random(int start) const {
    const Found at_hand = begins_as_asked(start) ? answer_at_hand() : Found();
    if (at_hand.converged()) return at_hand;
    Found found = solve_on_coarse_grids(start, at_hand.outcome);
    if (grids_.coarse() <= first_steps) return found;
    begin_on_more_steps(start, found);
    begin_by_effort(start, found);
    begin_in_given_durations(start, found);
    begin_drifting_in_a_given_duration(start, found);
    begin_by_more_worth(start, found);
    if (!whirls(grids_, found)) return found;
    return solve_with_slower_joints(grids_, first_guess(grids_.grid(grids_.coarse()), start, begun_duration(start)),
                                    grids_.coarse(), found);
  }

  // Roughly on few steps, then on the coarse grid.
  Found solve_on_coarse_grids(int start, const Outcome& before) const {
    const int coarse = grids_.coarse();
    const int begun = begins_as_asked(start) ? coarse : std::min(coarse, first_steps);
    Found found = solve_guess(start, begun, begun < coarse ? rough_tolerance : fine_tolerance, before);
    if (coarse <= first_steps) return found;
    if (found.outcome.termination == Termination::infeasible)
      found.limit_multipliers = {};  // those of limits never kept
    if (begun < coarse && !found.path.rotation.empty()) found = grids_.carry_on(found, coarse, fine_tolerance);
    found.coarser = NodePath();  // a rough answer foretells nothing
    return found;
  }

  // What has arrived takes the place of what has not; of what has not arrived either its effort counts.
  static void take_if_arrived(Found again, Found& found) {
    if (again.converged())
      found = std::move(again);
    else
      take_effort(again, found);
  }

  void begin_on_more_steps(int start, Found& found) const {
    // of a scheme above order 2 a step is many of these
    const int finest = grids_.composed() ? finest_first_steps : std::min(grids_.problem().steps, finest_first_steps);
    for (int steps = grids_.coarse(); may_need_more_steps(found); steps = std::min(2 * steps, finest)) {
      take_if_arrived(solve_guess(start, steps, fine_tolerance, found.outcome), found);
      if (steps == finest) break;
    }
  }

  void begin_by_effort(int start, Found& found) const {
    if (!may_begin_by_effort(found)) return;
    take_if_arrived(solve_by_way_of(by_effort(), start, grids_.coarse(), found.outcome), found);
  }

  // A free duration may lead astray.
  void begin_in_given_durations(int start, Found& found) const {
    const maneuver::Duration& asked = grids_.problem().duration;
    if (!asked.free) return;
    for (const double duration : {std::sqrt(asked.min * asked.max), asked.value}) {
      if (found.converged() || grids_.budget().closing()) return;
      take_if_arrived(solve_by_way_of(held_at(duration), start, grids_.coarse(), found.outcome), found);
    }
  }

  // Of a whole that drifts others of the same duration may be cheaper than those that a free one runs away to.
  void begin_drifting_in_a_given_duration(int start, Found& found) const {
    if (!grids_.problem().duration.free || !drifts_ || begins_as_asked(start) || grids_.budget().closing()) return;
    Found again = solve_by_way_of(held_at(begun_duration(start)), start, grids_.coarse(), found.outcome);
    if (again.converged() && !(found.converged() && found.cost <= again.cost))
      found = std::move(again);
    else
      take_effort(again, found);
  }

  // Where a displacement is to be won a search from afar may come down to a stroke that wins next to nothing, and stay there. What is
  // worth ten times as much leads to longer ones.
  void begin_by_more_worth(int start, Found& found) const {
    const bool wins = grids_.problem().cost_weights.of_displacement();
    if (!wins || start % 2 != 0 || begins_as_asked(start) || grids_.budget().closing()) return;
    Found again = solve_by_way_of(worth_more(), start, grids_.coarse(), found.outcome);
    if (again.converged() && !(found.converged() && found.cost <= again.cost))
      found = std::move(again);
    else
      take_effort(again, found);
  }

  // Costs of work have kinks at which a search from afar may stall. Where the goal asks for a motion, the one of least effort, which
  // has none, is a place to begin with.
  bool may_begin_by_effort(const Found& found) const {
    const Problem& problem = grids_.problem();
    const maneuver::CostWeights& weights = problem.cost_weights;
    if (found.converged() || grids_.budget().closing() || !problem.goal) return false;
    if (!(weights.work > 0.0 || weights.power > 0.0 || weights.transport > 0.0)) return false;
    const auto& move = problem.goal->move;
    const bool moves = std::any_of(move.begin(), move.end(), [](const auto& along) { return along.has_value(); });
    return moves || problem.goal->turn || !problem.goal->rotation.empty() || problem.goal->of_joints();
  }

  // The problem without what searches from afar may stall at, and in a given duration.
  Problem by_effort() const {
    Problem eased = grids_.problem();
    eased.cost_weights.work = eased.cost_weights.power = eased.cost_weights.transport = 0.0;
    return eased;
  }
  Problem worth_more() const {
    Problem dearer = grids_.problem();
    dearer.cost_weights.displacement *= more_worth;
    return dearer;
  }
  Problem in_time(double duration) const {
    Problem timed = grids_.problem();
    timed.duration.value = duration;
    return timed;
  }
  Problem held_at(double duration) const {
    Problem held = in_time(duration);
    held.duration.free = false;
    return held;
  }

  // From a first guess of an easier problem, from whose solution the whole is solved.
  Found solve_by_way_of(const Problem& easier, int start, int steps, const Outcome& before) const {
    Found found;
    found.outcome = before;
    found.duration = easier.duration.free ? begun_duration(start) : easier.duration.value;
    Grid grid = grids_.grid(easier, steps);
    grids_.solve(grid, first_guess(grid, start, found.duration), fine_tolerance, found);
    if (!found.converged()) return found;
    const NodePath path = std::move(found.path);
    if (easier.duration.free != grids_.problem().duration.free) found.limit_multipliers = {};  // of fewer rows
    Grid whole = grids_.grid(steps);
    grids_.solve(whole, path, fine_tolerance, found);
    return found;
  }

  // Few steps may have led to turns that more steps do not show, or do not show turns that the motion takes.
  bool may_need_more_steps(const Found& found) const {
    if (found.converged() || found.outcome.termination == Termination::infeasible || grids_.budget().closing())
      return false;
    return grids_.passive() || found.path.rotation.empty() ||
           largest_turn(found.path.rotation).angle > nearly_quarter_turn;
  }

  // From a first guess; effort and history of `before` go on.
  Found solve_guess(int start, int steps, double tolerance, const Outcome& before) const {
    Found found = begins_as_asked(start) ? begun_as_asked() : Found();
    found.outcome = before;
    if (!begins_as_asked(start)) found.duration = begun_duration(start);
    Grid grid = grids_.grid(steps);
    const NodePath guess = first_guess(grid, start, found.duration);
    grids_.solve(grid, guess, tolerance, found);
    const bool led = begins_as_asked(start) && first().limit_multipliers.weight > 0.0;
    if (!led || found.converged() || grids_.budget().closing()) return found;
    Found again;  // multipliers of other limits lead astray
    again.outcome = found.outcome;
    again.duration = first().duration;
    grids_.solve(grid, guess, tolerance, again);
    if (again.converged()) return again;
    take_effort(again, found);
    return found;
  }

  bool begins_as_asked(int start) const { return start == 0 && grids_.options().first.has_value(); }

  // How far a whole that drifts gets is up to the time it takes, so that guesses begin in others, as evenly over the logarithm of what
  // is free as their number allows. What begins at rest moves alike in any time.
  double begun_duration(int start) const {
    const maneuver::Duration& asked = grids_.problem().duration;
    if (!asked.free || !drifts_) return asked.value;
    return asked.min * std::pow(asked.max / asked.min, radical_inverse(start + 1));
  }

  NodePath first_guess(const Grid& grid, int start, double duration) const {
    if (begins_as_asked(start)) return guess::refined(grids_.system(), first().path, grid.maneuver.steps);
    NodePath guess = guess::random_guess(grids_.system(), grid.maneuver, seed_of_start(grids_.problem(), start));
    if (drifts_) return carried_by_momentum(grids_.system(), in_time(duration), std::move(guess), start);
    return grids_.passive() ? with_passive_joints(grid.maneuver, guess, start) : guess;
  }

  // In what passive joints do beside the others. Around gaits by turns with calmer strokes, with whole ones, and as they were
  // guessed: each leads to minima that the others do not.
  NodePath with_passive_joints(const maneuver::Maneuver& maneuver, const NodePath& guess, int start) const {
    const auto& coordinates = grids_.reached().coordinates;
    if (!maneuver.periodic)
      return guess::with_passive_joints(grids_.system(), maneuver, coordinates, guess).value_or(guess);
    const double share = strokes_of_gaits[static_cast<std::size_t>(start) % strokes_of_gaits.size()];
    if (!maneuver.free_shape || share == 0.0) return guess;
    return guess::cycle_of_passive_joints(grids_.system(), maneuver, coordinates, guess, share).value_or(guess);
  }

  Grids grids_;
  bool drifts_;  // strokes and whole turns begin at rest
};

}  // namespace

bool newton_takes(const System& system, const Problem& problem) {
  if (problem.control != maneuver::ControlKind::steps) return false;
  const bool more = problem.limits.any() || problem.cost_weights.any() || problem.duration.free ||
                    !problem.waypoints.empty() || (problem.goal && problem.goal->periodic);
  const bool single = integrator::single_step(problem.scheme);
  if (!single && more) return false;
  const bool periodic = problem.goal && problem.goal->periodic;
  return (single && !periodic) || !maneuver::has_momentum(system, problem.start);
}

std::unique_ptr<Method> newton_method(const System& system, const Problem& problem, const SolveOptions& options,
                                      const Budget& budget) {
  return std::make_unique<NewtonMethod>(system, problem, options, budget);
}

}  // namespace lamprey::search
