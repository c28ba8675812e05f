#include "evidence/balance.hpp"

#include "evidence/joints_at_rest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lie/so3.hpp"

namespace lamprey::evidence {

namespace {

using model::at;

constexpr double last_digits = 16.0;     // of a product of two rotations, times a body's inertia, and of sums of such
constexpr double most_round_off = 1e-8;  // of the scale: beyond, steps are too short for the motion

double rotation_drift(const maneuver::Solution& solution) {
  Largest drift;
  for (const auto& rotations : solution.rotation)
    for (const Matrix3d& R : rotations) {
      const Matrix3d missing = R.transpose() * R - Matrix3d::Identity();
      for (double entry : missing.reshaped()) drift.add(std::abs(entry));
      drift.add(std::abs(R.determinant() - 1.0));
    }
  return drift.value();
}

// Change of total momentum since the problem's start, about where it begins: far from it round-off turns with the lever.
class Drift {
 public:
  Drift(const StoredMotion& motion, const integrator::State& start)
      : motion_(motion),
        origin_(start.position),
        total_(mechanics::spatial_momentum(motion.system, start.rotation, Vector3d::Zero(), start.momentum)) {}
  void add(int k, const VectorXd& p) {
    const maneuver::Solution& stored = motion_.solution;
    const auto here =
        mechanics::spatial_momentum(motion_.system, stored.rotation[at(k)], stored.position[at(k)] - origin_, p);
    largest_.add(motion_.system.length_unit() * (here.linear - total_.linear).norm());
    largest_.add((here.angular - total_.angular).norm());
  }
  const Largest& largest() const { return largest_; }

