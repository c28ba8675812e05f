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
      lagrangian(integrator::lagrangian_of(problem_.scheme)) {
  for (std::size_t k = 0; k < solution.control.size(); ++k)
    control.push_back(mechanics::moments_of_applied(system, solution.rotation[k], solution.control[k]));
}

void read_interval(const StoredMotion& motion, int k, mechanics::Interval& interval) {
  const maneuver::Solution& stored = motion.solution;
  mechanics::interval_between(motion.system, stored.rotation[at(k)], stored.rotation[at(k + 1)],
                              stored.position[at(k + 1)] - stored.position[at(k)], interval);
}

integrator::State start_of(const model::System& system, const maneuver::Start& start) {
  mechanics::Rotations rotation;
  for (const Vector3d& vector : start.rotation) rotation.push_back(lie::exp(vector));
  const VectorXd velocity =
      mechanics::velocity_of_bodies(system, rotation, start.angular_velocity, start.linear_velocity);
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
    const VectorXd U = mechanics::generalized_force(motion.system, R, motion.control[at(k)]);
    const bool last = k == motion.steps;
    if (!last) {  // at the end the momenta of the last step serve
      read_interval(motion, k, interval);
      mechanics::discrete_momenta(motion.system, motion.lagrangian, h, interval, momenta);
    }
    VectorXd mu;
    mechanics::pack(motion.system, last ? momenta.plus : momenta.minus, momenta.linear, mu);
    mu += (last ? 0.5 : -0.5) * h * U;
    states.push_back({R, motion.solution.position[at(k)], mu});
  }
  return states;
}

}  // namespace lamprey::certificate
