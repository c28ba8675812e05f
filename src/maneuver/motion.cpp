#include "maneuver/motion.hpp"

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

}  // namespace

mechanics::Moments joint_moments(const System& system, const VectorXd& control) {
  mechanics::Moments u(at(system.joint_count()));
  Eigen::Index column = 0;
  for (int j = 0; j < system.joint_count(); ++j) {
    const auto& actuation = system.joint(j).actuation;
    u[at(j)] = actuation * control.segment(column, actuation.cols());
    column += actuation.cols();
  }
  return u;
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
    const mechanics::Moments u = joint_moments(system, path.control[at(k)]);
    if (k < steps) {
      const Vector3d displacement = path.position[at(k + 1)] - path.position[at(k)];
      if (system.only_free_joints()) {  // ζ as found carries more digits than rotations do
        interval.rotation = path.rotation[at(k)];
        interval.cayley = path.cayley[at(k)];
        interval.displacement = displacement;
        mechanics::update_interval(system, interval);
      } else {
        mechanics::interval_between(system, path.rotation[at(k)], path.rotation[at(k + 1)], displacement, interval);
      }
    }
    // μ_k = E⁻ of the step that begins here, μ_N = E⁺ of the last
    evaluate_balance({system, lagrangian, time_step, interval, u, u}, balance);
    integrator::State state{path.rotation[at(k)], path.position[at(k)], VectorXd()};
    state.momentum = stacked(system, k < steps ? balance.minus : balance.plus, balance.linear);
    append_node(system, k * time_step, state, u, solution);
  }
}

double cost_of(const VectorXd& node_weight, const std::vector<Vectors>& control) {
  double cost = 0.0;
  for (std::size_t k = 0; k < control.size(); ++k)
    for (const Vector3d& u : control[k]) cost += 0.5 * node_weight[static_cast<Eigen::Index>(k)] * u.squaredNorm();
  return cost;
}

}  // namespace lamprey::maneuver
