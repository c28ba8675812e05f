#include "study/answer.hpp"

#include <cmath>
#include <sstream>

#include "certificate/certify.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

std::string number(double value) {
  std::ostringstream text;
  text.precision(2);
  text << value;
  return text.str();
}

// What keeps the answer from being feasible; empty when nothing does.
std::string unmet(const Problem& problem, const Certificate& proof) {
  if (!(proof.equation_residual <= equation_mark))
    return "the discrete equations are met to " + number(proof.equation_residual) + " of the momentum's scale only";
  if (!(proof.goal_error <= goal_mark)) return "the goal is missed by " + number(proof.goal_error) + " (rad or m)";
  if (problem.goal && problem.goal->rest && !(proof.rest_error <= rest_mark))
    return "the end is not at rest: momentum " + number(proof.rest_error) + " of its scale is left";
  return "";
}

std::string advice(const Problem& problem) {
  if (problem.search.method == maneuver::SearchMethod::shooting) return "set method = \"simultaneous\"";
  if (problem.search.starts == 1) return "try [search] starts = 8, another seed, or a nearer goal";
  return "try more starts, another seed, or a nearer goal; check that control_axes can reach it";
}

}  // namespace

void judge(const Problem& problem, const Certificate& proof, Solution& solution) {
  const std::string missing = unmet(problem, proof);
  const bool stationary = proof.kkt <= problem.search.tolerance;
  const std::string stopped = solution.message.empty() ? "" : " The optimiser stopped: " + solution.message + ".";
  const bool cut_short = solution.status == Status::interrupted || solution.status == Status::time_limit;
  if (missing.empty() && stationary) {
    solution.status = Status::optimal;
    solution.message = "Goal met within " + number(proof.goal_error) + " (rad, m); stationary to " + number(proof.kkt) + ".";
  } else if (missing.empty()) {
    if (!cut_short) solution.status = Status::feasible;
    solution.message = "The goal is met, but the cost is stationary to " + number(proof.kkt) + " only, not to " +
                       number(problem.search.tolerance) + "." + stopped + " To mend it: " + advice(problem) + ".";
  } else {
    if (!cut_short && solution.status != Status::infeasible) solution.status = Status::stalled;
    solution.message = "Not solved: " + missing + "." + stopped + " What may help: " + advice(problem) + ".";
  }
}

Answer answer(const model::System& system, const Problem& problem, const SolveOptions& options) {
  Answer found;
  found.solution = solve(system, problem, options);
  if (options.progress) options.progress("certifying");
  found.certificate = certificate::certify(system, problem, found.solution);
  judge(problem, found.certificate, found.solution);
  return found;
}

}  // namespace lamprey::study
