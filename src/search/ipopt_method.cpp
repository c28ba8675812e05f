#include <algorithm>

#include "guess/guess.hpp"
#include "optimizer/feasibility.hpp"
#include "optimizer/ipopt.hpp"
#include "search/drifting.hpp"
#include "search/grids.hpp"
#include "search/outcome_numbers.hpp"
#include "search/workers.hpp"
#include "transcription/goal_rank.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::search {

namespace {

using Eigen::VectorXd;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;
using model::System;
using optimizer::Outcome;
using transcription::GoalRow;
using transcription::Transcription;

constexpr int rank_steps = 20;   // rank does not depend on the resolution
constexpr int rank_guesses = 4;  // first guesses until one is a motion
constexpr int start_iterations = 400;
constexpr int quick_iterations = 40;    // of a refinement that goes well
constexpr int refine_iterations = 200;  // of one that does not

// MUMPS keeps global data: tasks run at once in processes of their own.
class IpoptMethod : public Method {
 public:
  IpoptMethod(const System& system, const Problem& problem, const SolveOptions& options, const Budget& budget)
      : system_(system),
        problem_(problem),
        by_steps_(with_free_nodes(problem)),
        options_(options),
        quiet_(without_progress(options)),
        budget_(budget),
        newton_budget_(by_steps_, quiet_, budget),
        coarse_(maneuver::make_maneuver(system, problem, std::min(problem.steps, coarse_steps))),
        full_(maneuver::make_maneuver(system, problem, problem.steps)),
        limits_(maneuver::limit_rows(system, problem)) {
    const Maneuver probe = maneuver::make_maneuver(system, problem, std::min(problem.steps, rank_steps));
    rows_ = transcription::independent_goal_rows(system, probe, some_motion(probe));
    if (problem.control == maneuver::ControlKind::spline && newton_takes(system, by_steps_))
      newton_ = newton_method(system, by_steps_, quiet_, newton_budget_);
  }

  std::string name() const override { return "ipopt"; }
  std::string out_of_reach() const override {
    return newton_takes(system_, problem_) ? Reached(system_, problem_).out_of_reach : "";
  }

  std::vector<Found> solve_starts(int first, int count) override {
    return in_workers(count, "first guess", coarse_, [&](int n) { return solve_start(first + n); });
  }

  std::vector<Found> hop(const Found& from, int first, int count) override {
    return in_workers(count, "", coarse_, [&](int n) {
      Transcription program(system_, coarse_, rows_, limits_);
      const NodePath path = guess::perturbed(system_, from.path, seed_of_hop(problem_, first + n));
      return optimizer::solve_with_ipopt(program, optimizer_options(start_iterations),
                                         program.pack(path, from.duration));
    });
  }

  std::vector<Found> refine(const std::vector<const Found*>& coarse) override {
    return in_workers(static_cast<int>(coarse.size()), "refined", full_,
                      [&](int n) { return refine(*coarse[static_cast<std::size_t>(n)], full_); });
  }

  Found carry(const Found& from, int steps) override {
    const Maneuver grid = maneuver::make_maneuver(system_, problem_, steps);
    return in_workers(1, "carried", grid, [&](int) { return refine(from, grid); }).front();
  }
  bool carries_cheaply() const override { return false; }

 private:
  static Problem with_free_nodes(Problem problem) {
    problem.control = maneuver::ControlKind::steps;
    problem.points = 0;
    problem.steps = coarse_steps;  // fewer show turns that no motion takes
    return problem;
  }

  static SolveOptions without_progress(SolveOptions options) {
    options.progress = nullptr;
    return options;
  }

  // The motion of a first guess's shapes, if it is one.
  std::optional<NodePath> moved_by_shapes(const Maneuver& grid, int start) const {
    if (!newton_takes(system_, problem_)) return std::nullopt;
    const Reached reached(system_, problem_);
    shape::ShapeProgram motion(system_, grid, reached.coordinates, reached.rows, {}, shape::Steps::rough);
    if (!motion.go_to(guess(grid, start))) return std::nullopt;
    return motion.path();
  }

