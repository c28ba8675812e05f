#include "certificate/verdict.hpp"

namespace lamprey::certificate {

namespace {

// Whether the files tell of a motion of the problem's swimmer, from its start, in its time, by moments that it has, at the cost
// that they state.
bool of_the_problem(const Certificate& proof) {
  return proof.refusal.empty() && proof.rotation_drift <= evidence::rotation_mark &&
         proof.momentum_drift <= proof.momentum_allowed() && proof.start_error <= evidence::start_mark &&
         proof.control_error <= evidence::control_mark && proof.time_error <= evidence::time_mark &&
         proof.velocity_error <= evidence::velocity_mark && proof.cost_error <= evidence::cost_mark;
}

}  // namespace

bool meets_goal(const maneuver::Problem& problem, const Certificate& proof) {
  return of_the_problem(proof) && proof.equation_residual <= proof.equation_allowed() &&
         proof.goal_error <= evidence::goal_mark &&
         (!problem.goal->stills_joints() || proof.rest_error <= evidence::rest_mark) &&
         (!proof.limits || proof.limits->violation <= evidence::limit_mark);
}

bool stationary(const maneuver::Problem& problem, const Certificate& proof) {
  return proof.kkt <= proof.kkt_allowed(problem.search.tolerance) &&
         (!proof.costs || proof.costs->signs <= evidence::sign_mark) &&
         (!proof.limits || (proof.limits->complementarity <= evidence::complementarity_mark &&
                            proof.limits->negative <= evidence::sign_mark));
}

Verdict verdict(const maneuver::Problem& problem, const Certificate& proof) {
  if (!problem.goal || !meets_goal(problem, proof) || !stationary(problem, proof)) return Verdict::not_optimal;
  const bool positive = proof.second_order && proof.second_order->positive;
  return positive && proof.kkt <= optimality::proof_mark ? Verdict::proved : Verdict::stationary;
}

}  // namespace lamprey::certificate
