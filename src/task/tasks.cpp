#include "task/tasks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "certificate/certify.hpp"
#include "certificate/verdict.hpp"
#include "document/text_table.hpp"
#include "file/words.hpp"
#include "result/followed_file.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "result/stored_question.hpp"
#include "result/trajectory_file.hpp"
#include "study/answer.hpp"
#include "study/enough_memory.hpp"
#include "study/faults.hpp"
#include "study/refinement.hpp"
#include "study/verdict.hpp"
#include "task/model_remarks.hpp"
#include "task/model_table.hpp"
#include "task/problem_difference.hpp"
#include "task/stored_statements.hpp"

namespace lamprey::task {

namespace {

// What costs on other grids say of the answer's: the costs themselves no file shows again.
certificate::Refinement refinement_again(const certificate::Refinement& stored, const maneuver::Problem& problem,
                                         double cost) {
  std::vector<certificate::GridCost> grids = stored.grids;
  for (certificate::GridCost& grid : grids)
    if (grid.steps == problem.steps) grid.cost = cost;
  return study::refinement_of(grids, problem.steps, study::expected_order(problem));
}

// Of a first motion, where joints are of other kinds than those it was made with.
void tell_what_joints_leave_out(const search::FirstMotion& first, const model::System& system, const std::string& path,
                                const search::SolveOptions& options) {
  constexpr double worth_telling = 1e-6;  // rad
  if (!options.progress || first.left_out <= worth_telling) return;
  const model::Joint& joint = system.joint(first.left_out_by);
  options.progress(
      fmt::format("the first motion is that of {} without what joints here cannot turn: {} (a {} joint) leaves out "
                  "up to {:.3g} rad",
                  path, joint.name, file::word(joint.kind), first.left_out));
}

// Of a first motion whose bodies or joints go by other names: they are taken in their order.
void tell_other_names(const result::ResolvedProblem& moved, const model::System& system, const std::string& path,
                      const search::SolveOptions& options) {
  if (!options.progress) return;
  const auto tell = [&](const char* what, const std::string& there, const std::string& here) {
    options.progress(
        fmt::format("the first motion is that of {}, whose {} \"{}\" is taken for \"{}\": is it the same swimmer?",
                    path, what, document::printable(there), document::printable(here)));
  };
  for (int i = 0; i < system.body_count(); ++i)
    if (const std::string& there = moved.bodies[model::at(i)].name; there != system.body(i).name)
      return tell("body", there, system.body(i).name);
  for (int j = 0; j < system.joint_count(); ++j)
    if (const std::string& there = moved.joints[model::at(j)].name; there != system.joint(j).name)
      return tell("joint", there, system.joint(j).name);
}

result::Results with_answer(result::Results begun, study::Answer& answer) {
  begun.solution = std::move(answer.solution);
  begun.certificate = answer.certificate;
  begun.failure = std::move(answer.failure);
  if (!begun.problem.free_duration) return begun;
  begun.problem.duration = begun.solution.time.back();
  begun.problem.time_step = begun.problem.duration / begun.problem.steps;
  return begun;
}

// Where the solver's own record, which no file shows again, says that total momentum leaked on the way to an optimal answer.
std::string leak_on_the_way(const result::Results& stored, const certificate::Certificate& found) {
  if (stored.solution.status != maneuver::Status::optimal) return "";
  const double told = stored.certificate ? stored.certificate->iterates_momentum : evidence::unset;
  const double most = std::fmax(told, found.iterates_momentum), allowed = found.momentum_allowed();
  if (!(most > allowed)) return "";
  return fmt::format("the solver's iterates are told to have total momentum up to {:.3g} of its scale, allowed {:.3g}",
                     most, allowed);
}

}  // namespace

model::System system_of(const file::ProblemFile& file) {
  try {
    return model::System(file.problem.swimmer);
  } catch (const model::InputError& error) {
    throw file::located(error, file);
  }
}

std::string check_task(const file::ProblemFile& file) {
  const model::System system = system_of(file);
  file::require_ends_within_limits(file);
  std::string text = model_table(file.problem, system, model_remarks(file, system));
  if (!file.problem.goal) return text;
  try {
    file::require_supported(file, file::Purpose::solve);
    study::require_memory(system, file.problem, study::bytes_of_machine());
  } catch (const model::InputError& refusal) {  // a file may be valid, and simulate take it
    text += "\nNot for lamprey solve\n" + document::wrapped(refusal.what());
  }
  return text;
}

result::Results begun_results(const file::ProblemFile& file, const model::System& system, const std::string& command) {
  result::Results results;
  results.name = file.problem.name;
  results.source = file.problem.source;
  results.problem = result::resolve(system, file.problem);
  results.provenance = result::provenance_here();
  results.provenance.command = command;
  results.provenance.problem_sha256 = file.sha256;
  results.provenance.seed = file.problem.search.seed;
  return results;
}

result::Results solve_task(const file::ProblemFile& file, const search::SolveOptions& asked, const std::string& command,
                           const std::optional<EarlierMotion>& first) {
  search::SolveOptions options = asked;
  const bool of_ipopt = options.solver == search::Backend::ipopt || options.solver == search::Backend::both;
  file::require_supported(file, of_ipopt ? file::Purpose::solve_with_ipopt : file::Purpose::solve);
  const model::System system = system_of(file);
  result::Results results = begun_results(file, system, command);
  if (first) {
    result::require_same_tree(first->results, first->path, system, false);
    result::require_whole(first->results, first->path);
    options.first = search::first_motion(system, file.problem, first->results.solution);
    tell_other_names(first->results.problem, system, first->path, options);
    tell_what_joints_leave_out(*options.first, system, first->path, options);
  }
  try {
    study::Answer answer = study::answer(system, file.problem, options);
    for (study::Answer& other : answer.others)
      results.others.push_back(with_answer(begun_results(file, system, command), other));
    return with_answer(std::move(results), answer);
  } catch (const model::InputError& error) {
    throw file::located(error, file);
  }
}

result::Results certified(const result::Results& results) {
  result::Results again = results;
  const maneuver::Problem problem = result::problem_of(results);
  const model::System system(problem.swimmer);
  const bool sought = problem.goal && results.solution.status != maneuver::Status::simulated;
  std::string refusal = sought && results.problem.start ? result::refusal_of(problem) : "";
  if (sought && refusal.empty())
    refusal = result::foreign_multiplier(system, problem, results.solution.limit_multipliers);
  certificate::Options options;
  options.optimality = options.second_order = refusal.empty();
  again.certificate = certificate::certify(system, problem, results.solution, options);
  again.certificate->refusal = refusal;
  if (!results.problem.start) again.certificate->start_error = evidence::unset;  // known by nothing but the answer
  if (sought) again.certificate->verdict = certificate::verdict(problem, *again.certificate);
  if (results.certificate && results.certificate->refinement)
    again.certificate->refinement = refinement_again(*results.certificate->refinement, problem, results.solution.cost);
  const bool ended_early = results.marched() && results.solution.status != maneuver::Status::simulated;
  if (!ended_early) again.solution.message.clear();  // no optimiser stopped here, and none says that it arrived
  if (again.solution.status == maneuver::Status::optimal) again.solution.status = maneuver::Status::feasible;
  if (again.solution.status == maneuver::Status::simulated)
    study::judge_march(problem, *again.certificate, again.solution);
  else if (problem.goal)
    again.failure = study::judge(problem, *again.certificate, again.solution);
  return again;
}

bool Verification::promises() const {
  const maneuver::Status claimed = stored.solution.status;
  return claimed == maneuver::Status::optimal || claimed == maneuver::Status::simulated;
}

Verification verify_task(const std::string& folder, const std::optional<file::ProblemFile>& asked) {
  Verification result;
  result.stored = result::read_solution(folder);
  result.found = certified(result.stored);
  if (result.promises()) result.status_holds = result.found.solution.status == result.stored.solution.status;
  const bool sought = result.found.problem.goal && result.stored.solution.status != maneuver::Status::simulated;
  result.fault = sought ? study::fault(result::problem_of(result.found), *result.found.certificate)
                        : result.found.solution.message;
  if (const std::string leak = leak_on_the_way(result.stored, *result.found.certificate);
      !leak.empty() && result.status_holds) {
    result.status_holds = false;
    result.fault = leak;
  }
  if (!result.status_holds && result.fault.empty()) result.fault = "nothing in the file bears it out";
  if (result.stored.certificate)
    result.claims =
        certificate::false_claims(*result.stored.certificate, *result.found.certificate,
                                  result.stored.solution.time.empty() ? 0.0 : result.stored.solution.time.back(),
                                  model::System(result::swimmer_of(result.stored.problem)).length_unit());
  for (certificate::FalseClaim& claim : false_statements(result.stored, result.found, sought && result.status_holds))
    result.claims.push_back(std::move(claim));
  result.trajectory_difference = result::trajectory_difference(folder, result.stored);
  if (asked) {
    result.problem_differences = problem_differences(result.stored, *asked);
    result.march_differences = march_differences(result.stored, *asked);
  }
  return result;
}

}  // namespace lamprey::task
