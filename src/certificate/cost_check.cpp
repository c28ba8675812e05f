#include "certificate/cost_check.hpp"

#include "certificate/gait_ends.hpp"
#include "integrator/step_derivatives.hpp"
#include "mechanics/continuous.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::certificate {

namespace {

using mechanics::Rotations;
using model::at;
using model::Joint;
using model::System;

constexpr double turn_step = 2e-4;  // rad, of differences of order four

// Work that moments do: they act on the parent, their opposites on the child.
double work_of(const Vector3d& moment, const Vector3d& turn) { return -moment.dot(turn); }

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

// [joints]
mechanics::Vectors turns_between(const System& system, const Rotations& left, const Rotations& right) {
  mechanics::Vectors turns;
  for (const Joint& joint : system.joints()) turns.push_back(turn_between(joint, left, right));
  return turns;
}

// Change of a joint's cost of power for each second by its power.
double slope_by_power(const StoredMotion& motion, const Powers& powers, double weight, int joint, int node) {
  const double power = powers.value(joint, node);
  return weight * sign_multiplier(motion, joint, node, power) + 2.0 * motion.problem.cost_weights.power * power;
}

}  // namespace

Vector3d turn_between(const Joint& joint, const Rotations& left, const Rotations& right) {
  const Matrix3d Q = mechanics::child_to_parent(left, joint), Q_next = mechanics::child_to_parent(right, joint);
  if (joint.free()) return Q * lie::log(Q.transpose() * Q_next);
  Vector3d turn = mechanics::joint_angles(joint, Q_next) - mechanics::joint_angles(joint, Q);
  for (double& angle : turn) angle = std::remainder(angle, 2.0 * std::acos(-1.0));
  return turn;
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
  const mechanics::Vectors start = periodic(motion) ? still : rates_of(system, start_of(system, motion.problem.start));
  for (int k = 0; k <= N; ++k)
    for (std::size_t j = 0; j < still.size(); ++j) {
      Vector3d& rate = powers.rate[at(k)][j];
      if (k > 0) rate += powers.turn[at(k - 1)][j] / (2.0 * h);
      if (k < N) rate += powers.turn[at(k)][j] / (2.0 * h);
      if (periodic(motion) && k == N) rate += powers.turn[0][j] / (2.0 * h);
      if (k == 0) rate += 0.5 * start[j];
    }
  powers.start.push_back(start);
  powers.value.resize(system.joint_count(), N + 1);
  for (int k = 0; k <= N; ++k)
    for (int j = 0; j < system.joint_count(); ++j)
      powers.value(j, k) = work_of(motion.control[at(k)][at(j)], powers.rate[at(k)][at(j)]);
  powers.distance = (motion.solution.position.back() - motion.solution.position.front()).norm();
  return powers;
}

double sign_multiplier(const StoredMotion& motion, int joint, int node, double power) {
  const auto& stored = motion.solution.work_multipliers;
  if (stored.size() == at(motion.system.joint_count()) && stored[at(joint)].size() == at(motion.steps + 1))
    return stored[at(joint)][at(node)];
  return power < 0.0 ? -1.0 : 1.0;
}

double weight_of_work(const StoredMotion& motion, const Powers& powers) {
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  if (weights.transport == 0.0) return weights.work;
  return weights.work + weights.transport / motion.problem.goal->distance().value_or(powers.distance);
}

VectorXd moments_at(const StoredMotion& motion, int node) {
  return mechanics::along_actuation(motion.system, motion.control[at(node)]);
}

std::vector<mechanics::Vectors> pulls_on_turns(const StoredMotion& motion, const Powers& powers) {
  const double h = motion.time_step, weight = weight_of_work(motion, powers);
  const int N = motion.steps;
  std::vector<mechanics::Vectors> pulls(at(N), mechanics::Vectors(at(motion.system.joint_count()), Vector3d::Zero()));
  for (int k = 0; k <= N; ++k)
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const double slope = slope_by_power(motion, powers, weight, j, k);
      const Vector3d pull = -powers.time[k] * slope / (2.0 * h) * motion.control[at(k)][at(j)];
      if (k > 0) pulls[at(k - 1)][at(j)] += pull;
      if (k < N) pulls[at(k)][at(j)] += pull;
      if (periodic(motion) && k == N) pulls[0][at(j)] += pull;
    }
  return pulls;
}