 private:
  const StoredMotion& motion_;
  Vector3d origin_;
  mechanics::SpatialMomentum total_;
  Largest largest_;
};

// s, of the steps of a discrete Lagrangian that a time step is made of.
double shortest_step(const StoredMotion& motion) {
  double least = 1.0;
  for (double fraction : integrator::composition(motion.problem.scheme).fractions)
    least = std::min(least, std::abs(fraction));
  return least * motion.time_step;
}

// m, from where the problem starts to the farthest place of the root.
double way_of_root(const StoredMotion& motion) {
  double way = 0.0;
  for (const Vector3d& x : motion.solution.position) way = std::max(way, (x - motion.problem.start.position).norm());
  return way;
}

// kg m², by which a last digit of each body's rotation counts, and kg m by which one of the root's position does: joints that lead their
// child compose its rotation of those before it, so that it turns along, with all that it leads; a ball joint's child is only moved.
struct TurnedByDigits {
  std::vector<double> inertia;  // [bodies]
  double mass_moment;
};

TurnedByDigits turned_by_digits(const StoredMotion& motion) {
  const model::System& system = motion.system;
  const double way = way_of_root(motion);
  TurnedByDigits turned{std::vector<double>(at(system.body_count()), 0.0), 0.0};
  for (const model::Body& body : system.bodies()) {
    double lever = system.length_unit() + way;
    for (const model::PathPoint& point : body.path) lever += point.offset.norm();
    const double mass_moment = body.mass_matrix.norm() * lever;
    turned.mass_moment += mass_moment;
    double led = body.inertia_matrix.norm(), arm = 0.0;  // of what turns along with the body on the path
    for (auto point = body.path.rbegin(); point != body.path.rend(); ++point) {
      arm += point->offset.norm();
      turned.inertia[at(point->body)] += led + mass_moment * arm;
      const int joint = system.body(point->body).joint;
      if (joint >= 0 && system.joint(joint).free()) led = arm = 0.0;
    }
  }
  return turned;
}

// Stored rotations and positions, these so far from the origin, end at their last digit: over a step that is a momentum, each digit's its
// own (equation 6.22).
double momentum_of_last_digit(const StoredMotion& motion, double distance) {
  const TurnedByDigits turned = turned_by_digits(motion);
  double squares = std::pow(turned.mass_moment * distance, 2);
  for (double inertia : turned.inertia) squares += inertia * inertia;
  return std::numeric_limits<double>::epsilon() * std::sqrt(squares) / shortest_step(motion);
}

double momentum_of_last_digits(const StoredMotion& motion, double distance) {
  return last_digits * momentum_of_last_digit(motion, distance);
}

// Of moments that a step's momenta ask for, a share of the largest.
double moment_of_last_digit(const StoredMotion& motion, double distance) {
  Largest moment;
  for (const auto& node : motion.control)
    for (const Vector3d& u : node) moment.add(u.norm());
  return momentum_of_last_digit(motion, distance) / (shortest_step(motion) * moment.value());
}

double farthest_from_origin(const StoredMotion& motion) {
  double distance = 0.0;
  for (const Vector3d& x : motion.solution.position) distance = std::max(distance, x.norm());
  return distance;
}

// Where nothing but round-off moves, the scale of the slowest motion that the steps could tell from rest, were the origin near: a
// motion that is only too far from it is none of these.
double scale_of(const StoredMotion& motion, const Largest& momenta) {
  const double digits = momentum_of_last_digits(motion, 0.0);
  return momenta.value() > digits ? momenta.value() : digits / most_round_off;
}

VectorXd force(const StoredMotion& motion, int k) {
  return mechanics::generalized_force(motion.system, motion.solution.rotation[at(k)], motion.control[at(k)]);
}

// Momentum along the freedoms with which a motion begins: a periodic one's is that of its end.
VectorXd first_momentum(const StoredMotion& motion, const integrator::State& start) {
  if (!periodic(motion)) return start.momentum;
  return step_momenta(motion, motion.steps - 1).plus + 0.5 * motion.time_step * force(motion, motion.steps);
}

Balance check_steps(const StoredMotion& motion, const integrator::State& start) {
  const model::System& system = motion.system;
  const double h = motion.time_step;
  Drift drift(motion, start);
  Largest scale, residual;
  VectorXd arriving = first_momentum(motion, start);  // what E⁻_k − (impulse at the node) has to be
  for (int k = 0; k < motion.steps; ++k) {
    const StepMomenta momenta = step_momenta(motion, k);
    const VectorXd U = force(motion, k);
    residual.add(largest_part(system, momenta.minus - arriving - (k == 0 ? 0.5 : 1.0) * h * U));
    scale.add(largest_part(system, momenta.minus));
    scale.add(h * largest_part(system, U));
    drift.add(k, momenta.minus);
    arriving = momenta.plus;
  }
  const VectorXd U = force(motion, motion.steps);
  scale.add(h * largest_part(system, U));
  drift.add(motion.steps, arriving);
  Largest end_momentum;
  const bool drifts = motion.problem.goal && motion.problem.goal->joints_rest;
  VectorXd last = arriving + 0.5 * h * U;
  if (drifts) last -= momentum_at_rest(motion);
  end_momentum.add(largest_part(system, last));
  if (motion.problem.goal && motion.problem.goal->stills_joints()) residual.add(end_momentum.value());
  const double whole = scale_of(motion, scale);
  return {whole, drift.largest().relative_to(whole), residual.relative_to(whole), end_momentum.relative_to(whole)};
}

Balance check_nodes(const StoredMotion& motion, const integrator::State& start) {
  const maneuver::Solution& stored = motion.solution;
  Balance balance;
  balance.momentum_drift = unset;
  if (stored.angular_velocity.size() != stored.time.size() || stored.linear_velocity.size() != stored.time.size())
    return balance;
  Drift drift(motion, start);
  Largest scale;
  for (int k = 0; k <= motion.steps; ++k) {
    const VectorXd momentum = stored_state(motion, k).momentum;
    scale.add(largest_part(motion.system, momentum));
    scale.add(motion.time_step * largest_part(motion.system, force(motion, k)));
    drift.add(k, momentum);
  }
  balance.scale = scale_of(motion, scale);
  balance.momentum_drift = drift.largest().relative_to(balance.scale);
  return balance;
}

}  // namespace

double largest_part(const model::System& system, const VectorXd& v) {
  Largest largest;
  for (const model::Body& body : system.bodies()) largest.add(v.segment(body.velocity_offset, body.freedoms).norm());
  largest.add(system.length_unit() * v.tail<3>().norm());
  return largest.value();
}

Balance check_balance(const StoredMotion& motion) {
  const integrator::State start = start_of(motion.system, motion.problem.start);
  Balance balance = motion.steps_known ? check_steps(motion, start) : check_nodes(motion, start);
  balance.round_off =
      std::min(momentum_of_last_digits(motion, farthest_from_origin(motion)) / balance.scale, most_round_off);
  balance.moment_round_off = moment_of_last_digit(motion, farthest_from_origin(motion));
  balance.rotation_drift = rotation_drift(motion.solution);
  return balance;
}

// rad, of turns beside those of the bodies: from the stored angles, which files of early versions do not have, and from what
// joints allow that lead their child.
double joint_angle_error(const StoredMotion& motion) {
  const maneuver::Solution& stored = motion.solution;
  const bool told = !stored.joint_angle.empty();
  if (told && stored.joint_angle.size() != stored.rotation.size()) return unset;
  Largest error;
  for (std::size_t k = 0; k < stored.rotation.size(); ++k) {
    if (told && stored.joint_angle[k].size() != at(motion.system.joint_count())) return unset;
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const model::Joint& joint = motion.system.joint(j);
      const Matrix3d turn = mechanics::child_to_parent(stored.rotation[k], joint);
      const auto beside = [&](const Vector3d& angles) {
        error.add(lie::rotation_angle(mechanics::rotation_at_turn(joint, angles).transpose() * turn));
      };
      if (told) beside(stored.joint_angle[k][at(j)]);
      if (!joint.free()) beside(mechanics::joint_angles(joint, turn));
    }
  }
  return error.value();
}

