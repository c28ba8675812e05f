#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

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
      lagrangian(integrator::lagrangian_of(problem_.scheme)),
      steps_known(integrator::single_step(problem_.scheme) && solution_.divided.steps == 0 &&
                  solution_.marched_by.empty()) {
  for (std::size_t k = 0; k < solution.control.size(); ++k)
    control.push_back(mechanics::moments_of_applied(system, solution.rotation[k], solution.control[k]));
}

bool periodic(const StoredMotion& motion) { return motion.problem.goal && motion.problem.goal->periodic; }

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

integrator::State stored_state(const StoredMotion& motion, int k) {
  const maneuver::Solution& stored = motion.solution;
  const mechanics::Rotations& R = stored.rotation[at(k)];
  return integrator::state_of_velocity(motion.system, R, stored.position[at(k)],
                                       mechanics::velocity_of_bodies(motion.system, R, stored.angular_velocity[at(k)],
                                                                     R[0] * stored.linear_velocity[at(k)]));
}

StepMomenta step_momenta(const StoredMotion& motion, int k) {
  const model::System& system = motion.system;
  mechanics::Interval interval(system.body_count());
  mechanics::DiscreteMomenta momenta(system.body_count());
  read_interval(motion, k, interval);
  mechanics::discrete_momenta(system, motion.lagrangian, motion.time_step, interval, momenta);
  StepMomenta result;
  mechanics::pack(system, momenta.minus, momenta.linear, result.minus);
  mechanics::pack(system, momenta.plus, momenta.linear, result.plus);
  if (system.only_free_joints()) return result;
  mechanics::JointMoments minus(system.body_count()), plus(system.body_count());
  mechanics::damping_momenta(system, interval, minus, plus);
  result.minus += mechanics::gathered(system, interval.rotation, minus);
  result.plus -= mechanics::gathered(system, interval.next_rotation, plus);
  return result;
}

std::vector<integrator::State> node_states(const StoredMotion& motion) {
  const double h = motion.time_step;
  std::vector<integrator::State> states;
  StepMomenta momenta;
  for (int k = 0; k <= motion.steps; ++k) {
    const mechanics::Rotations& R = motion.solution.rotation[at(k)];
    const VectorXd U = mechanics::generalized_force(motion.system, R, motion.control[at(k)]);
    const bool last = k == motion.steps;
    if (!last) momenta = step_momenta(motion, k);  // at the end those of the last step serve
    states.push_back({R, motion.solution.position[at(k)],
                      last ? VectorXd(momenta.plus + 0.5 * h * U) : VectorXd(momenta.minus - 0.5 * h * U)});
  }
  return states;
}

mechanics::Rotations turned_along(const model::System& system, const mechanics::Rotations& R, const VectorXd& along) {
  mechanics::Interval interval(system.body_count());
  interval.rotation = R;
  interval.displacement.setZero();
  for (int i = 0; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    const auto own = along.segment(body.velocity_offset, body.freedoms);
    interval.cayley[at(i)].setZero();
    interval.joint_turn[at(i)].setZero();
    if (body.freedoms == 3)
      interval.cayley[at(i)] = lie::inverse_cayley(lie::exp(own));
    else
      interval.joint_turn[at(i)].head(body.freedoms) = own;
  }
  mechanics::update_interval(system, interval);
  return interval.next_rotation;
}

mechanics::Rotations with_turn(const model::System& system, const mechanics::Rotations& R, int body, int freedom,
                               double by) {
  mechanics::Interval interval(system.body_count());
  interval.rotation = R;
  for (Eigen::Vector3d& v : interval.cayley) v.setZero();
  for (Eigen::Vector3d& v : interval.joint_turn) v.setZero();
  interval.displacement.setZero();
  if (system.body(body).freedoms == 3)
    interval.cayley[model::at(body)][freedom] = std::tan(0.5 * by);
  else
    interval.joint_turn[model::at(body)][freedom] = by;
  mechanics::update_interval(system, interval);
  return interval.next_rotation;
}

}  // namespace lamprey::evidence
