#include "file/tasks.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "certificate/certify.hpp"
#include "file/followed_file.hpp"
#include "file/problem_difference.hpp"
#include "file/resolve.hpp"
#include "file/solution_file.hpp"
#include "file/stored_question.hpp"
#include "file/trajectory_file.hpp"
#include "lie/so3.hpp"
#include "study/advice.hpp"
#include "study/answer.hpp"
#include "study/faults.hpp"
#include "study/found.hpp"
#include "study/refinement.hpp"
#include "study/verdict.hpp"

namespace lamprey::file {

namespace {

constexpr int most_resolving_rounds = 4;

// What costs on other grids say of the answer's: the costs themselves no file shows again.
certificate::Refinement refinement_again(const certificate::Refinement& stored, const maneuver::Problem& problem,
                                         double cost) {
  std::vector<certificate::GridCost> grids = stored.grids;
  for (certificate::GridCost& grid : grids)
    if (grid.steps == problem.steps) grid.cost = cost;
  return study::refinement_of(grids, problem.steps, study::expected_order(problem));
}

// Where the problem's own times differ from each other or from the nodes'.
void add_false_times(const Results& stored, std::vector<certificate::FalseClaim>& claims) {
  const ResolvedProblem& problem = stored.problem;
  const std::vector<double>& time = stored.solution.time;
  const auto claim = [&](const char* field, double told, double is) {
    if (!(std::abs(told - is) <= certificate::time_mark * std::abs(is))) claims.push_back({field, told, is});
  };
  if (problem.steps == 0) return;
  if (problem.free_duration && time.size() > 1) claim("problem.duration", problem.duration, time.back());
  claim("problem.time_step", problem.time_step, problem.duration / problem.steps);
}

// Where an angle that counts whole turns jumps by more than half of one from node to node, which no step does.
void add_false_turns(const Results& stored, std::vector<certificate::FalseClaim>& claims) {
  const auto& angle = stored.solution.joint_angle;
  for (std::size_t j = 0; j < stored.problem.joints.size(); ++j) {
    if (stored.problem.joints[j].kind == model::JointKind::ball) continue;
    for (std::size_t k = 0; k + 1 < angle.size(); ++k)
      for (int axis = 0; axis < 2; ++axis) {
        const double before = angle[k][j][axis], told = angle[k + 1][j][axis];
        const double turn = lie::shorter_way(told - before);
        if (std::abs(told - before) <= std::numbers::pi) continue;
        claims.push_back({fmt::format("joint_angle[{}][{}][{}]", k + 1, j, axis), told, before + turn});
        return;
      }
  }
}

Results with_answer(Results begun, study::Answer& answer) {
  begun.solution = std::move(answer.solution);
  begun.certificate = answer.certificate;
  if (!begun.problem.free_duration) return begun;
  begun.problem.duration = begun.solution.time.back();
  begun.problem.time_step = begun.problem.duration / begun.problem.steps;
  return begun;
}

}  // namespace

model::System system_of(const ProblemFile& file) {
  try {
    return model::System(file.problem.swimmer);
  } catch (const model::InputError& error) {
    throw located(error, file);
  }
}

Results begun_results(const ProblemFile& file, const model::System& system, const std::string& command) {
  Results results;
  results.name = file.problem.name;
  results.source = file.problem.source;
  results.problem = resolve(system, file.problem);
  results.provenance = provenance_here();
  results.provenance.command = command;
  results.provenance.problem_sha256 = file.sha256;
  results.provenance.seed = file.problem.search.seed;
  return results;
}

Results solve_task(const ProblemFile& file, const study::SolveOptions& asked, const std::string& command,
                   const std::optional<StoredMotion>& first) {
  study::SolveOptions options = asked;
  const bool of_ipopt = options.solver == study::Backend::ipopt || options.solver == study::Backend::both;
  require_supported(file, of_ipopt ? Purpose::solve_with_ipopt : Purpose::solve);
  const model::System system = system_of(file);
  Results results = begun_results(file, system, command);
  if (first) {
    require_same_tree(first->results, first->path, system, false);
    require_whole(first->results, first->path);
    options.first = study::first_motion(system, file.problem, first->results.solution);
  }
  try {
    study::Answer answer = study::answer(system, file.problem, options);
    for (study::Answer& other : answer.others)
      results.others.push_back(with_answer(begun_results(file, system, command), other));
    return with_answer(std::move(results), answer);
  } catch (const model::InputError& error) {
    throw located(error, file);
  }
}

namespace {

// An answer and those kept beside it whose steps do not resolve them, from them on solved again on as many as the most demanding
// replay proposes, until they do or time is over: all of them, so that their costs can be compared where they arrive.
class Resolving {
 public:
  Resolving(const ProblemFile& file, const study::SolveOptions& options, const std::string& command)
      : asked_(file), finer_(file), options_(options), command_(command) {
    maneuver::Search& search = finer_.problem.search;
    search.starts = search.keep = 1;
    search.hops = search.whole_turns = 0;
    options_.first_alone = true;
  }