double velocity_error(const StoredMotion& motion, const std::vector<integrator::State>& states, double momentum_scale) {
  const model::System& system = motion.system;
  const maneuver::Solution& stored = motion.solution;
  // of each kind the largest difference and the largest value
  std::array<Largest, 4> off, whole;
  whole[2].add(momentum_scale);
  whole[3].add(momentum_scale);
  const auto compare = [&](std::size_t kind, const std::vector<Vector3d>& told, std::size_t place,
                           const Vector3d& found) {
    whole[kind].add(found.norm());
    off[kind].add(place < told.size() ? (told[place] - found).norm() : unset);
  };
  for (std::size_t k = 0; k < states.size(); ++k) {
    const integrator::State& state = states[k];
    const VectorXd velocity = integrator::velocity_of_state(system, state);
    compare(0, stored.linear_velocity, k, state.rotation[0].transpose() * velocity.tail<3>());
    const mechanics::Vectors angular = mechanics::angular_velocities(system, state.rotation, velocity);
    for (std::size_t i = 0; i < angular.size(); ++i)
      compare(1, k < stored.angular_velocity.size() ? stored.angular_velocity[k] : angular, i, angular[i]);
    const auto total = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
    const auto bodies = mechanics::momentum_of_bodies(system, state.rotation, state.position, velocity);
    compare(2, stored.linear_momentum.bodies, k, bodies.linear);
    compare(2, stored.linear_momentum.fluid, k, total.linear - bodies.linear);
    compare(2, stored.linear_momentum.total, k, total.linear);
    compare(3, stored.angular_momentum.bodies, k, bodies.angular);
    compare(3, stored.angular_momentum.fluid, k, total.angular - bodies.angular);
    compare(3, stored.angular_momentum.total, k, total.angular);
  }
  // what moves between nodes that rest, too
  for (int k = 0; k < motion.steps; ++k) {
    whole[0].add((stored.position[at(k + 1)] - stored.position[at(k)]).norm() / motion.time_step);
    for (std::size_t i = 0; i < stored.rotation[at(k)].size(); ++i)
      whole[1].add(lie::rotation_angle(stored.rotation[at(k)][i].transpose() * stored.rotation[at(k + 1)][i]) /
                   motion.time_step);
  }
  const double size = system.size();
  const double linear = whole[0].value(), angular = whole[1].value();  // either may be next to nothing beside the other
  whole[0].add(size * angular);
  whole[1].add(linear / size);
  const double digits = last_digits * std::numeric_limits<double>::epsilon() / shortest_step(motion);
  if (whole[1].value() < digits) {  // rest
    whole[0].add(size * digits / most_round_off);
    whole[1].add(digits / most_round_off);
  }
  Largest error;
  for (std::size_t kind = 0; kind < off.size(); ++kind)
    if (off[kind].value() > 0.0) error.add(off[kind].relative_to(whole[kind].value()));
  if (stored.angular_velocity.size() != states.size()) error.add(unset);
  error.add(joint_angle_error(motion));
  return error.value();
}

}  // namespace lamprey::evidence
