#include "certificate/certify.hpp"

#include "certificate/balance.hpp"
#include "certificate/goal_check.hpp"
#include "certificate/optimality.hpp"
#include "certificate/replay.hpp"

namespace lamprey::certificate {

Certificate certify(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                    const Options& options) {
  Certificate proof;
  if (solution.time.size() < 2) return proof;
  const StoredMotion motion(system, problem, solution);
  const Balance balance = check_balance(motion);
  proof.rotation_drift = balance.rotation_drift;
  proof.start_error = start_error(motion);
  proof.momentum_drift = balance.momentum_drift;
  proof.equation_residual = balance.equation_residual;
  if (!problem.goal || solution.status == maneuver::Status::simulated) return proof;

  if (!problem.goal->periodic) proof.goal_error = goal_error(motion);
  if (!motion.steps_known) return proof;
  proof.rest_error = balance.end_momentum;
  const ControlSpace space = control_space(motion);
  proof.control_error = space.outside;
  const bool equalities_only = !problem.goal->periodic && !problem.limits.any() && !problem.duration.free;
  if (options.optimality && equalities_only) proof.kkt = kkt_residual(motion, space, balance.scale);
  if (options.replay) proof.replay = replay(motion, options.replay_window, options.replay_tolerance);
  return proof;
}

void certify_feedback(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                      Certificate& certificate, const Options& options) {
  if (certificate.replay)
    replay_with_feedback(StoredMotion(system, problem, solution), options.replay_tolerance, *certificate.replay);
}

}  // namespace lamprey::certificate
