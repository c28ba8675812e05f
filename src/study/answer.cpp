#include "study/answer.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "certificate/certify.hpp"
#include "maneuver/feedback.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

std::string number(double value, int digits = 2) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

// What keeps the answer from being feasible; empty when nothing does.
std::string unmet(const Problem& problem, const Certificate& proof) {
  if (!(proof.equation_residual <= equation_mark))
    return "no motion was found that obeys the mechanics and meets the goal (discrete equations off by " +
           number(proof.equation_residual) + " of the momentum's scale, goal by " + number(proof.goal_error) +
           " rad or m)";
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

// Whether the steps are fine enough for the motion: an independent integrator stays with it between restarts.
bool resolved(const Certificate& proof) { return proof.replay && proof.replay->rotation_error <= replay_mark; }

// Answers in order of worth: proven first, then resolved, then cheap.
std::tuple<bool, bool, double> rank(const Answer& answer) {
  return {answer.solution.status != Status::optimal, !resolved(answer.certificate), answer.solution.cost};
}

// Gains about the answer, and its replay with them.
void add_feedback(const model::System& system, const Problem& problem, Answer& answer) {
  try {
    answer.solution.feedback = maneuver::design_feedback(system, problem, answer.solution);
  } catch (const std::domain_error& error) {
    answer.solution.message += std::string(" It comes without feedback: ") + error.what() + ".";
    return;
  }
  certificate::certify_feedback(system, problem, answer.solution, answer.certificate);
}

}  // namespace

void judge(const Problem& problem, const Certificate& proof, Solution& solution) {
  const std::string missing = unmet(problem, proof);
  const bool stationary = proof.kkt <= problem.search.tolerance;
  const std::string stopped = solution.message.empty() ? "" : " The optimiser stopped: " + solution.message + ".";
  const bool cut_short = solution.status == Status::interrupted || solution.status == Status::time_limit;
  if (missing.empty() && stationary) {
    solution.status = Status::optimal;
    solution.message =
        "Goal met within " + number(proof.goal_error) + " (rad, m); stationary to " + number(proof.kkt) + ".";
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
  std::vector<Certificate> proofs;
  SolveOptions certified = options;
  certified.accept = [&](Solution& solution) {
    if (options.progress) options.progress("certifying");
    proofs.push_back(certificate::certify(system, problem, solution));
    judge(problem, proofs.back(), solution);
    return solution.status == Status::optimal && resolved(proofs.back());
  };
  const std::vector<Solution> solutions = solve(system, problem, certified);
  std::vector<Answer> found;
  for (std::size_t n = 0; n < solutions.size(); ++n) found.push_back({solutions[n], proofs[n]});
  Answer best =
      *std::min_element(found.begin(), found.end(), [](const Answer& a, const Answer& b) { return rank(a) < rank(b); });
  for (const Answer& other : found)
    if (other.solution.status == Status::optimal && !resolved(other.certificate) &&
        other.solution.cost < best.solution.cost)
      best.solution.message +=
          " A cheaper motion (cost " + number(other.solution.cost, 6) + ") was set aside: its replay misses by " +
          number(other.certificate.replay->rotation_error) + " rad, so these steps are too coarse for it.";
  if (best.solution.status == Status::optimal) add_feedback(system, problem, best);
  return best;
}

}  // namespace lamprey::study
