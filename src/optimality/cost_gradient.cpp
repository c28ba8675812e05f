#include "optimality/cost_gradient.hpp"

#include "integrator/step_derivatives.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::optimality {

namespace {

using mechanics::Rotations;
using model::at;
using model::System;

constexpr double turn_step = 2e-4;  // rad, of differences of order four

// Change of a drive's costs of power for each second by its power.
evidence::WorkSlopes slopes_by_power(const StoredMotion& motion, const evidence::Powers& powers, double weight,
                                     int drive, int node) {
  const evidence::WorkSlopes work = evidence::work_slopes(motion, powers, drive, node);
  const double squares = 2.0 * motion.problem.cost_weights.power;
  return {weight * work.by_value + squares * powers.value(drive, node),
          weight * work.by_change + squares / 3.0 * powers.change(drive, node)};
}

// Work and power by the moments at a node and, turns held, by the time a node counts for.
void add_powers_at_node(const StoredMotion& motion, const evidence::Powers& powers, double weight, int k,
                        CostGradient& gradient) {
  const double time = powers.time[k];
  for (int d = 0; d < motion.system.drive_count(); ++d) {
    const model::Drive& drive = motion.system.drive(d);
    const std::size_t j = at(drive.joint);
    const double value = powers.value(d, k), change = powers.change(d, k);
    const evidence::WorkSlopes own = evidence::work_slopes(motion, powers, d, k),
                               slopes = slopes_by_power(motion, powers, weight, d, k);
    const Vector3d worked = slopes.by_value * powers.rate[at(k)][j] + slopes.by_change * powers.swing[at(k)][j];
    gradient.by_control[at(k)].segment(drive.first_control, drive.controls) -=
        time * evidence::axes_of(motion.system, drive).transpose() * worked;
    // the node counts for longer, the shapes change more slowly
    const double given = k == 0 ? evidence::work_of(evidence::moment_of(motion, drive, k), 0.5 * powers.start[j]) : 0.0;
    gradient.by_log_time_step += time * (weight * (own.by_value * value + own.by_change * change) +
                                         motion.problem.cost_weights.power * (value * value + change * change / 3.0) -
                                         slopes.by_value * (value - given) - slopes.by_change * (change + given));
  }
}

void add_smoothness(const StoredMotion& motion, int step, CostGradient& gradient) {
  const double h = motion.time_step, weight = motion.problem.cost_weights.smoothness;
  if (weight == 0.0) return;
  const VectorXd change = weight / h * (evidence::moments_at(motion, step + 1) - evidence::moments_at(motion, step));
  gradient.by_control[at(step)] -= change;
  gradient.by_control[at(step + 1)] += change;
  gradient.by_log_time_step -= 0.5 * h / weight * change.squaredNorm();
}

// What pulls on the joints' turns over a step by the freedoms at its two nodes: by differences of order 4.
void add_pulls_by_shapes(const StoredMotion& motion, const evidence::Powers& powers, const mechanics::Vectors& pull,
                         int step, CostGradient& gradient) {
  const System& system = motion.system;
  const integrator::StateLayout layout{system};
  const Rotations &left = motion.solution.rotation[at(step)], &right = motion.solution.rotation[at(step + 1)];
  const auto work_at = [&](bool at_right, int body, int freedom, double by) {
    const mechanics::Vectors turns =
        at_right ? evidence::turns_between(system, left, evidence::with_turn(system, right, body, freedom, by))
                 : evidence::turns_between(system, evidence::with_turn(system, left, body, freedom, by), right);
    double sum = 0.0;
    for (std::size_t j = 0; j < turns.size(); ++j) sum += pull[j].dot(turns[j] - powers.turn[at(step)][j]);
    return sum;
  };
  for (const bool at_right : {false, true})
    for (int i = 0; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms; ++f) {
        const auto value = [&](double by) { return work_at(at_right, i, f, by); };
        gradient.by_state[at(step + (at_right ? 1 : 0))][layout.freedom(i) + f] +=
            (8.0 * (value(turn_step) - value(-turn_step)) - (value(2.0 * turn_step) - value(-2.0 * turn_step))) /
            (12.0 * turn_step);
      }
}

// What is won by displacement, and work per a free distance.
VectorXd by_last_state(const StoredMotion& motion, const evidence::Powers& powers) {
  const integrator::StateLayout layout{motion.system};
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  VectorXd gradient = VectorXd::Zero(layout.size());
  auto by_position = gradient.segment<3>(layout.position());
  by_position -= weights.displacement;
  if (weights.transport == 0.0 || motion.problem.goal->distance()) return gradient;
  double work = 0.0;
  for (int k = 0; k <= motion.steps; ++k)
    for (int d = 0; d < motion.system.drive_count(); ++d)
      work += powers.time[k] * evidence::mean_size(powers.value(d, k), powers.change(d, k));
  by_position -= weights.transport * work / std::pow(powers.distance, 3) *
                 (motion.solution.position.back() - motion.solution.position.front());
  return gradient;
}

}  // namespace