  NodePath guess(const Maneuver& grid, int start) const {
    if (start == 0 && options_.first) return guess::refined(system_, options_.first->path, grid.steps);
    return guess::random_guess(system_, grid, seed_of_start(problem_, start));
  }

  // s, of a first guess's free duration; 0: the problem's.
  double duration_of(int start) const { return start == 0 && options_.first ? options_.first->duration : 0.0; }

  // Where rank is read: on no motion errors may grow from step to step.
  NodePath some_motion(const Maneuver& grid) const {
    for (int start = options_.first ? 1 : 0; start < rank_guesses; ++start)
      if (const auto motion = moved_by_shapes(grid, start)) return *motion;
    return guess(grid, 0);
  }

  optimizer::Options optimizer_options(int max_iterations) const {
    return budget_.optimizer_options(max_iterations, std::min(1e-9, 0.1 * problem_.search.tolerance));
  }

  // A task whose process died counts as stalled.
  std::vector<Found> in_workers(int count, const char* what, const Maneuver& maneuver,
                                const std::function<Outcome(int)>& task) const {
    const auto told = [&](int done, const std::optional<std::vector<double>>& numbers) {
      if (numbers && outcome_of(*numbers).termination == optimizer::Termination::converged) budget_.arrived();
      if (options_.progress && *what)
        options_.progress(std::string(what) + " " + std::to_string(done) + " of " + std::to_string(count));
    };
    const auto all = run_in_workers(
        count, options_.workers, [&](int t) { return numbers_of(task(t)); }, told, [&] { return budget_.closing(); });
    std::vector<Found> found;
    Transcription program(system_, maneuver, rows_, limits_);
    for (const auto& numbers : all) {
      if (!numbers && !found.empty() && budget_.closing()) continue;  // not begun
      found.emplace_back();
      if (!numbers) continue;
      Found& last = found.back();
      last.outcome = outcome_of(*numbers);
      last.cost = last.outcome.objective * program.cost_unit();
      for (optimizer::Iteration& step : last.outcome.history) step.objective *= program.cost_unit();
      if (last.outcome.point.size() == 0) continue;
      last.cost = program.cost(last.outcome.point);
      last.path = program.unpack(last.outcome.point);
      last.duration = program.duration(last.outcome.point);
      last.cost_parts = program.cost_parts(last.outcome.point);
      if (last.outcome.multipliers.size() != program.constraint_count()) continue;
      last.limit_multipliers = program.limit_multipliers(last.outcome.point, last.outcome.multipliers);
      last.work_multipliers = program.work_multipliers(last.outcome.point, last.outcome.multipliers);
    }
    return found;
  }

  Outcome solve_start(int start) const {
    if (budget_.stopped()) return Outcome();
    Transcription program(system_, coarse_, rows_, limits_);
    // a motion that obeys the mechanics, where a displacement is to be won: others are let go on the way to one, and end at rest
    std::optional<NodePath> moved;
    if (problem_.cost_weights.of_displacement()) moved = moved_by_shapes(coarse_, start);
    NodePath guess = moved ? *moved : this->guess(coarse_, start);
    Outcome before;
    if (newton_) {  // moments on splines from moments free at each node: found in less time than one iteration here takes
      const Found free = newton_->solve_starts(start, 1).front();
      if (free.converged())
        return after(free.outcome,
                     optimizer::solve_with_ipopt(program, optimizer_options(start_iterations),
                                                 program.pack(guess::refined(system_, free.path, coarse_.steps))));
      before = free.outcome;
    }
    if (!(start == 0 && options_.first)) guess = carried_by_momentum(system_, problem_, std::move(guess), start);
    if (!problem_.cost_weights.any())
      return after(before, optimizer::solve_with_ipopt(program, optimizer_options(start_iterations),
                                                       program.pack(guess, duration_of(start))));
    // rates of a first guess say little: costs that depend on them wait for the cheapest motion by effort
    const double effort = problem_.cost_weights.of_displacement() ? problem_.effort : 1.0;
    Maneuver by_effort = coarse_;
    by_effort.cost_weights = {.displacement = problem_.cost_weights.displacement};
    by_effort.node_weight = maneuver::node_weights(problem_.cost_rule(), effort, coarse_.time_step(), coarse_.steps);
    Transcription first(system_, by_effort, rows_, limits_);
    const Outcome outcome = after(before, optimizer::solve_with_ipopt(first, optimizer_options(start_iterations),
                                                                      first.pack(guess, duration_of(start))));
    return after(outcome,
                 optimizer::solve_with_ipopt(program, optimizer_options(start_iterations),
                                             program.pack(first.unpack(outcome.point), first.duration(outcome.point))));
  }

