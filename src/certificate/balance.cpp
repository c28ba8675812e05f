#include "certificate/balance.hpp"

namespace lamprey::certificate {

namespace {

using model::at;

// Largest 3-vector of a generalised vector.
double largest_part(const VectorXd& v) {
  Largest largest;
  for (Eigen::Index part = 0; part < v.size(); part += 3) largest.add(v.segment<3>(part).norm());
  return largest.value();
}

VectorXd generalized(const model::System& system, const mechanics::Freedoms& freedoms, const Vector3d& linear) {
  VectorXd v;
  mechanics::pack(system, freedoms, linear, v);
  return v;
}

double rotation_drift(const maneuver::Solution& solution) {
  Largest drift;
  for (const auto& rotations : solution.rotation)
    for (const Matrix3d& R : rotations)
      for (double entry : (R.transpose() * R - Matrix3d::Identity()).reshaped()) drift.add(std::abs(entry));
  return drift.value();
}

}  // namespace

Balance check_balance(const StoredMotion& motion) {
  const model::System& system = motion.system;
  const double h = motion.time_step;
  const integrator::State start = start_of(system, motion.problem.start);
  const auto total = mechanics::spatial_momentum(system, start.rotation, start.position, start.momentum);
  Largest scale, drift, residual;
  const auto add_drift = [&](int k, const VectorXd& p) {
    const auto here = mechanics::spatial_momentum(system, motion.solution.rotation[at(k)], motion.solution.position[at(k)], p);
    drift.add((here.linear - total.linear).norm());
    drift.add((here.angular - total.angular).norm());
  };
  const auto force = [&](int k) {
    return mechanics::generalized_force(system, motion.solution.rotation[at(k)], motion.control[at(k)]);
  };

  mechanics::Interval interval(system.body_count());
  mechanics::DiscreteMomenta momenta(system.body_count());
  VectorXd arriving = start.momentum;  // what p⁻_k − (impulse at the node) has to be
  for (int k = 0; k < motion.steps; ++k) {
    read_interval(motion, k, interval);
    mechanics::discrete_momenta(system, motion.lagrangian, h, interval, momenta);
    const VectorXd minus = generalized(system, momenta.minus, momenta.linear);
    const VectorXd U = force(k);
    residual.add(largest_part(minus - arriving - (k == 0 ? 0.5 : 1.0) * h * U));
    scale.add(largest_part(minus));
    scale.add(h * largest_part(U));
    add_drift(k, minus);
    arriving = generalized(system, momenta.plus, momenta.linear);
  }
  const VectorXd U = force(motion.steps);
  const VectorXd end = arriving + 0.5 * h * U;
  scale.add(h * largest_part(U));
  add_drift(motion.steps, arriving);
  Largest end_momentum;
  end_momentum.add(largest_part(end));
  if (motion.problem.goal && motion.problem.goal->rest) residual.add(end_momentum.value());
  return {scale.value(), drift.relative_to(scale.value()), residual.relative_to(scale.value()),
          end_momentum.relative_to(scale.value()), rotation_drift(motion.solution)};
}

}  // namespace lamprey::certificate