  Results from(Results results) {
    std::vector<Kept> kept;
    for (Results& other : results.others) kept.push_back({std::move(other), asked_.problem.steps});
    results.others.clear();
    kept.insert(kept.begin(), {std::move(results), asked_.problem.steps});
    for (int round = 0;; ++round) {
      int steps = 0;
      for (const Kept& each : kept) steps = std::max(steps, steps_for(each));
      const auto lags = [&](const Kept& each) { return each.arrived && each.steps < steps; };
      if (std::none_of(kept.begin(), kept.end(), lags)) break;
      if (round == most_resolving_rounds || !has_time()) {
        for (Kept& each : kept)
          if (lags(each)) tell_untried(each, steps);
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
    Results results;
    int steps;
    bool arrived = true;  // on steps that were proposed
  };

  maneuver::Problem problem_of(const Kept& kept) const {
    maneuver::Problem problem = asked_.problem;
    problem.steps = kept.steps;
    return problem;
  }

  int steps_for(const Kept& kept) const {
    const Results& is = kept.results;
    return kept.arrived ? study::steps_to_resolve(problem_of(kept), *is.certificate, is.solution).value_or(kept.steps)
                        : 0;
  }

  void tell_untried(Kept& kept, int steps) {
    kept.results.solution.message +=
        fmt::format(" {} steps were not tried: {}.", steps,
                    has_time() ? "--resolve goes on no further" : "the time was over (search.time_limit)");
  }

  void solve_again(Kept& kept, int steps) {
    finer_.problem.steps = steps;
    Results again = solve_task(finer_, options_, command_, StoredMotion{kept.results, "the answer on fewer steps"});
    kept.arrived = again.solution.status == maneuver::Status::optimal;
    if (!kept.arrived) {
      const bool late = again.solution.status == maneuver::Status::time_limit;
      kept.results.solution.message +=
          late ? fmt::format(
                     " The time was over before the search on {} steps arrived: give it more than {:.0f} s "
                     "(search.time_limit).",
                     steps, std::ceil(*asked_.problem.search.time_limit))
               : fmt::format(" From it the search on {} steps did not arrive.", steps);
      return;
    }
    again.solution.message +=
        fmt::format(" It was found on {} steps, and solved again on these.", asked_.problem.steps);
    take_record(kept.results.solution, again.solution);
    kept.results = std::move(again);
    kept.steps = steps;
  }

  // Proved ones first, of these what their steps resolve, by rising cost. What were two minima on fewer steps may be one.
  Results merged(std::vector<Kept> kept) const {
    const auto order = [&](const Kept& each) {
      const Results& is = each.results;
      return std::tuple(is.certificate->verdict != certificate::Verdict::proved,
                        !study::unresolved(problem_of(each), is.solution, *is.certificate).empty(), is.solution.cost);
    };
    std::stable_sort(kept.begin(), kept.end(), [&](const Kept& a, const Kept& b) { return order(a) < order(b); });
    const auto same = [](const Kept& a, const Kept& b) {
      return a.steps == b.steps && study::same_minimum(a.results.solution.cost, b.results.solution.cost);
    };
    kept.erase(std::unique(kept.begin(), kept.end(), same), kept.end());
    for (; std::ssize(kept) > asked_.problem.search.keep; kept.pop_back())
      kept.front().results.solution.message += words_of(kept.back(), kept.front());
    Results results = std::move(kept.front().results);
    for (auto other = kept.begin() + 1; other != kept.end(); ++other)
      results.others.push_back(std::move(other->results));
    return results;
  }

  // What is left out and would be the answer, had it arrived on steps that resolve it.
  static std::string words_of(const Kept& left_out, const Kept& answer) {
    const maneuver::Solution& is = left_out.results.solution;
    if (left_out.arrived || !(is.cost < answer.results.solution.cost)) return "";
    return fmt::format(" A cheaper motion (cost {:.6g}, on {} steps) did not arrive on more.", is.cost, left_out.steps);
  }

  bool has_time() {
    if (options_.interrupted && options_.interrupted()) return false;
    if (!asked_.problem.search.time_limit) return true;
    finer_.problem.search.time_limit = *asked_.problem.search.time_limit - seconds();
    return *finer_.problem.search.time_limit > 0.0;
  }

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

  // Of the search that found it, and what all of it took.
  void take_record(const maneuver::Solution& before, maneuver::Solution& after) const {
    after.search = before.search;
    after.search.set_aside.reset();  // what these steps do not resolve has its own search on more
    after.solver.iterations += before.solver.iterations;
    after.solver.evaluations += before.solver.evaluations;
    after.solver.wall_seconds += before.solver.wall_seconds;
    after.solver.processor_seconds += before.solver.processor_seconds;
    after.solver.total_wall_seconds = seconds();
  }

  const ProblemFile& asked_;
  ProblemFile finer_;
  study::SolveOptions options_;
  const std::string& command_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

Results resolve_task(const ProblemFile& file, const study::SolveOptions& options, const std::string& command,
                     const std::optional<StoredMotion>& first) {
  study::SolveOptions to_begin_with = options;
  to_begin_with.resolving = true;
  Resolving resolving(file, to_begin_with, command);
  return resolving.from(solve_task(file, to_begin_with, command, first));
}

Results certified(const Results& results) {
  Results again = results;
  const maneuver::Problem problem = problem_of(results);
  const model::System system(problem.swimmer);
  const bool sought = problem.goal && results.solution.status != maneuver::Status::simulated;
  std::string refusal = sought && results.problem.start ? refusal_of(problem) : "";
  if (sought && refusal.empty()) refusal = foreign_multiplier(system, problem, results.solution.limit_multipliers);
  certificate::Options options;
  options.optimality = options.second_order = refusal.empty();
  again.certificate = certificate::certify(system, problem, results.solution, options);
  again.certificate->refusal = refusal;
  if (!results.problem.start) again.certificate->start_error = certificate::unset;  // known by nothing but the answer
  if (sought) again.certificate->verdict = certificate::verdict(problem, *again.certificate);
  if (results.certificate && results.certificate->refinement)
    again.certificate->refinement = refinement_again(*results.certificate->refinement, problem, results.solution.cost);
  again.solution.message.clear();  // no optimiser stopped here, and none says that it arrived
  if (again.solution.status == maneuver::Status::optimal) again.solution.status = maneuver::Status::feasible;
  if (again.solution.status == maneuver::Status::simulated)
    study::judge_march(*again.certificate, again.solution);
  else if (problem.goal)
    study::judge(problem, *again.certificate, again.solution);
  return again;
}

bool Verification::promises() const {
  const maneuver::Status claimed = stored.solution.status;
  return claimed == maneuver::Status::optimal || claimed == maneuver::Status::simulated;
}

Verification verify_task(const std::string& folder, const std::optional<ProblemFile>& asked) {
  Verification result;
  result.stored = read_solution(folder);
  result.found = certified(result.stored);
  if (result.promises()) result.status_holds = result.found.solution.status == result.stored.solution.status;
  const bool sought = result.found.problem.goal && result.stored.solution.status != maneuver::Status::simulated;
  result.fault =
      sought ? study::fault(problem_of(result.found), *result.found.certificate) : result.found.solution.message;
  if (!result.status_holds && result.fault.empty()) result.fault = "nothing in the file bears it out";
  if (result.stored.certificate)
    result.claims = certificate::false_claims(*result.stored.certificate, *result.found.certificate);
  add_false_times(result.stored, result.claims);
  add_false_turns(result.stored, result.claims);
  result.trajectory_difference = trajectory_difference(folder, result.stored);
  if (asked) result.problem_differences = problem_differences(result.stored, *asked);
  return result;
}

}  // namespace lamprey::file