double won(const StoredMotion& motion) {
  return motion.problem.cost_weights.displacement.dot(motion.solution.position.back() -
                                                      motion.solution.position.front());
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
    for (double power : powers.value.col(k)) {
      check.parts.work += powers.time[k] * std::abs(power);
      check.parts.power += powers.time[k] * power * power;
    }
    if (k < motion.steps)
      check.parts.smoothness +=
          0.5 * (moments_at(motion, k + 1) - moments_at(motion, k)).squaredNorm() / motion.time_step;
  }
  check.parts.time = motion.time_step * motion.steps;
  check.parts.transport = check.parts.work / powers.distance;
  const double weight = weight_of_work(motion, powers);
  const double spent = problem.effort * check.parts.effort + problem.time_weight * check.parts.time +
                       weight * check.parts.work + weights.power * check.parts.power +
                       weights.smoothness * check.parts.smoothness;
  check.cost = spent - won(motion);
  const double rate = std::max(spent, 1e-300) / check.parts.time;
  for (int k = periodic(motion) ? 1 : 0; k <= motion.steps; ++k)
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const double power = powers.value(j, k), sign = sign_multiplier(motion, j, k, power);
      check.signs = std::max({check.signs, weight * (std::abs(power) - sign * power) / rate, std::abs(sign) - 1.0});
    }
  return check;
}

CostGradient cost_gradient_beside_effort(const StoredMotion& motion) {
  const System& system = motion.system;
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  const integrator::StateLayout layout{system};
  const Powers powers = powers_of(motion);
  const double h = motion.time_step, weight = weight_of_work(motion, powers);
  const int N = motion.steps;
  CostGradient gradient;
  gradient.by_state.assign(at(N + 1), VectorXd::Zero(layout.size()));
  gradient.by_control.assign(at(N + 1), VectorXd::Zero(system.control_count()));
  const std::vector<mechanics::Vectors> by_turn = pulls_on_turns(motion, powers);
  double work = 0.0;
  for (int k = 0; k <= N; ++k) {
    for (int j = 0; j < system.joint_count(); ++j) {
      const double power = powers.value(j, k), time = powers.time[k];
      const double slope = slope_by_power(motion, powers, weight, j, k);
      const Vector3d& u = motion.control[at(k)][at(j)];
      work += time * std::abs(power);
      const model::Joint& joint = system.joint(j);
      gradient.by_control[at(k)].segment(joint.first_control, joint.actuation.cols()) -=
          time * slope * joint.actuation.transpose() * powers.rate[at(k)][at(j)];
      // the node counts for longer, the shapes change more slowly
      const double given = k == 0 ? work_of(u, 0.5 * powers.start[0][at(j)]) : 0.0;
      gradient.by_log_time_step += time * (weight * sign_multiplier(motion, j, k, power) * power +
                                           weights.power * power * power - slope * (power - given));
    }
    if (k == N) break;
    const VectorXd change = weights.smoothness / h * (moments_at(motion, k + 1) - moments_at(motion, k));
    gradient.by_control[at(k)] -= change;
    gradient.by_control[at(k + 1)] += change;
    if (weights.smoothness > 0.0) gradient.by_log_time_step -= 0.5 * h / weights.smoothness * change.squaredNorm();
  }
  for (int k = 0; k < N; ++k)
    for (const bool right : {false, true})
      for (int i = 0; i < system.body_count(); ++i)
        for (int f = 0; f < system.body(i).freedoms; ++f) {
          const auto value = [&](double by) {
            const Rotations& left_rotation = motion.solution.rotation[at(k)];
            const Rotations& right_rotation = motion.solution.rotation[at(k + 1)];
            const mechanics::Vectors turns =
                right ? turns_between(system, left_rotation, with_turn(system, right_rotation, i, f, by))
                      : turns_between(system, with_turn(system, left_rotation, i, f, by), right_rotation);
            double sum = 0.0;
            for (std::size_t j = 0; j < turns.size(); ++j)
              sum += by_turn[at(k)][j].dot(turns[j] - powers.turn[at(k)][j]);
            return sum;
          };
          gradient.by_state[at(k + (right ? 1 : 0))][layout.freedom(i) + f] +=
              (8.0 * (value(turn_step) - value(-turn_step)) - (value(2.0 * turn_step) - value(-2.0 * turn_step))) /
              (12.0 * turn_step);
        }
  gradient.by_state.back().segment<3>(layout.position()) -= weights.displacement;
  if (weights.transport > 0.0 && !motion.problem.goal->distance()) {
    const double d = powers.distance;
    gradient.by_state.back().segment<3>(layout.position()) -=
        weights.transport * work / (d * d * d) * (motion.solution.position.back() - motion.solution.position.front());
  }
  return gradient;
}

}  // namespace lamprey::certificate