VectorXd node_weights(const StoredMotion& motion) {
  VectorXd weights = VectorXd::Constant(motion.steps + 1, motion.problem.effort * motion.time_step);
  if (motion.problem.cost_rule() == maneuver::CostRule::trapezoid) {
    weights[0] *= 0.5;
    weights[motion.steps] *= 0.5;
  }
  return weights;
}

VectorXd cost_gradient(const StoredMotion& motion, const evidence::ControlSpace& space) {
  const int controls = motion.system.control_count();
  if (space.basis.size() == 0)
    return (space.value.reshaped(controls, motion.steps + 1) * node_weights(motion).asDiagonal()).reshaped();
  const MatrixXd points = space.value.reshaped(controls, space.basis.cols());
  return (points * space.basis.transpose() * node_weights(motion).asDiagonal() * space.basis).reshaped();
}

std::vector<mechanics::Vectors> pulls_on_turns(const StoredMotion& motion, const evidence::Powers& powers) {
  const double h = motion.time_step, weight = evidence::weight_of_work(motion, powers);
  const int N = motion.steps;
  std::vector<mechanics::Vectors> pulls(at(N), mechanics::Vectors(at(motion.system.joint_count()), Vector3d::Zero()));
  const double stiff = motion.problem.cost_weights.angular_velocity / h;
  for (int k = 0; k < N && stiff > 0.0; ++k)
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const model::Axes& axes = motion.system.joint(j).actuation;
      pulls[at(k)][at(j)] = stiff * (axes * (axes.transpose() * powers.turn[at(k)][at(j)]));
    }
  for (int k = 0; k <= N; ++k)
    for (int d = 0; d < motion.system.drive_count(); ++d) {
      const model::Drive& drive = motion.system.drive(d);
      const std::size_t j = at(drive.joint);
      const evidence::WorkSlopes slopes = slopes_by_power(motion, powers, weight, d, k);
      const Vector3d pull = -powers.time[k] / (2.0 * h) * evidence::moment_of(motion, drive, k);
      const double before = slopes.by_value - slopes.by_change, after = slopes.by_value + slopes.by_change;
      if (k > 0) pulls[at(k - 1)][j] += before * pull;
      if (k < N) pulls[at(k)][j] += after * pull;
      if (evidence::periodic(motion) && k == N) pulls[0][j] += after * pull;
    }
  return pulls;
}

CostGradient cost_gradient_beside_effort(const StoredMotion& motion) {
  const int N = motion.steps;
  const evidence::Powers powers = evidence::powers_of(motion);
  CostGradient gradient;
  gradient.by_state.assign(at(N + 1), VectorXd::Zero(integrator::StateLayout{motion.system}.size()));
  gradient.by_control.assign(at(N + 1), VectorXd::Zero(motion.system.control_count()));
  const double weight = evidence::weight_of_work(motion, powers);
  for (int k = 0; k <= N; ++k) add_powers_at_node(motion, powers, weight, k, gradient);
  for (int k = 0; k < N; ++k) add_smoothness(motion, k, gradient);
  for (const mechanics::Vectors& turn : powers.turn)
    gradient.by_log_time_step -= 0.5 * motion.problem.cost_weights.angular_velocity / motion.time_step *
                                 mechanics::along_actuation(motion.system, turn).squaredNorm();
  const std::vector<mechanics::Vectors> pulls = pulls_on_turns(motion, powers);
  for (int k = 0; k < N; ++k) add_pulls_by_shapes(motion, powers, pulls[at(k)], k, gradient);
  gradient.by_state.back() += by_last_state(motion, powers);
  return gradient;
}

VectorXd gradient_of_displacement(const StoredMotion& motion) {
  return by_last_state(motion, evidence::powers_of(motion));
}

}  // namespace lamprey::optimality