  // An outcome with what was spent on the way to it.
  static Outcome after(const Outcome& before, Outcome outcome) {
    count_effort(before, outcome);
    return outcome;
  }

  // Where time is over with nothing found: one step on so many nodes may take longer than all of the search had.
  Outcome untouched(Transcription& full, const VectorXd& point, const Outcome& before) const {
    Outcome outcome;
    const bool interrupted = budget_.interrupted();
    outcome.termination = interrupted ? optimizer::Termination::interrupted : optimizer::Termination::time_limit;
    outcome.reason = interrupted ? "interrupted" : "the time limit was reached";
    outcome.point = point;
    outcome.multipliers.setZero(full.constraint_count());
    outcome.objective = full.objective(point);
    outcome.infeasibility = optimizer::largest_violation(full, point);
    return after(before, std::move(outcome));
  }

  Outcome refine(const Found& start, const Maneuver& grid) const {
    Transcription full(system_, grid, rows_, limits_);
    const NodePath path =
        start.path.rotation.empty() ? guess::random_guess(system_, coarse_, seed_of_start(problem_, 0)) : start.path;
    const VectorXd start_point = full.pack(guess::refined(system_, path, grid.steps), start.duration);
    if (budget_.stopped() && !start.converged()) return untouched(full, start_point, start.outcome);
    optimizer::Options options = optimizer_options(quick_iterations);
    options.near_solution = true;
    Outcome outcome = optimizer::solve_with_ipopt(full, options, start_point);
    if (outcome.termination != optimizer::Termination::converged && !budget_.stopped())
      outcome = after(outcome, optimizer::solve_with_ipopt(full, optimizer_options(refine_iterations), start_point));
    outcome.infeasibility = optimizer::polish_feasibility(full, outcome.point);
    outcome.objective = full.objective(outcome.point);
    return outcome;
  }

  const System& system_;
  const Problem& problem_;
  const Problem by_steps_;  // with moments free at each node
  const SolveOptions& options_;
  const SolveOptions quiet_;
  const Budget& budget_;
  const Budget newton_budget_;  // who arrives by it has not arrived yet
  Maneuver coarse_, full_;
  std::vector<GoalRow> rows_;
  std::vector<maneuver::LimitRow> limits_;
  std::unique_ptr<Method> newton_;  // of by_steps_, where moments are on splines and it takes that
};

}  // namespace

bool ipopt_takes(const System& system, const Problem& problem) {
  const auto& joints = system.joints();
  const bool universal = std::any_of(joints.begin(), joints.end(),
                                     [](const auto& joint) { return joint.kind == model::JointKind::universal; });
  const bool scheme = problem.scheme == maneuver::Scheme::trapezoid || problem.scheme == maneuver::Scheme::paper;
  const bool still = problem.goal && problem.goal->joints_rest && maneuver::has_momentum(system, problem.start);
  return scheme && !still && !system.coupled() && !(universal && problem.cost_weights.any());
}

std::unique_ptr<Method> ipopt_method(const System& system, const Problem& problem, const SolveOptions& options,
                                     const Budget& budget) {
  return std::make_unique<IpoptMethod>(system, problem, options, budget);
}

}  // namespace lamprey::search
