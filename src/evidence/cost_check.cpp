#include "evidence/cost_check.hpp"

#include "evidence/control_space.hpp"
#include "evidence/limit_margin.hpp"
#include "mechanics/continuous.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::evidence {

namespace {

using mechanics::Rotations;
using model::at;
using model::Joint;
using model::System;

constexpr double digits_of_sums = 4.0;  // in which sums may differ
constexpr int halvings = 60;            // of an interval of slopes
constexpr double least_worth = 1e-5;  // of the cost, of all the duration at what its bound's multiplier makes a second
constexpr double least_power = 1e-9;  // of the swimmer's largest, that a drive's is measured by

// Rates of the joints in a state, as turns_between counts. [joints]
mechanics::Vectors rates_of(const System& system, const integrator::State& state) {
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  const mechanics::Vectors angular = mechanics::angular_velocities(system, state.rotation, velocity);
  mechanics::Vectors rates(at(system.joint_count()), Vector3d::Zero());
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.free()) {
      rates[at(j)] =
          mechanics::child_to_parent(state.rotation, joint) * angular[at(joint.child)] - angular[at(joint.parent)];
    } else {
      const model::Body& child = system.body(joint.child);
      rates[at(j)].head(child.freedoms) = velocity.segment(child.velocity_offset, child.freedoms);
    }
  }
  return rates;
}

double cost_of_duration(const StoredMotion& motion) {
  return motion.problem.time_weight * motion.time_step * motion.steps;
}

// Where on the edge by_change = (1 − by_value²)/2 the slopes are that are nearest to others beyond it, both of them positive.
WorkSlopes nearest_on_edge(const WorkSlopes& beyond) {
  double low = 0.0, high = 1.0;
  for (int n = 0; n < halvings; ++n) {
    const double middle = 0.5 * (low + high), edge = 0.5 * (1.0 - middle * middle);
    const double farther = middle - beyond.by_value - middle * (edge - beyond.by_change);
    (farther > 0.0 ? high : low) = middle;
  }
  return {low, 0.5 * (1.0 - low * low)};
}

// Of all slopes that mean_size can have those nearest to given ones.
WorkSlopes nearest_slopes(const WorkSlopes& given) {
  if (room_of(given) >= 0.0) return given;
  const WorkSlopes edge = nearest_on_edge({std::abs(given.by_value), std::abs(given.by_change)});
  return {std::copysign(edge.by_value, given.by_value), std::copysign(edge.by_change, given.by_change)};
}

// How far a power is from what slopes of the work belong to, of the joint's largest power (equation 13.13).
double misfit(const WorkSlopes& slopes, double value, double change, double largest) {
  const WorkSlopes pulled{slopes.by_value + value / largest, slopes.by_change + change / largest};
  const WorkSlopes fitting = nearest_slopes(pulled);
  return std::hypot(fitting.by_value - slopes.by_value, fitting.by_change - slopes.by_change);
}

}  // namespace

Vector3d turn_between(const Joint& joint, const Rotations& left, const Rotations& right) {
  const Matrix3d Q = mechanics::child_to_parent(left, joint), Q_next = mechanics::child_to_parent(right, joint);
  if (joint.free()) return Q * lie::log(Q.transpose() * Q_next);
  Vector3d turn = mechanics::joint_angles(joint, Q_next) - mechanics::joint_angles(joint, Q);
  for (double& angle : turn) angle = std::remainder(angle, 2.0 * std::acos(-1.0));
  return turn;
}

mechanics::Vectors turns_between(const System& system, const Rotations& left, const Rotations& right) {
  mechanics::Vectors turns;
  for (const Joint& joint : system.joints()) turns.push_back(turn_between(joint, left, right));
  return turns;
}

