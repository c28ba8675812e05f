#include "study/solve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

#include "maneuver/goal_rank.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/mirror.hpp"
#include "maneuver/motion.hpp"
#include "maneuver/shooting.hpp"
#include "maneuver/transcription.hpp"
#include "optimizer/feasibility.hpp"
#include "optimizer/ipopt.hpp"
#include "study/outcome_numbers.hpp"
#include "study/workers.hpp"

namespace lamprey::study {

namespace {

using Clock = std::chrono::steady_clock;
using Eigen::VectorXd;
using maneuver::GoalRow;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Transcription;
using model::System;
using optimizer::Outcome;
using optimizer::Termination;

constexpr int coarse_steps = 100;  // enough to tell minima apart, few enough to be quick
constexpr int rank_steps = 20;     // rank does not depend on the resolution
constexpr int start_iterations = 400;
constexpr int quick_iterations = 40;    // of a refinement that goes well
constexpr int refine_iterations = 200;  // of one that does not
constexpr std::size_t batch = 2;  // refined side by side; fixed, so that the answer does not depend on the machine
constexpr std::size_t refined_candidates =
    6;                                 // coarse grids lie about cost: at most so many are compared at full resolution
constexpr int retries = 4;             // further guesses where a single start fails
constexpr double same_minimum = 1e-6;  // relative difference of cost

class Search {
 public:
  Search(const System& system, const Problem& problem, const SolveOptions& options)
      : system_(system),
        problem_(problem),
        options_(options),
        coarse_(maneuver::make_maneuver(system, problem, std::min(problem.steps, coarse_steps))),
        full_(maneuver::make_maneuver(system, problem, problem.steps)) {
    const Maneuver probe = maneuver::make_maneuver(system, problem, std::min(problem.steps, rank_steps));
    rows_ = maneuver::independent_goal_rows(system, probe, maneuver::random_guess(system, probe, seed_of(0)));
  }

  std::vector<Solution> run() {
    search_starts();
    count_minima();
    refine_candidates();
    for (Solution& solution : solutions_) {
      solution.search = record_;
      solution.solver.iterations = iterations_;
      solution.solver.evaluations = evaluations_;
      solution.solver.wall_seconds = seconds();
    }
    return solutions_;
  }

 private:
  std::uint64_t seed_of(int start) const {
    return problem_.search.seed * 0x100000001B3ULL + static_cast<std::uint64_t>(start);
  }

  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

  void say(const std::string& line) const {
    if (options_.progress) options_.progress(line);
  }

  bool stopped() const {
    return (options_.interrupted && options_.interrupted()) ||
           (problem_.search.time_limit && seconds() > *problem_.search.time_limit);
  }

  optimizer::Options optimizer_options(int max_iterations) const {
    optimizer::Options options;
    options.tolerance = std::min(1e-9, 0.1 * problem_.search.tolerance);
    options.max_iterations = max_iterations;
    if (problem_.search.time_limit) options.time_limit = std::max(0.0, *problem_.search.time_limit - seconds());
    options.interrupted = options_.interrupted;
    return options;
  }

  Outcome solve_start(int start) const {
    if (stopped()) return Outcome();
    Transcription program(system_, coarse_, rows_);
    return optimizer::solve_with_ipopt(program, optimizer_options(start_iterations),
                                       program.pack(maneuver::random_guess(system_, coarse_, seed_of(start))));
  }

  // Tasks 0 … count − 1 in worker processes; a task whose process died counts as stalled.
  std::vector<Outcome> in_workers(int count, const char* what, const std::function<Outcome(int)>& task) {
    const auto told = [&](int done) {
      say(std::string(what) + " " + std::to_string(done) + " of " + std::to_string(count));
    };
    const auto all = run_in_workers(
        count, options_.workers, [&](int t) { return numbers_of(task(t)); }, told);
    std::vector<Outcome> outcomes;
    for (const auto& numbers : all) outcomes.push_back(numbers ? outcome_of(*numbers) : Outcome());
    for (const Outcome& outcome : outcomes) count_effort(outcome);
    return outcomes;
  }

  void count_effort(const Outcome& outcome) {
    iterations_ += outcome.iterations;
    evaluations_ += outcome.evaluations;
  }

  // Every start on the coarse grid; a single start that fails is followed by others.
  void search_starts() {
    starts_ = in_workers(problem_.search.starts, "start", [this](int s) { return solve_start(s); });
    for (int more = 0; more < retries && problem_.search.starts == 1 && !converged(starts_.back()) && !stopped();
         ++more) {
      starts_.push_back(solve_start(static_cast<int>(starts_.size())));
      count_effort(starts_.back());
    }
  }

  static bool converged(const Outcome& outcome) { return outcome.termination == Termination::converged; }

  void count_minima() {
    std::vector<std::size_t> order(starts_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
      return std::pair(!converged(starts_[a]), starts_[a].objective) <
             std::pair(!converged(starts_[b]), starts_[b].objective);
    });
    record_.starts = static_cast<int>(starts_.size());
    for (std::size_t s : order) {
      if (!converged(starts_[s])) continue;
      const double cost = starts_[s].objective * Transcription::control_unit;
      ++record_.solved;
      if (!record_.minima.empty() && cost - record_.minima.back().cost < same_minimum * cost) {
        ++record_.minima.back().count;
      } else {
        record_.minima.push_back({cost, 1});
        candidates_.push_back(s);
      }
    }
    if (candidates_.empty()) candidates_.push_back(order.front());
    if (candidates_.size() > refined_candidates) candidates_.resize(refined_candidates);
  }

