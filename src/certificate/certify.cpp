#include "certificate/certify.hpp"

#include "certificate/balance.hpp"
#include "certificate/clearance.hpp"
#include "certificate/goal_check.hpp"
#include "certificate/limit_check.hpp"
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
  proof.clearance = clearance(motion);
  proof.momentum_drift = balance.momentum_drift;
  proof.equation_residual = balance.equation_residual;
  if (!problem.goal || solution.status == maneuver::Status::simulated) return proof;

  proof.goal_error = goal_error(motion);
  if (!motion.steps_known) return proof;
  proof.rest_error = balance.end_momentum;
  const ControlSpace space = control_space(motion);
  proof.control_error = space.outside;
  if (problem.limits.any() || problem.duration.free || !problem.waypoints.empty()) {
    const LimitCheck kept = check_limits(motion);
    proof.limits = {kept.violation, kept.key, kept.time, kept.complementarity, kept.negative};
  }
  if (options.optimality) proof.kkt = kkt_residual(motion, space, balance.scale);
  if (options.replay) proof.replay = replay(motion, options.replay_window, options.replay_tolerance);
  return proof;
}

}  // namespace lamprey::certificate
