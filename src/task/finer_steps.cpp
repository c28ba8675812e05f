#include "task/finer_steps.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "search/minima.hpp"
#include "study/advice.hpp"
#include "study/answer.hpp"
#include "study/enough_memory.hpp"
#include "study/faults.hpp"

namespace lamprey::task {

namespace {

constexpr int most_rounds = 4;

// An answer and those kept beside it whose steps do not resolve them, from them on solved again on as many as the most demanding
// replay proposes, until they do or time is over: all of them, so that their costs can be compared where they arrive.
class Resolving {
 public:
  Resolving(const file::ProblemFile& file, const search::SolveOptions& options, const std::string& command)
      : asked_(file), finer_(file), options_(options), command_(command) {
    maneuver::Search& search = finer_.problem.search;
    search.starts = search.keep = 1;
    search.hops = search.whole_turns = 0;
    options_.first_alone = true;
  }

  result::Results from(result::Results results) {
    std::vector<Kept> kept;
    for (result::Results& other : results.others) kept.push_back({std::move(other), asked_.problem.steps});
    results.others.clear();
    kept.insert(kept.begin(), {std::move(results), asked_.problem.steps});
    for (int round = 0;; ++round) {
      int steps = 0;
      for (const Kept& each : kept) steps = std::max(steps, steps_for(each));
      const auto lags = [&](const Kept& each) { return each.unfinished.empty() && each.steps < steps; };
      if (std::none_of(kept.begin(), kept.end(), lags)) break;
      if (round == most_rounds || !has_time()) {
        for (Kept& each : kept)
          if (lags(each)) leave_untried(each, steps);
        break;
      }
      if (options_.progress) options_.progress(fmt::format("not all of it is resolved: again on {} steps", steps));
      for (Kept& each : kept)
        if (lags(each) && has_time()) solve_again(each, steps);
    }
    return merged(std::move(kept));
  }

 private:
  struct Kept {
    result::Results results;
    int steps;
    std::string unfinished = {};  // why it is on no more steps than these, in words; empty: these do, or more are tried
  };

  maneuver::Problem problem_of(const Kept& kept) const {
    maneuver::Problem problem = asked_.problem;
    problem.steps = kept.steps;
    return problem;
  }

  int steps_for(const Kept& kept) const {
    const result::Results& is = kept.results;
    if (!kept.unfinished.empty()) return 0;
    return study::steps_to_resolve(problem_of(kept), *is.certificate, is.solution).value_or(kept.steps);
  }

  void leave_untried(Kept& kept, int steps) {
    leave(kept, fmt::format(" {} steps were not tried: {}.", steps,
                            interrupted() ? "it was interrupted"
                            : has_time()  ? "--resolve goes on no further"
                                          : "the time was over (search.time_limit)"));
  }

  // An answer that might have been another one, had nobody interrupted, has that status.
  void leave(Kept& kept, std::string words) const {
    kept.results.solution.message += words;
    kept.unfinished = std::move(words);
    if (interrupted()) kept.results.solution.status = maneuver::Status::interrupted;
  }

  void solve_again(Kept& kept, int steps) {
    finer_.problem.steps = steps;
    const std::string too_much = study::short_of_memory(system_of(finer_), finer_.problem, bytes_);
    if (!too_much.empty()) {
      leave(kept, fmt::format(" {} steps were not tried: {}.", steps, too_much));
      return;
    }
    result::Results again =
        solve_task(finer_, options_, command_, EarlierMotion{kept.results, "the answer on fewer steps"});
    if (again.solution.status != maneuver::Status::optimal) {
      leave(kept, unfinished(again, steps));
      return;
    }
    again.solution.message +=
        fmt::format(" It was found on {} steps, and solved again on these.", asked_.problem.steps);
    take_record(kept.results.solution, again.solution);
    kept.results = std::move(again);
    kept.steps = steps;
  }

