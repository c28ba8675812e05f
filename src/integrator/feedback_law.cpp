#include "integrator/feedback_law.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "mechanics/joint_moments.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::integrator {

namespace {

using model::at;
using model::Body;
using model::System;

// The interval of rising times that holds t, and where in it: 0 … 1.
struct Place {
  std::size_t interval;
  double fraction;
};

Place place_of(const std::vector<double>& times, double t) {
  if (times.size() < 2) return {0, 0.0};
  const auto after = std::upper_bound(times.begin() + 1, times.end() - 1, t);
  const auto interval = static_cast<std::size_t>(after - times.begin()) - 1;
  const double begin = times[interval], end = times[interval + 1];
  return {interval, std::clamp((t - begin) / (end - begin), 0.0, 1.0)};
}

// Cubic from 0 to `change` with slopes at both ends, per unit of τ.
template <typename Vector>
struct Cubic {
  Vector slope, change, slope_next;
  Vector value(double t) const {
    return (t * (1.0 - t) * (1.0 - t)) * slope + (t * t * (3.0 - 2.0 * t)) * change - (t * t * (1.0 - t)) * slope_next;
  }
  Vector rate(double t) const {
    return ((1.0 - t) * (1.0 - 3.0 * t)) * slope + (6.0 * t * (1.0 - t)) * change + (t * (3.0 * t - 2.0)) * slope_next;
  }
};

Vector3d angles_of(const System& system, const Rotations& R, int body) {
  const model::Joint& joint = system.joint(system.body(body).joint);
  return mechanics::joint_angles(joint, mechanics::child_to_parent(R, joint));
}

// Change of a led body's joint angles from one configuration to another, the shorter way round.
Vector3d angle_change(const System& system, const Rotations& from, const Rotations& to, int body) {
  const model::Joint& joint = system.joint(system.body(body).joint);
  return mechanics::turn_between(joint, mechanics::child_to_parent(from, joint), mechanics::child_to_parent(to, joint));
}

// A body's freedoms in a generalised vector, [3]; entries beyond are 0.
Vector3d freedoms_in(const Body& body, const VectorXd& generalized) {
  Vector3d freedoms = Vector3d::Zero();
  for (int f = 0; f < body.freedoms; ++f) freedoms[f] = generalized[body.velocity_offset + f];
  return freedoms;
}

void put_freedoms(const Body& body, const Vector3d& freedoms, VectorXd& generalized) {
  for (int f = 0; f < body.freedoms; ++f) generalized[body.velocity_offset + f] = freedoms[f];
}

}  // namespace

MotionPath::MotionPath(const System& system, NodeMotion motion) : system_(system), motion_(std::move(motion)) {}

ReferenceState MotionPath::at_time(double time) const {
  const auto [k, t] = place_of(motion_.time, time);
  if (t == 0.0) return motion_.state[k];
  if (t == 1.0) return motion_.state[k + 1];
  const ReferenceState& from = motion_.state[k];
  const ReferenceState& to = motion_.state[k + 1];
  const double h = motion_.time[k + 1] - motion_.time[k];
  ReferenceState state = from;
  for (int i : system_.root_to_leaves()) {
    const Body& body = system_.body(i);
    const Vector3d rate = freedoms_in(body, from.velocity), rate_next = freedoms_in(body, to.velocity);
    if (body.freedoms == 3) {
      const Vector3d turn = lie::log(from.rotation[at(i)].transpose() * to.rotation[at(i)]);
      const Cubic<Vector3d> cubic{h * rate, turn, h * (lie::log_tangent(turn) * rate_next)};
      const Vector3d reached = cubic.value(t);
      state.rotation[at(i)] = from.rotation[at(i)] * lie::exp(reached);
      put_freedoms(body, lie::exp_tangent(reached) * cubic.rate(t) / h, state.velocity);
      continue;
    }
    const Cubic<Vector3d> cubic{h * rate, angle_change(system_, from.rotation, to.rotation, i), h * rate_next};
    const Vector3d angles = angles_of(system_, from.rotation, i) + cubic.value(t);
    state.rotation[at(i)] =
        state.rotation[at(body.parent)] * mechanics::joint_rotation(system_.joint(body.joint), angles);
    put_freedoms(body, cubic.rate(t) / h, state.velocity);
  }
  const Cubic<Vector3d> way{h * from.velocity.tail<3>(), to.position - from.position, h * to.velocity.tail<3>()};
  state.position = from.position + way.value(t);
  state.velocity.tail<3>() = way.rate(t) / h;
  return state;
}