Powers powers_of(const StoredMotion& motion) {
  const System& system = motion.system;
  const std::vector<Rotations>& R = motion.solution.rotation;
  const double h = motion.time_step;
  const int N = motion.steps;
  Powers powers;
  powers.time = VectorXd::Constant(N + 1, h);
  powers.time[0] = periodic(motion) ? 0.0 : 0.5 * h;
  if (!periodic(motion)) powers.time[N] = 0.5 * h;
  for (int k = 0; k < N; ++k) powers.turn.push_back(turns_between(system, R[at(k)], R[at(k + 1)]));
  const mechanics::Vectors still(at(system.joint_count()), Vector3d::Zero());
  powers.rate.assign(at(N + 1), still);
  powers.swing.assign(at(N + 1), still);
  const mechanics::Vectors start = periodic(motion) ? still : rates_of(system, start_of(system, motion.problem.start));
  for (int k = 0; k <= N; ++k)
    for (std::size_t j = 0; j < still.size(); ++j) {
      Vector3d before = Vector3d::Zero(), after = Vector3d::Zero();
      if (k > 0) before = powers.turn[at(k - 1)][j] / h;
      if (k == 0) before = start[j];
      if (k < N) after = powers.turn[at(k)][j] / h;
      if (periodic(motion) && k == N) after = powers.turn[0][j] / h;
      powers.rate[at(k)][j] = 0.5 * (before + after);
      powers.swing[at(k)][j] = 0.5 * (after - before);
    }
  powers.start = start;
  powers.value.resize(system.drive_count(), N + 1);
  powers.change.resize(system.drive_count(), N + 1);
  for (int k = 0; k <= N; ++k)
    for (int d = 0; d < system.drive_count(); ++d) {
      const model::Drive& drive = system.drive(d);
      const Vector3d moment = moment_of(motion, drive, k);
      powers.value(d, k) = work_of(moment, powers.rate[at(k)][at(drive.joint)]);
      powers.change(d, k) = work_of(moment, powers.swing[at(k)][at(drive.joint)]);
    }
  powers.distance = (motion.solution.position.back() - motion.solution.position.front()).norm();
  return powers;
}

VectorXd largest_powers(const StoredMotion& motion, const Powers& powers) {
  const int first = periodic(motion) ? 1 : 0;
  const VectorXd largest = powers.value.rightCols(motion.steps + 1 - first).cwiseAbs().rowwise().maxCoeff();
  return largest.cwiseMax(std::max(least_power * largest.maxCoeff(), 1e-300));
}

double mean_size(double value, double change) {
  const double before = value - change, after = value + change;
  if (before * after >= 0.0) return std::abs(value);
  return (before * before + after * after) / (2.0 * std::abs(after - before));
}

double room_of(const WorkSlopes& slopes) {
  return 0.5 * (1.0 - slopes.by_value * slopes.by_value) - std::abs(slopes.by_change);
}

WorkSlopes work_slopes(const StoredMotion& motion, const Powers& powers, int drive, int node) {
  const auto stored = [&](const std::vector<std::vector<double>>& all) -> std::optional<double> {
    if (all.size() != at(motion.system.drive_count()) || all[at(drive)].size() != at(motion.steps + 1)) return {};
    return all[at(drive)][at(node)];
  };
  if (const auto by_value = stored(motion.solution.work_multipliers))
    return {*by_value, stored(motion.solution.work_change_multipliers).value_or(0.0)};
  const double value = powers.value(drive, node), change = powers.change(drive, node);
  if (std::abs(value) >= std::abs(change)) return {value == 0.0 ? 0.0 : std::copysign(1.0, value), 0.0};
  const double part = value / change;
  return {std::copysign(part, value), 0.5 * std::copysign(1.0 - part * part, change)};
}

double weight_of_work(const StoredMotion& motion, const Powers& powers) {
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  if (weights.transport == 0.0) return weights.work;
  return weights.work + weights.transport / motion.problem.goal->distance().value_or(powers.distance);
}

double won(const StoredMotion& motion) {
  return motion.problem.cost_weights.displacement.dot(motion.solution.position.back() -
                                                      motion.solution.position.front());
}

double cost_error(const StoredMotion& motion, double recomputed) {
  const double given = cost_of_duration(motion) - cost_of_free_duration(motion);
  const double digits = digits_of_sums * std::numeric_limits<double>::epsilon() * given;
  const double difference = std::abs(motion.solution.cost - recomputed) - digits;
  return std::max(difference, 0.0) / std::max(std::abs(spent(motion, recomputed)), 1e-300);
}

