#include "certificate/stored_motion.hpp"

namespace lamprey::certificate {

namespace {

using model::at;

}  // namespace

StoredMotion::StoredMotion(const model::System& system_, const maneuver::Problem& problem_,
                           const maneuver::Solution& solution_)
    : system(system_),
      problem(problem_),
      solution(solution_),
      steps(static_cast<int>(solution_.time.size()) - 1),
      time_step((solution_.time.back() - solution_.time.front()) / steps),
      lagrangian(integrator::lagrangian_of(problem_.scheme)) {}

void read_interval(const StoredMotion& motion, int k, mechanics::Interval& interval) {
  const maneuver::Solution& stored = motion.solution;
  interval.rotation = stored.rotation[at(k)];
  interval.displacement = stored.position[at(k + 1)] - stored.position[at(k)];
  for (std::size_t i = 0; i < interval.cayley.size(); ++i)
    interval.cayley[i] = lie::inverse_cayley(stored.rotation[at(k)][i].transpose() * stored.rotation[at(k + 1)][i]);
  mechanics::update_interval(motion.system, interval);
}

integrator::State start_of(const model::System& system, const maneuver::Start& start) {
  mechanics::Rotations rotation;
  VectorXd velocity(system.velocity_count());
  for (int i = 0; i < system.body_count(); ++i) {
    rotation.push_back(lie::exp(start.rotation[at(i)]));
    velocity.segment<3>(3 * i) = start.angular_velocity[at(i)];
  }
  velocity.tail<3>() = start.linear_velocity;
  return integrator::state_of_velocity(system, rotation, start.position, velocity);
}

std::vector<integrator::State> node_states(const StoredMotion& motion) {
  const int bodies = motion.system.body_count();
  const double h = motion.time_step;
  mechanics::Interval interval(bodies);
  mechanics::DiscreteMomenta momenta(bodies);
  std::vector<integrator::State> states;
  for (int k = 0; k <= motion.steps; ++k) {
    const mechanics::Rotations& R = motion.solution.rotation[at(k)];
    const VectorXd U = mechanics::generalized_force(motion.system, R, motion.solution.control[at(k)]);
    const bool last = k == motion.steps;
    if (!last) {  // at the end the momenta of the last step serve
      read_interval(motion, k, interval);
      mechanics::discrete_momenta(motion.system, motion.lagrangian, h, interval, momenta);
    }
    VectorXd mu(motion.system.velocity_count());
    for (int i = 0; i < bodies; ++i) mu.segment<3>(3 * i) = last ? momenta.plus[at(i)] : momenta.minus[at(i)];
    mu.tail<3>() = momenta.linear;
    mu += (last ? 0.5 : -0.5) * h * U;
    states.push_back({R, motion.solution.position[at(k)], mu});
  }
  return states;
}

}  // namespace lamprey::certificate
