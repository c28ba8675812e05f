#include "study/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "certificate/verdict.hpp"
#include "study/advice.hpp"
#include "study/faults.hpp"
#include "study/plain_words.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using evidence::goal_mark;
using evidence::limit_mark;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

// Of a single joint angle long steps reach poses, by their own error, that no motion does.
std::string why_curvature_is_not_told(const Problem& problem, bool worked) {
  constexpr int fewest = 200, many = 1000;
  if (worked) return "where powers vanish second derivatives may differ from side to side";
  std::string words = "its second derivatives may be lost in round-off";
  if (problem.steps < many)
    words += ", or in the error of long steps: [time] steps = " + std::to_string(std::max(fewest, 2 * problem.steps)) +
             " may show it";
  return words;
}

// What is particular about where a search ended.
std::string where_it_ended(const Problem& problem, const Solution& solution) {
  return far_turn(problem, solution) + spring_at_its_jump(problem, solution) + fading(problem, solution);
}

// Whether the goal is missed by more than an optimiser leaves of what it meets, which is in the swimmer's own unit of length.
bool missed_beyond_tolerance(const Problem& problem, const Certificate& proof) {
  constexpr double left = 10.0;  // of the mark
  const double unit = proof.goal_missed_by_turn ? 1.0 : model::System(problem.swimmer).length_unit();
  return !(proof.goal_error <= goal_mark * std::max(1.0, left * unit));
}

// Which limits a motion that does not arrive is at, as a sentence.
std::string reached_words(const Certificate& proof) {
  if (!proof.limits || proof.limits->reached.empty()) return "";
  std::string words, bounds;
  for (const auto& [key, share] : proof.limits->reached)
    if (key.starts_with("time."))  // the whole of it, not nodes
      bounds += (bounds.empty() ? "" : ", ") + key;
    else
      words += (words.empty() ? "of its nodes " : ", ") + key + " at " +
               number(std::max(1.0, std::round(100.0 * share)), 3) + " %";
  return " Its motion is at its limits: " + words + (words.empty() || bounds.empty() ? "" : "; ") + bounds + ".";
}

// An optimiser's reason but for its last clause, where that says what the certificate does of the goal.
std::string without_what_is_missed(const std::string& reason, const Certificate& proof) {
  const std::size_t clause = reason.rfind("; ");
  const bool again = clause != std::string::npos && !proof.goal_missed.empty() &&
                     reason.substr(clause + 2).starts_with(proof.goal_missed + " is missed by");
  return again ? reason.substr(0, clause) : reason;
}

// What is not as asked for, with the time that it takes where that is not as asked, either.
std::string missing_words(const Problem& problem, const Certificate& proof, const Solution& solution) {
  std::string missing = unmet(problem, proof);
  const double duration = solution.time.empty() ? 0.0 : solution.time.back() - solution.time.front();
  const bool above = duration > problem.duration.max * (1.0 + limit_mark);
  const bool below = duration < problem.duration.min * (1.0 - limit_mark);
  const bool said_so = proof.limits && proof.limits->key.starts_with("time.") && missing.starts_with("time.");
  if (!missing.empty() && !said_so && problem.duration.free && !solution.time.empty() && (above || below))
    missing += ", in " + number(duration, 3) + " s, beyond " + (above ? "time.max" : "time.min");
  return missing;
}

}  // namespace

maneuver::Failure judge(const Problem& problem, const Certificate& proof, Solution& solution) {
  const std::string missing = missing_words(problem, proof, solution), other = foreign(proof);
  const std::string reason = without_what_is_missed(solution.message, proof);
  const bool said = !reason.empty() && reason != "converged";
  const std::string stopped = said ? " The optimiser stopped: " + reason + "." : "";
  const bool cut_short = solution.status == Status::interrupted || solution.status == Status::time_limit;
  // what steps cannot show may be within reach of shorter ones
  if (solution.status == Status::infeasible && !far_turn(problem, solution).empty()) solution.status = Status::stalled;
  if (other.empty() && missing.empty() && certificate::stationary(problem, proof)) {
    solution.status = Status::optimal;
    solution.message = words_of_goal(proof) + far_turn(problem, solution) + way_round(problem, solution) +
                       ways_of_joints(problem, solution);
    return {};
  }
  maneuver::Failure failure;
  std::string cause = stopped;
  if (!other.empty()) {
    if (!cut_short) solution.status = Status::stalled;
    failure.missed = "No answer to this problem: " + other + ".";
  } else if (missing.empty()) {
    if (!cut_short) solution.status = Status::feasible;
    failure.missed = "The goal is met, but " + unsettled(problem, proof) + ".";
    cause += where_it_ended(problem, solution);
    failure.remedies = advice(problem, proof, solution);
  } else if (solution.status == Status::optimal && missed_beyond_tolerance(problem, proof)) {
    solution.status = Status::infeasible;
    failure = {"Out of reach: " + missing + ", and no moment of these joints changes that.",
               "",
               {"other control_axes or joints", "a goal that leaves this free"}};
    cause.clear();
  } else {
    if (!cut_short && solution.status != Status::infeasible) solution.status = Status::stalled;
    failure.missed = "Not solved: " + missing + ".";
    cause += where_it_ended(problem, solution) + reached_words(proof);
    if (solution.status != Status::interrupted)  // which says nothing of what is asked
      failure.remedies = advice(problem, proof, solution);
  }
  if (!cause.empty()) failure.cause = cause.substr(1);  // after the blank
  solution.message = failure.text();
  return failure;
}