  std::string unfinished(const result::Results& again, int steps) const {
    switch (again.solution.status) {
      case maneuver::Status::interrupted:
        return fmt::format(" It was interrupted before the search on {} steps arrived.", steps);
      case maneuver::Status::time_limit:
        return fmt::format(
            " The time was over before the search on {} steps arrived: give it more than {:.0f} s (search.time_limit).",
            steps, std::ceil(*asked_.problem.search.time_limit));
      default: {
        const std::string words = fmt::format(" From it the search on {} steps did not arrive", steps);
        const std::string tolerance = study::words_on_tolerance(asked_.problem, *again.certificate);
        if (again.solution.status != maneuver::Status::feasible) return words + ".";
        return fmt::format("{}: it meets the goal at a cost of {:.6g}, but {}{}.", words, again.solution.cost,
                           study::unsettled(asked_.problem, *again.certificate),
                           tolerance.empty() ? "" : " (" + tolerance + ")");
      }
    }
  }

  // Proved ones first, of these what their steps resolve, by rising cost. What were two minima on fewer steps may be one.
  result::Results merged(std::vector<Kept> kept) const {
    const auto order = [&](const Kept& each) {
      const result::Results& is = each.results;
      return std::tuple(is.certificate->verdict != certificate::Verdict::proved,
                        !study::unresolved(problem_of(each), is.solution, *is.certificate).empty(), is.solution.cost);
    };
    std::stable_sort(kept.begin(), kept.end(), [&](const Kept& a, const Kept& b) { return order(a) < order(b); });
    const model::System system = system_of(asked_);
    const auto minimum = [&](const Kept& each) {
      const maneuver::Solution& is = each.results.solution;
      return search::minimum_of(system, asked_.problem, is.cost, is.rotation);
    };
    const auto same = [&](const Kept& a, const Kept& b) {
      return a.steps == b.steps && same_minimum(minimum(a), minimum(b));
    };
    kept.erase(std::unique(kept.begin(), kept.end(), same), kept.end());
    for (; std::ssize(kept) > asked_.problem.search.keep; kept.pop_back())
      kept.front().results.solution.message += words_of(kept.back(), kept.front());
    for (Kept& each : kept) each.results.solution.solver.total_wall_seconds = seconds();  // searches in vain included
    result::Results results = std::move(kept.front().results);
    for (auto other = kept.begin() + 1; other != kept.end(); ++other)
      results.others.push_back(std::move(other->results));
    return results;
  }

  // What is left out and would be the answer, had it arrived on steps that resolve it.
  static std::string words_of(const Kept& left_out, const Kept& answer) {
    const maneuver::Solution& is = left_out.results.solution;
    if (left_out.unfinished.empty() || !(is.cost < answer.results.solution.cost)) return "";
    return fmt::format(" A cheaper motion (cost {:.6g}) is left out, since its {} steps do not resolve it.{}", is.cost,
                       left_out.steps, left_out.unfinished);
  }

  bool interrupted() const { return options_.interrupted && options_.interrupted(); }

  bool has_time() {
    if (interrupted()) return false;
    if (!asked_.problem.search.time_limit) return true;
    finer_.problem.search.time_limit = *asked_.problem.search.time_limit - seconds();
    return *finer_.problem.search.time_limit > 0.0;
  }

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

  // Of the search that found it, and what all of it took.
  void take_record(const maneuver::Solution& before, maneuver::Solution& after) const {
    after.search = before.search;
    after.search.set_aside.reset();  // what these steps do not resolve has its own search on more
    if (after.status == maneuver::Status::optimal) after.message += study::on_cheaper_ones(after);
    after.solver.iterations += before.solver.iterations;
    after.solver.evaluations += before.solver.evaluations;
    after.solver.wall_seconds += before.solver.wall_seconds;
    after.solver.processor_seconds += before.solver.processor_seconds;
  }

  const file::ProblemFile& asked_;
  file::ProblemFile finer_;
  search::SolveOptions options_;
  const std::string& command_;
  double bytes_ = study::bytes_of_machine();
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

result::Results resolve_task(const file::ProblemFile& file, const search::SolveOptions& options,
                             const std::string& command, const std::optional<EarlierMotion>& first) {
  search::SolveOptions to_begin_with = options;
  to_begin_with.resolving = true;
  Resolving resolving(file, to_begin_with, command);
  return resolving.from(solve_task(file, to_begin_with, command, first));
}

}  // namespace lamprey::task