bool duration_holds(const StoredMotion& motion) {
  for (const Bound& bound : bounds_of(motion)) {
    if (bound.kind != Bound::Kind::duration) continue;
    const std::vector<double>* multipliers = multipliers_of(motion, bound);
    if (!multipliers) continue;
    const double duration = motion.time_step * motion.steps;
    const bool there = std::abs(margin(motion, bound, place_of(motion, motion.steps))) <= at_the_bound * duration;
    if (there && multipliers->back() * duration > least_worth * std::abs(check_cost(motion).cost + won(motion)))
      return true;
  }
  return false;
}

double cost_of_free_duration(const StoredMotion& motion) {
  return motion.problem.duration.free && !duration_holds(motion) ? cost_of_duration(motion) : 0.0;
}

double spent(const StoredMotion& motion, double cost) {
  return cost + won(motion) - cost_of_duration(motion) + cost_of_free_duration(motion);
}

double spent_rate(const StoredMotion& motion) {
  if (motion.solution.limit_multipliers.empty()) return 0.0;
  const double duration = motion.time_step * motion.steps;
  const double of_time = duration_holds(motion) ? motion.problem.time_weight * duration : 0.0;
  return std::abs(spent(motion, check_cost(motion).cost) + of_time) / duration;
}

bool costs_nothing(const StoredMotion& motion) {
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  if (weights.of_displacement() || weights.angular_velocity > 0.0 || cost_of_free_duration(motion) > 0.0) return false;
  const auto none = [](const mechanics::Vectors& moments) {
    return std::all_of(moments.begin(), moments.end(), [](const Vector3d& u) { return u.isZero(0.0); });
  };
  const maneuver::Solution& stored = motion.solution;
  return motion.problem.effort > 0.0 && std::all_of(stored.control.begin(), stored.control.end(), none) &&
         std::all_of(stored.control_stages.begin(), stored.control_stages.end(),
                     [&](const auto& step) { return std::all_of(step.begin(), step.end(), none); });
}

CostCheck check_cost(const StoredMotion& motion) {
  const maneuver::Problem& problem = motion.problem;
  const maneuver::CostWeights& weights = problem.cost_weights;
  const Powers powers = powers_of(motion);
  CostCheck check;
  const bool halves = problem.cost_rule() == maneuver::CostRule::trapezoid;
  for (int k = 0; k <= motion.steps; ++k) {
    const double end = halves && (k == 0 || k == motion.steps) ? 0.5 : 1.0;
    check.parts.effort += 0.5 * end * motion.time_step * moments_at(motion, k).squaredNorm();
    for (int d = 0; d < motion.system.drive_count(); ++d) {
      const double value = powers.value(d, k), change = powers.change(d, k);
      check.parts.work += powers.time[k] * mean_size(value, change);
      check.parts.power += powers.time[k] * (value * value + change * change / 3.0);
    }
    if (k < motion.steps) {
      check.parts.smoothness +=
          0.5 * (moments_at(motion, k + 1) - moments_at(motion, k)).squaredNorm() / motion.time_step;
      check.parts.angular_velocity +=
          0.5 * mechanics::along_actuation(motion.system, powers.turn[at(k)]).squaredNorm() / motion.time_step;
    }
  }
  check.parts.time = motion.time_step * motion.steps;
  check.parts.transport = maneuver::work_per_distance(check.parts.work, powers.distance, motion.system.length_unit());
  const double weight = weight_of_work(motion, powers);
  check.cost = problem.effort * check.parts.effort + problem.time_weight * check.parts.time +
               weight * check.parts.work + weights.power * check.parts.power +
               weights.smoothness * check.parts.smoothness + weights.angular_velocity * check.parts.angular_velocity -
               won(motion);
  if (weight == 0.0) return check;
  const VectorXd largest = largest_powers(motion, powers);
  for (int k = periodic(motion) ? 1 : 0; k <= motion.steps; ++k)
    for (int d = 0; d < motion.system.drive_count(); ++d)
      check.signs = std::max(
          check.signs, misfit(work_slopes(motion, powers, d, k), powers.value(d, k), powers.change(d, k), largest[d]));
  return check;
}

}  // namespace lamprey::evidence