  Outcome refine(const Outcome& start) const {
    Transcription coarse(system_, coarse_, rows_);
    Transcription full(system_, full_, rows_);
    const NodePath path =
        start.point.size() > 0 ? coarse.unpack(start.point) : maneuver::random_guess(system_, coarse_, seed_of(0));
    const VectorXd start_point = full.pack(maneuver::refined(system_, path, full_.steps));
    optimizer::Options options = optimizer_options(quick_iterations);
    options.near_solution = true;
    Outcome outcome = optimizer::solve_with_ipopt(full, options, start_point);
    if (!converged(outcome) && !stopped())
      outcome = optimizer::solve_with_ipopt(full, optimizer_options(refine_iterations), start_point);
    outcome.infeasibility = optimizer::polish_feasibility(full, outcome.point);
    outcome.objective = full.objective(outcome.point);
    return outcome;
  }

  // Candidates at full resolution, where costs can be compared, two at a time by rising coarse cost, until an accepted one
  // costs less than those still waiting.
  void refine_candidates() {
    double accepted_cost = std::numeric_limits<double>::infinity();
    for (std::size_t first = 0; first < candidates_.size(); first += batch) {
      if (first > 0 && (stopped() || accepted_cost < coarse_cost(first))) break;
      const int count = static_cast<int>(std::min(batch, candidates_.size() - first));
      const std::vector<Outcome> outcomes = in_workers(count, "refined", [this, first](int c) {
        return refine(starts_[candidates_[first + static_cast<std::size_t>(c)]]);
      });
      for (const Outcome& outcome : outcomes) {
        if (outcome.point.size() == 0) continue;
        solutions_.push_back(describe(outcome));
        if (options_.accept && options_.accept(solutions_.back()))
          accepted_cost = std::min(accepted_cost, solutions_.back().cost);
      }
    }
    if (!solutions_.empty()) return;  // otherwise every worker died: once more, in this process
    solutions_.push_back(describe(refine(Outcome())));
    if (options_.accept) options_.accept(solutions_.back());
  }

  double coarse_cost(std::size_t candidate) const {
    return starts_[candidates_[candidate]].objective * Transcription::control_unit;
  }

  static bool met(const Outcome& outcome) { return outcome.infeasibility < 1e-8; }

  // The motion of an outcome, by single shooting from there where the problem asks for it.
  Solution describe(Outcome outcome) {
    const bool shooting = problem_.search.method == maneuver::SearchMethod::shooting;
    NodePath path = Transcription(system_, full_, rows_).unpack(outcome.point);
    if (shooting) {
      maneuver::Shooting program(system_, full_, rows_);
      outcome = optimizer::solve_with_ipopt(program, optimizer_options(refine_iterations), program.pack(path));
      path = program.unpack(outcome.point);
      count_effort(outcome);
    }
    path = turned_as_asked(path);
    Solution solution;
    describe_motion(system_, full_.lagrangian, full_.time_step(), path, solution);
    solution.cost = maneuver::cost_of(full_.node_weight, solution.control);
    solution.solver.name = shooting ? "ipopt, single shooting" : "ipopt";
    for (const optimizer::Iteration& step : outcome.history)
      solution.solver.history.push_back({step.iteration, step.objective * Transcription::control_unit, step.goal_error,
                                         step.dual_infeasibility, step.step});
    solution.status = status_of(outcome);
    solution.message = outcome.reason;
    return solution;
  }

  // Of two mirror images of equal cost the one that turns as the goal's rotation vector does.
  NodePath turned_as_asked(const NodePath& path) const {
    const auto& turn = problem_.goal->turn;
    if (!turn || turn->norm() == 0.0 || !maneuver::turns_against(*turn, path)) return path;
    const std::optional<int> axis = maneuver::mirror_axis(system_, full_);
    return axis ? maneuver::mirrored(system_, path, *axis) : path;
  }

  static maneuver::Status status_of(const Outcome& outcome) {
    using maneuver::Status;
    switch (outcome.termination) {
      case Termination::converged:
        return Status::optimal;
      case Termination::feasible:
        return Status::feasible;
      case Termination::infeasible:
        return Status::infeasible;
      case Termination::time_limit:
        return Status::time_limit;
      case Termination::interrupted:
        return Status::interrupted;
      case Termination::stalled:
        break;
    }
    return met(outcome) ? Status::feasible : Status::stalled;
  }

  const System& system_;
  const Problem& problem_;
  const SolveOptions& options_;
  Maneuver coarse_, full_;
  std::vector<GoalRow> rows_;
  std::vector<Outcome> starts_;
  std::vector<std::size_t> candidates_;  // starts to refine, by rising cost
  maneuver::SearchRecord record_;
  std::vector<Solution> solutions_;
  int iterations_ = 0;
  int evaluations_ = 0;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

std::vector<Solution> solve(const System& system, const Problem& problem, const SolveOptions& options) {
  return Search(system, problem, options).run();
}

}  // namespace lamprey::study