VectorXd deviation(const System& system, const ReferenceState& from, const ReferenceState& state) {
  const int half = system.velocity_count();
  VectorXd off(half);
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    put_freedoms(body,
                 body.freedoms == 3  ? lie::log(from.rotation[at(i)].transpose() * state.rotation[at(i)])
                 : body.freedoms > 0 ? angle_change(system, from.rotation, state.rotation, i)
                                     : Vector3d(Vector3d::Zero()),
                 off);
  }
  off.tail<3>() = state.position - from.position;
  VectorXd both(2 * half);
  both << off, state.velocity - from.velocity;
  return both;
}

FeedbackLaw::FeedbackLaw(MotionPath path, ControlFunction planned, std::vector<double> gain_time,
                         std::vector<MatrixXd> gain)
    : path_(std::move(path)), planned_(std::move(planned)), gain_time_(std::move(gain_time)), gain_(std::move(gain)) {}

MatrixXd FeedbackLaw::gain(double time) const {
  const auto [k, t] = place_of(gain_time_, time);
  if (t == 0.0) return gain_[k];
  MatrixXd between = (1.0 - t) * gain_[k];
  algebra::add_multiple(t, gain_[k + 1], between);
  return between;
}

Moments FeedbackLaw::moments(double time, const ReferenceState& state) const {
  const System& system = path_.system();
  const VectorXd answer = gain(time) * deviation(system, path_.at_time(time), state);
  Moments u = planned_(time);
  const Moments answered = mechanics::joint_moments(system, answer);
  for (std::size_t j = 0; j < u.size(); ++j) u[j] += answered[j];
  return u;
}

Moments exerted(const System& system, Moments u) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const auto& actuation = system.joint(j).actuation;
    u[at(j)] = (actuation * (actuation.transpose() * u[at(j)])).eval();
  }
  return u;
}

Moments settled_moments(const System& system, const StateControl& controller, const MotorFunction& given, double time,
                        double h, const Moments& used, State& state) {
  std::vector<Moments> unit;  // along each column of actuation
  for (int j = 0; j < system.joint_count(); ++j)
    for (Eigen::Index c = 0; c < system.joint(j).actuation.cols(); ++c) {
      unit.emplace_back(at(system.joint_count()), Vector3d::Zero());
      unit.back()[at(j)] = system.joint(j).actuation.col(c);
    }
  const auto controls = static_cast<Eigen::Index>(unit.size());
  const auto along = [&](const Moments& u) {
    VectorXd value(controls);
    for (Eigen::Index c = 0; c < controls; ++c) {
      value[c] = 0.0;
      for (std::size_t j = 0; j < u.size(); ++j) value[c] += unit[static_cast<std::size_t>(c)][j].dot(u[j]);
    }
    return value;
  };
  const auto asked = [&](const VectorXd& momentum) {
    const VectorXd velocity = mechanics::velocity_of_momentum(system, state.rotation, momentum);
    return along(controller(time, {state.rotation, state.position, velocity}));
  };
  const Moments none(at(system.joint_count()), Vector3d::Zero());
  const VectorXd springs = mechanics::generalized_force(system, state.rotation, none);
  const VectorXd first = asked(state.momentum);
  MatrixXd impulse(system.velocity_count(), controls), answer(controls, controls);
  for (Eigen::Index c = 0; c < controls; ++c) {
    impulse.col(c) =
        0.5 * h * (mechanics::generalized_force(system, state.rotation, unit[static_cast<std::size_t>(c)]) - springs);
    answer.col(c) = asked(state.momentum + impulse.col(c)) - first;
  }
  // change v of the moments: used + v = asked(μ + impulse v)
  const VectorXd before = along(used);
  const VectorXd change = (MatrixXd::Identity(controls, controls) - answer).partialPivLu().solve(first - before);
  Moments u(at(system.joint_count()), Vector3d::Zero());
  for (Eigen::Index c = 0; c < controls; ++c)
    for (std::size_t j = 0; j < u.size(); ++j) u[j] += (before[c] + change[c]) * unit[static_cast<std::size_t>(c)][j];
  if (given) u = given(u);
  state.momentum += impulse * (along(u) - before);
  return u;
}

}  // namespace lamprey::integrator