void judge_march(const Problem& problem, const Certificate& proof, Solution& solution) {
  const auto beyond = [](double error, double mark) { return error > mark; };  // NaN: not computed
  const bool of_stages =
      !integrator::single_step(problem.scheme) && solution.divided.steps == 0 && solution.marched_by.empty();
  std::string missing;
  if (of_stages && std::isnan(proof.equation_residual))
    missing = "the files lack control_stages or velocities, which all marches by such a scheme tell";
  else if (beyond(proof.equation_residual, proof.equation_allowed()))
    missing = "the discrete equations are off by " + number(proof.equation_residual) + " of the momentum's scale";
  else if (beyond(proof.momentum_drift, proof.momentum_allowed()))
    missing = "total momentum changes by " + number(proof.momentum_drift) + " of its scale";
  else if (beyond(proof.rotation_drift, evidence::rotation_mark))
    missing = "rotations are none: |RᵀR − I| is " + number(proof.rotation_drift);
  else if (beyond(proof.start_error, evidence::start_mark))
    missing = "it begins " + number(proof.start_error) + " (rad or m) beside its start";
  else if (beyond(proof.velocity_error, evidence::velocity_mark))
    missing =
        "stored velocities, momenta or joint angles are off by " + number(proof.velocity_error) + " of the largest";
  else if (beyond(proof.time_error, evidence::time_mark))
    missing = "the nodes' times differ by " + number(proof.time_error) + " of the duration from equal steps";
  else if (beyond(proof.control_error, evidence::control_mark))
    missing = number(proof.control_error) + " of the moments is outside what the joints can exert";
  else if (beyond(proof.beyond_moments, 1.0))
    missing = std::isinf(proof.beyond_moments)
                  ? std::string("more of its steps than were divided are none of the scheme's")
                  : "a step leads " + number(proof.beyond_moments) + " times as far as moments like its own leave open";
  else if (std::isfinite(solution.cost))
    missing = "a march has no cost, and one is stored";
  if (missing.empty()) return;
  solution.status = Status::stalled;
  solution.message = "No march: " + missing + ".";
}

std::string curvature_words(const Problem& problem, const Certificate& proof) {
  const auto saddle = [](const optimality::SecondOrder& second) {
    return second.negative_eigenvalues && *second.negative_eigenvalues > 0;
  };
  const auto directions = [](const optimality::SecondOrder& second) {
    return std::to_string(*second.negative_eigenvalues) +
           (*second.negative_eigenvalues == 1 ? " direction lowers" : " directions lower") + " the cost";
  };
  const maneuver::CostWeights& weights = problem.cost_weights;
  const bool worked = weights.work > 0.0 || weights.transport > 0.0;  // squared power has no kinks
  std::string words;
  if (!proof.second_order)
    words = " Whether it is a minimum cannot be told: " + why_curvature_is_not_told(problem, worked) + ".";
  else if (proof.second_order->positive)
    words = proof.kkt <= optimality::proof_mark
                ? words_of_minimum(proof)
                : " Not proved a minimum: its conditions hold to " + number(proof.kkt, 4) +
                      " only, and a proof takes " + number(optimality::proof_mark) + ".";
  else if (saddle(*proof.second_order))
    words = " A saddle: " + directions(*proof.second_order) +
            "; another number of time.steps, more starts or another seed may lead to a minimum.";
  else if (proof.second_order->lost())
    words =
        " Not proved a minimum: round-off hides whether directions lower the cost; other steps, another seed or a "
        "longer "
        "duration may show it.";
  else
    words = " Not proved a minimum: smallest curvature " + number(proof.second_order->smallest_eigenvalue, 3) + ".";
  const bool flat = proof.second_order && !proof.second_order->positive &&
                    std::abs(proof.second_order->smallest_eigenvalue) < optimality::curvature_mark;
  if (flat && problem.goal->periodic && problem.start.free_shape)
    words += " Where nothing ties a gait to its start it may begin anywhere along itself, which costs the same.";
  else if (flat)
    words +=
        " Along it the cost hardly changes: answers of equal cost may lie there, as where bodies are symmetric about "
        "an axis.";
  if (proof.all_axes && saddle(proof.all_axes->second_order))
    words += " With moments about all joint axes it is a saddle: " + directions(proof.all_axes->second_order) + ".";
  return words;
}

}  // namespace lamprey::study
