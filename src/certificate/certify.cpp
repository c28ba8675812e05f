#include "certificate/certify.hpp"

#include "certificate/balance.hpp"
#include "certificate/clearance.hpp"
#include "certificate/goal_check.hpp"
#include "certificate/limit_check.hpp"
#include "certificate/optimality.hpp"
#include "certificate/replay.hpp"
#include "certificate/stage_motion.hpp"

namespace lamprey::certificate {

namespace {

// What only the steps tell, of a scheme above order 2.
void certify_stages(const StoredMotion& motion, const Options& options, double scale, bool sought, Certificate& proof) {
  const std::optional<StageMotion> stages = march_again(motion);
  if (!stages) return;
  proof.equation_residual = step_residual(motion, *stages, scale);
  if (!sought) return;
  proof.rest_error = largest_part(motion.system, stages->node.back().momentum) / scale;
  proof.control_error = stages->control_error;
  if (options.optimality) proof.kkt = kkt_residual(motion, *stages, scale);
  if (options.replay) proof.replay = replay(motion, *stages, options.replay_window, options.replay_tolerance);
}

}  // namespace

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
  const bool sought = problem.goal && solution.status != maneuver::Status::simulated;
  if (!motion.steps_known) certify_stages(motion, options, balance.scale, sought, proof);
  if (!sought) return proof;

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
