#include "certificate/certify.hpp"

#include <limits>

#include "certificate/replay.hpp"
#include "certificate/untold_steps.hpp"
#include "certificate/verdict.hpp"
#include "evidence/balance.hpp"
#include "evidence/clearance.hpp"
#include "evidence/cost_check.hpp"
#include "evidence/goal_check.hpp"
#include "evidence/limit_check.hpp"
#include "evidence/stage_motion.hpp"
#include "optimality/first_order.hpp"
#include "optimality/second_order.hpp"

namespace lamprey::certificate {

namespace {

bool confined(const model::System& system, const model::Joint& joint) {
  return joint.actuation.cols() > 0 && joint.actuation.cols() < system.body(joint.child).freedoms;
}

// Above order 2, and of moments on splines, nothing but effort and time is checked.
bool covered(const maneuver::Problem& problem) {
  if (integrator::single_step(problem.scheme) && problem.control == maneuver::ControlKind::steps) return true;
  return !problem.limits.any() && problem.waypoints.empty() && !problem.duration.free && !problem.goal->periodic &&
         !problem.cost_weights.any() && !problem.cost_weights.of_displacement();
}

constexpr double reference_drift = 1e-9;  // of the scale, that the reference integrator's tolerance may leave

// Where the problem's duration is free it is that of the files, which its bounds judge.
double time_error(const StoredMotion& motion) {
  const std::vector<double>& time = motion.solution.time;
  const maneuver::Duration& asked = motion.problem.duration;
  const double duration = asked.free ? time.back() : asked.value;
  evidence::Largest error;
  for (int k = 0; k <= motion.steps; ++k) error.add(std::abs(time[model::at(k)] - duration * k / motion.steps));
  return duration > 0.0 ? error.value() / duration : std::numeric_limits<double>::infinity();
}

double relative_difference(double stored, double recomputed) {
  return std::abs(stored - recomputed) / std::max(std::abs(recomputed), 1e-300);
}

// Work per distance where there is none, and what files did not tell before it could cost.
bool may_be_untold(double maneuver::CostParts::*part, const maneuver::CostParts& recomputed) {
  return part == &maneuver::CostParts::angular_velocity || !std::isfinite(recomputed.*part);
}

// Largest relative difference of stored parts of the cost that are told.
double parts_difference(const maneuver::CostParts& stored, const maneuver::CostParts& recomputed) {
  double largest = 0.0;
  for (double maneuver::CostParts::*part :
       {&maneuver::CostParts::effort, &maneuver::CostParts::work, &maneuver::CostParts::power,
        &maneuver::CostParts::smoothness, &maneuver::CostParts::angular_velocity, &maneuver::CostParts::time,
        &maneuver::CostParts::transport})
    if (stored.*part != recomputed.*part && !(std::isnan(stored.*part) && may_be_untold(part, recomputed)))
      largest = std::max(largest, relative_difference(stored.*part, recomputed.*part));
  return largest;
}

// By the limit's key; of keep-outs the one that is reached most.
std::map<std::string, double> shares_at_limits(const evidence::LimitCheck& kept) {
  std::map<std::string, double> shares;
  for (const evidence::LimitReach& reach : kept.reaches)
    if (reach.reached()) shares[reach.key] = std::max(shares[reach.key], reach.share);
  return shares;
}

// Largest of the iterates; NaN where one was not measured, or there is none.
double iterates_momentum(const maneuver::SolverRecord& solver) {
  if (solver.history.empty()) return unset;
  double largest = 0.0;
  for (const maneuver::SolverIteration& iterate : solver.history) {
    if (std::isnan(iterate.momentum)) return unset;
    largest = std::max(largest, iterate.momentum);
  }
  return largest;
}

// By the moments at the nodes or the coefficients of the steps. Where nothing is spent goal and limits pull at nothing, and what is left is
// the effort's own.
std::optional<optimality::SecondOrder> curvature(const StoredMotion& motion, const std::optional<StageMotion>& stages,
                                                 double momentum_scale, double kkt) {
  if (evidence::costs_nothing(motion)) return optimality::SecondOrder{1.0, true, 0, true};
  if (stages) return optimality::second_order(motion, *stages, momentum_scale);
  return motion.steps_known ? optimality::second_order(motion, momentum_scale, kkt) : std::nullopt;
}

// The problem with all that confined joints leave free; nothing where none is confined, limits may name their axes, or the work has
// multipliers of other drives.
std::optional<maneuver::Problem> with_all_axes(const model::System& system, const maneuver::Problem& problem) {
  if (problem.limits.any()) return std::nullopt;
  maneuver::Problem free = problem;
  bool any = false;
  for (int j = 0; j < system.joint_count(); ++j)
    if (confined(system, system.joint(j))) {
      free.swimmer.joints[model::at(j)].control_axes.reset();
      any = true;
    }
  const bool works = problem.cost_weights.work > 0.0 || problem.cost_weights.transport > 0.0;
  if (!any || (works && model::System(free.swimmer).drive_count() != system.drive_count())) return std::nullopt;
  return free;
}

// The second-order test of that problem.
optimality::AllAxes all_axes(const maneuver::Problem& free, const maneuver::Solution& solution, double momentum_scale,
                             double kkt_round_off) {
  const model::System free_system(free.swimmer);
  const StoredMotion motion(free_system, free, solution);
  const std::optional<StageMotion> stages = evidence::march_again(motion);
  optimality::AllAxes result;
  result.kkt = stages ? optimality::kkt_residual(motion, *stages, momentum_scale)
                      : optimality::kkt_residual(motion, evidence::control_space(motion), momentum_scale);
  if (result.kkt <= std::max(free.search.tolerance, kkt_round_off))
    result.second_order = curvature(motion, stages, momentum_scale, result.kkt).value_or(optimality::SecondOrder());
  return result;
}

// What only the steps tell, of a motion by a scheme above order 2.
void certify_stages(const StoredMotion& motion, const StageMotion& stages, double scale, Certificate& proof) {
  proof.equation_residual = evidence::step_residual(motion, stages, scale);
  proof.control_error = stages.actuation_error;
  proof.time_error = std::max(proof.time_error, stages.time_error / motion.solution.time.back());
  proof.velocity_error = evidence::velocity_error(motion, stages.node, scale);
}

// A march, which nobody sought: the law of its steps, and what it tells of them.
void certify_march(const StoredMotion& motion, double scale, Certificate& proof) {
  if (motion.steps_known) {
    proof.control_error = evidence::beyond_actuation(motion);
    proof.velocity_error = evidence::velocity_error(motion, evidence::node_states(motion), scale);
  } else if (const std::optional<StageMotion> stages = evidence::check_march(motion)) {
    certify_stages(motion, *stages, scale, proof);
  } else {
    proof.beyond_moments = beyond_moments(motion, scale);
  }
}

// An answer by a scheme above order 2.
void certify_sought_stages(const StoredMotion& motion, const Options& options, double scale, Certificate& proof) {
  const std::optional<StageMotion> stages = evidence::march_again(motion);
  if (!stages) return;
  certify_stages(motion, *stages, scale, proof);
  proof.control_error = std::max(proof.control_error, stages->polynomial_error);
  proof.rest_error = evidence::largest_part(motion.system, stages->node.back().momentum) / scale;
  proof.cost_error = evidence::cost_error(motion, evidence::cost_of_steps(motion, *stages));
  if (options.optimality) proof.kkt = optimality::kkt_residual(motion, *stages, scale);
  if (options.replay) proof.replay = replay(motion, *stages, {options.replay_tolerance, options.stopped});
}

}  // namespace

Certificate certify(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                    const Options& asked) {
  Certificate proof;
  if (solution.time.size() < 2) return proof;
  const StoredMotion motion(system, problem, solution);
  const evidence::Balance balance = evidence::check_balance(motion);
  proof.rotation_drift = balance.rotation_drift;
  proof.start_error = evidence::start_error(motion);
  proof.clearance = evidence::clearance(motion);
  proof.momentum_drift = balance.momentum_drift;
  proof.momentum_round_off = balance.round_off;
  const bool sought = problem.goal && solution.status != maneuver::Status::simulated;
  if (!sought && !solution.marched_by.empty())
    proof.momentum_round_off = std::max(proof.momentum_round_off, reference_drift);
  proof.equation_residual = balance.equation_residual;
  Options options = asked;
  if (sought && !covered(problem)) options.optimality = options.second_order = false;
  proof.time_error = time_error(motion);
  if (!sought) {
    certify_march(motion, balance.scale, proof);
    return proof;
  }

  proof.iterates_momentum = iterates_momentum(solution.solver);
  const evidence::GoalMiss miss = evidence::largest_miss(motion);
  proof.goal_error = miss.error;
  proof.goal_missed = miss.condition;
  proof.goal_missed_by_turn = miss.is_turn;
  proof.verdict = Verdict::not_optimal;
  if (!motion.steps_known) {
    certify_sought_stages(motion, options, balance.scale, proof);
    proof.verdict = verdict(problem, proof);
    if (options.second_order) add_second_order(system, problem, solution, proof);
    return proof;
  }
  proof.rest_error = balance.end_momentum;
  const evidence::ControlSpace space = evidence::control_space(motion);
  proof.control_error = space.outside;
  if (problem.limits.any() || problem.duration.free || !problem.waypoints.empty()) {
    const evidence::LimitCheck kept = evidence::check_limits(motion);
    proof.limits = {kept.violation, kept.key, kept.time, kept.complementarity, kept.negative, shares_at_limits(kept)};
  }
  const evidence::CostCheck cost = evidence::check_cost(motion);
  proof.velocity_error = evidence::velocity_error(motion, evidence::node_states(motion), balance.scale);
  proof.cost_error = evidence::cost_error(motion, cost.cost);
  if (solution.cost_parts)
    proof.cost_error = std::max(proof.cost_error, parts_difference(*solution.cost_parts, cost.parts));
  if (problem.cost_weights.any()) proof.costs = {proof.cost_error, cost.signs};
  const bool worth_it = options.of_misses || meets_goal(problem, proof);
  if (options.optimality && worth_it) proof.kkt = optimality::kkt_residual(motion, space, balance.scale);
  proof.kkt_round_off =
      std::min(optimality::round_off_of_kkt(motion, space, balance.moment_round_off), optimality::proof_mark);
  proof.verdict = verdict(problem, proof);
  if (options.second_order) add_second_order(system, problem, solution, proof);
  if (options.replay) proof.replay = replay(motion, {options.replay_tolerance, options.stopped});
  return proof;
}

bool add_second_order(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                      Certificate& proof, const std::function<bool()>& stopped) {
  if (!problem.goal || verdict(problem, proof) == Verdict::not_optimal) return true;
  const StoredMotion motion(system, problem, solution);
  const double scale = evidence::check_balance(motion).scale;
  proof.second_order = curvature(motion, evidence::march_again(motion), scale, proof.kkt);
  proof.verdict = verdict(problem, proof);
  const std::optional<maneuver::Problem> free = with_all_axes(system, problem);
  if (!free) return true;
  if (stopped && stopped()) return false;
  proof.all_axes = all_axes(*free, solution, scale, proof.kkt_round_off);
  return true;
}

std::optional<Replay> certify_replay(const model::System& system, const maneuver::Problem& problem,
                                     const maneuver::Solution& solution, const Options& options) {
  if (solution.time.size() < 2) return std::nullopt;
  const StoredMotion motion(system, problem, solution);
  const ReplayOptions within{options.replay_tolerance, options.stopped};
  if (motion.steps_known) return replay(motion, within);
  const std::optional<StageMotion> stages = evidence::march_again(motion);
  return stages ? std::optional(replay(motion, *stages, within)) : std::nullopt;
}

void certify_feedback(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
                      Replay& result, const Options& options) {
  const StoredMotion motion(system, problem, solution);
  const ReplayOptions within{options.replay_tolerance, options.stopped};
  if (motion.steps_known)
    replay_with_feedback(motion, within, result);
  else if (const std::optional<StageMotion> stages = evidence::march_again(motion))
    replay_with_feedback(motion, *stages, within, result);
}

}  // namespace lamprey::certificate
