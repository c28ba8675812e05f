#include "maneuver/motion.hpp"

#include "maneuver/step_polynomial.hpp"
#include "mechanics/joint_moments.hpp"
#include "mechanics/step_balance.hpp"

namespace lamprey::maneuver {

namespace {

using model::System;

using model::at;

// Generalised momentum of momenta along the freedoms and p_x.
VectorXd stacked(const System& system, const mechanics::Freedoms& momenta, const Vector3d& linear) {
  VectorXd momentum;
  mechanics::pack(system, momenta, linear, momentum);
  return momentum;
}

// From node k to the next.
void read_interval(const System& system, const NodePath& path, int k, mechanics::Interval& interval) {
  const Vector3d displacement = path.position[at(k + 1)] - path.position[at(k)];
  if (!system.only_free_joints()) {
    mechanics::interval_between(system, path.rotation[at(k)], path.rotation[at(k + 1)], displacement, interval);
    return;
  }
  // ζ as found carries more digits than rotations do
  interval.rotation = path.rotation[at(k)];
  interval.cayley = path.cayley[at(k)];
  interval.displacement = displacement;
  mechanics::update_interval(system, interval);
}

}  // namespace

void append_joint_angles(const System& system, const mechanics::Rotations& R, std::vector<Vectors>& joint_angle) {
  const Vectors before = joint_angle.empty() ? Vectors(at(system.joint_count()), Vector3d::Zero()) : joint_angle.back();
  Vectors now;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    now.push_back(mechanics::turn_from_zero(joint, mechanics::child_to_parent(R, joint), before[at(j)]));
  }
  joint_angle.push_back(std::move(now));
}

void append_node(const System& system, double time, const integrator::State& state, const mechanics::Moments& control,
                 Solution& solution) {
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  const auto total = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
  const auto bodies = mechanics::momentum_of_bodies(system, state.rotation, state.position, velocity);
  const Vectors angular = mechanics::angular_velocities(system, state.rotation, velocity);
  solution.time.push_back(time);
  solution.position.push_back(state.position);
  solution.rotation.push_back(state.rotation);
  solution.control.push_back(mechanics::applied_moments(system, state.rotation, control));
  append_joint_angles(system, state.rotation, solution.joint_angle);
  solution.linear_velocity.push_back(state.rotation[0].transpose() * velocity.tail<3>());
  solution.angular_velocity.push_back(angular);
  solution.linear_momentum.bodies.push_back(bodies.linear);
  solution.linear_momentum.fluid.push_back(total.linear - bodies.linear);
  solution.linear_momentum.total.push_back(total.linear);
  solution.angular_momentum.bodies.push_back(bodies.angular);
  solution.angular_momentum.fluid.push_back(total.angular - bodies.angular);
  solution.angular_momentum.total.push_back(total.angular);
}

void describe_motion(const System& system, mechanics::DiscreteLagrangian lagrangian, double time_step,
                     const NodePath& path, Solution& solution) {
  const int steps = static_cast<int>(path.cayley.size());
  mechanics::Interval interval(system.body_count());
  mechanics::StepBalance balance(system.body_count());
  for (int k = 0; k <= steps; ++k) {
    const mechanics::Moments u = mechanics::joint_moments(system, path.control[at(k)]);
    if (k < steps) read_interval(system, path, k, interval);
    // μ_k = E⁻ of the step that begins here, μ_N = E⁺ of the last
    evaluate_balance({system, lagrangian, time_step, interval, u, u}, balance);
    integrator::State state{path.rotation[at(k)], path.position[at(k)], VectorXd()};
    state.momentum = stacked(system, k < steps ? balance.minus : balance.plus, balance.linear);
    append_node(system, k * time_step, state, u, solution);
  }
}

void describe_composed_motion(const System& system, Scheme scheme, double time_step, const NodePath& path,
                              Solution& solution) {
  const integrator::Composition& composed = integrator::composition(scheme);
  const std::vector<double> fractions = stage_fractions(scheme);
  const int stages = composed.stages(), terms = polynomial_terms(scheme);
  const int steps = static_cast<int>(path.polynomial.size());
  mechanics::Interval interval(system.body_count());
  mechanics::StepBalance balance(system.body_count());
  for (int k = 0; k <= steps; ++k) {
    const int step = std::min(k, steps - 1);
    std::vector<mechanics::Moments> moments;  // of the step's nodes
    for (double fraction : fractions)
      moments.push_back(mechanics::joint_moments(system, moments_at(path.polynomial[at(step)], fraction, terms)));
    // μ_k = E⁻ of the stage that begins here, μ_N = E⁺ of the last
    const bool last = k == steps;
    const int s = last ? stages - 1 : 0, node = step * stages + s;
    read_interval(system, path, node, interval);
    evaluate_balance({system, composed.lagrangian, composed.fractions[at(s)] * time_step, interval, moments[at(s)],
                      moments[at(s + 1)]},
                     balance);
    integrator::State state{path.rotation[at(k * stages)], path.position[at(k * stages)], VectorXd()};
    state.momentum = stacked(system, last ? balance.plus : balance.minus, balance.linear);
    append_node(system, k * time_step, state, mechanics::joint_moments(system, path.control[at(k * stages)]), solution);
    if (last) break;
    solution.stage_time.emplace_back();
    solution.control_stages.emplace_back();
    for (int n = 0; n <= stages; ++n) {
      solution.stage_time.back().push_back(n == stages ? (k + 1) * time_step
                                                       : k * time_step + fractions[at(n)] * time_step);
      solution.control_stages.back().push_back(
          mechanics::applied_moments(system, path.rotation[at(k * stages + n)], moments[at(n)]));
    }
  }
}

double cost_of_polynomials(double effort, double time_step, const std::vector<VectorXd>& polynomial) {
  double cost = 0.0;
  for (const VectorXd& coefficients : polynomial) cost += 0.5 * effort * time_step * coefficients.squaredNorm();
  return cost;
}

double cost_of(const VectorXd& node_weight, const std::vector<Vectors>& control) {
  double cost = 0.0;
  for (std::size_t k = 0; k < control.size(); ++k)
    for (const Vector3d& u : control[k]) cost += 0.5 * node_weight[static_cast<Eigen::Index>(k)] * u.squaredNorm();
  return cost;
}

}  // namespace lamprey::maneuver
