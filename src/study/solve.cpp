#include "study/solve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "maneuver/goal_rank.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/motion.hpp"
#include "maneuver/shooting.hpp"
#include "maneuver/transcription.hpp"
#include "optimizer/feasibility.hpp"
#include "optimizer/ipopt.hpp"
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

constexpr int coarse_steps = 100;        // enough to tell minima apart, few enough to be quick
constexpr int rank_steps = 20;           // rank does not depend on the resolution
constexpr int refined_candidates = 4;    // coarse grids lie about cost: the best few are compared at full resolution
constexpr int retries = 4;               // further guesses where a single start fails
constexpr double same_minimum = 1e-6;    // relative difference of cost

// What a worker sends back of one start.
struct StartResult {
  bool converged = false;
  double cost = 0.0;
  int iterations = 0;
  int evaluations = 0;
  VectorXd point;
};

std::vector<double> encode(const StartResult& result) {
  std::vector<double> numbers = {result.converged ? 1.0 : 0.0, result.cost, static_cast<double>(result.iterations),
                                 static_cast<double>(result.evaluations)};
  numbers.insert(numbers.end(), result.point.begin(), result.point.end());
  return numbers;
}

StartResult decode(const std::vector<double>& numbers) {
  StartResult result;
  result.converged = numbers[0] != 0.0;
  result.cost = numbers[1];
  result.iterations = static_cast<int>(numbers[2]);
  result.evaluations = static_cast<int>(numbers[3]);
  result.point = Eigen::Map<const VectorXd>(numbers.data() + 4, static_cast<Eigen::Index>(numbers.size()) - 4);
  return result;
}

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

  Solution run() {
    search_starts();
    count_minima();
    refine_candidates();
    if (problem_.search.method == maneuver::SearchMethod::shooting) shoot();
    return finish();
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

  StartResult solve_start(int start) const {
    StartResult result;
    if (stopped()) return result;
    Transcription program(system_, coarse_, rows_);
    const Outcome outcome = optimizer::solve_with_ipopt(
        program, optimizer_options(400), program.pack(maneuver::random_guess(system_, coarse_, seed_of(start))));
    result.converged = outcome.termination == Termination::converged;
    result.cost = outcome.objective * Transcription::control_unit;
    result.iterations = outcome.iterations;
    result.evaluations = outcome.evaluations;
    result.point = outcome.point;
    return result;
  }

  // Every start on the coarse grid; a single start that fails is followed by others.
  void search_starts() {
    const int starts = problem_.search.starts;
    const auto told = [&](int done) { say("start " + std::to_string(done) + " of " + std::to_string(starts)); };
    const auto encoded = run_in_workers(starts, options_.workers, [this](int s) { return encode(solve_start(s)); }, told);
    for (const auto& numbers : encoded) results_.push_back(numbers ? decode(*numbers) : StartResult());
    for (int more = 0; more < retries && starts == 1 && !results_.back().converged && !stopped(); ++more)
      results_.push_back(solve_start(static_cast<int>(results_.size())));
    for (const StartResult& result : results_) {
      solver_.iterations += result.iterations;
      solver_.evaluations += result.evaluations;
    }
  }

  void count_minima() {
    order_.resize(results_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(), [this](int a, int b) {
      const StartResult& first = results_[static_cast<std::size_t>(a)];
      const StartResult& second = results_[static_cast<std::size_t>(b)];
      return std::pair(!first.converged, first.cost) < std::pair(!second.converged, second.cost);
    });
    record_.starts = static_cast<int>(results_.size());
    for (int s : order_) {
      const StartResult& result = results_[static_cast<std::size_t>(s)];
      if (!result.converged) continue;
      ++record_.solved;
      if (!record_.minima.empty() && result.cost - record_.minima.back().cost < same_minimum * result.cost) {
        ++record_.minima.back().count;
      } else {
        record_.minima.push_back({result.cost, 1});
        candidates_.push_back(s);
      }
    }
    if (candidates_.empty()) candidates_.push_back(order_.front());
  }

  // The best few at full resolution; the cheapest there becomes the answer.
  void refine_candidates() {
    Transcription coarse(system_, coarse_, rows_);
    Transcription full(system_, full_, rows_);
    const int count = std::min<int>(refined_candidates, static_cast<int>(candidates_.size()));
    for (int c = 0; c < count; ++c) {
      const StartResult& start = results_[static_cast<std::size_t>(candidates_[static_cast<std::size_t>(c)])];
      if (c > 0 && stopped()) break;
      const NodePath path = start.point.size() > 0 ? coarse.unpack(start.point)
                                                   : maneuver::random_guess(system_, coarse_, seed_of(0));
      say("refining cost " + std::to_string(start.cost) + " to " + std::to_string(problem_.steps) + " steps");
      Outcome outcome = optimizer::solve_with_ipopt(full, optimizer_options(200),
                                                    full.pack(maneuver::refined(system_, path, full_.steps)));
      const double residual = optimizer::polish_feasibility(full, outcome.point);
      solver_.iterations += outcome.iterations;
      solver_.evaluations += outcome.evaluations;
      outcome.infeasibility = residual;
      outcome.objective = full.objective(outcome.point);
      if (c == 0 || better(outcome, best_)) {
        best_ = outcome;
        answer_ = full.unpack(outcome.point);
        goal_error_ = full.goal_error(outcome.point);
      }
    }
  }

  static bool met(const Outcome& outcome) { return outcome.infeasibility < 1e-8; }

  static bool better(const Outcome& a, const Outcome& b) {
    return std::pair(!met(a), a.objective) < std::pair(!met(b), b.objective);
  }

  // The paper's single shooting, from the answer of the simultaneous method.
  void shoot() {
    maneuver::Shooting program(system_, full_, rows_);
    const Outcome outcome = optimizer::solve_with_ipopt(program, optimizer_options(200), program.pack(answer_));
    solver_.iterations += outcome.iterations;
    solver_.evaluations += outcome.evaluations;
    best_ = outcome;
    answer_ = program.unpack(outcome.point);
    goal_error_ = program.goal_error(outcome.point);
  }

  Solution finish() {
    Solution solution;
    describe_motion(system_, full_.lagrangian, full_.time_step(), answer_, solution);
    solution.cost = maneuver::cost_of(full_.node_weight, solution.control);
    solution.search = record_;
    solution.solver = solver_;
    solution.solver.name = problem_.search.method == maneuver::SearchMethod::shooting ? "ipopt, single shooting" : "ipopt";
    solution.solver.wall_seconds = seconds();
    for (const optimizer::Iteration& step : best_.history)
      solution.solver.history.push_back({step.iteration, step.objective * Transcription::control_unit, step.goal_error,
                                         step.dual_infeasibility, step.step});
    set_status(solution);
    return solution;
  }

  void set_status(Solution& solution) const {
    using maneuver::Status;
    switch (best_.termination) {
      case Termination::converged: solution.status = Status::optimal; break;
      case Termination::feasible: solution.status = Status::feasible; break;
      case Termination::infeasible: solution.status = Status::infeasible; break;
      case Termination::stalled: solution.status = met(best_) ? Status::feasible : Status::stalled; break;
      case Termination::time_limit: solution.status = Status::time_limit; break;
      case Termination::interrupted: solution.status = Status::interrupted; break;
    }
    solution.message = best_.reason;
  }

  const System& system_;
  const Problem& problem_;
  const SolveOptions& options_;
  Maneuver coarse_, full_;
  std::vector<GoalRow> rows_;
  std::vector<StartResult> results_;
  std::vector<int> order_, candidates_;
  maneuver::SearchRecord record_;
  maneuver::SolverRecord solver_;
  Outcome best_;
  NodePath answer_;
  double goal_error_ = 0.0;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

Solution solve(const System& system, const Problem& problem, const SolveOptions& options) {
  return Search(system, problem, options).run();
}

}  // namespace lamprey::study
