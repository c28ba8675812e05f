#include "mechanics/discrete_lagrangian.hpp"

#include <cmath>

namespace lamprey::mechanics {

namespace {

using model::at;
using model::Body;
using model::Joint;
using model::JointKind;
using model::System;

// Cayley vector of cayley(a) cayley(b).
Vector3d composed(const Vector3d& a, const Vector3d& b) { return (a + b + a.cross(b)) / (1.0 - a.dot(b)); }

// ζ of a body that its joint leads: F_c = Qᵀ F_p exp(Δθ_1 â) Q exp(Δθ b̂).
Vector3d led_cayley(const Joint& joint, const Matrix3d& R_parent, const Matrix3d& R_child,
                    const Vector3d& parent_cayley, const Vector3d& joint_turn) {
  const bool universal = joint.kind == JointKind::universal;
  const Vector3d turned_parent =
      universal ? composed(parent_cayley, std::tan(0.5 * joint_turn[0]) * joint.parent_axis) : parent_cayley;
  const Vector3d seen = R_child.transpose() * (R_parent * turned_parent);
  if (joint.kind == JointKind::fixed) return seen;
  return composed(seen, std::tan(0.5 * joint_turn[universal ? 1 : 0]) * joint.child_axis);
}

// rad, to (−π, π].
double wrapped(double angle) { return angle - 2.0 * M_PI * std::ceil((angle - M_PI) / (2.0 * M_PI)); }

}  // namespace

Interval::Interval(int bodies)
    : rotation(at(bodies), Matrix3d::Identity()),
      cayley(at(bodies), Vector3d::Zero()),
      joint_turn(at(bodies), Vector3d::Zero()),
      displacement(Vector3d::Zero()),
      relative_rotation(at(bodies)),
      relative_rotation_minus_identity(at(bodies)),
      next_rotation(at(bodies)),
      centre_displacement(at(bodies)) {}

DiscreteMomenta::DiscreteMomenta(int bodies)
    : minus(at(bodies)),
      plus(at(bodies)),
      subtree_linear(at(bodies)),
      shift(at(bodies)),
      turn(at(bodies)),
      impulse(at(bodies)),
      joint_minus(at(bodies)),
      joint_plus(at(bodies)) {}

void update_interval(const System& system, Interval& step) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.freedoms < 3)
      step.cayley[at(i)] = led_cayley(system.joint(body.joint), step.rotation[at(body.parent)], step.rotation[at(i)],
                                      step.cayley[at(body.parent)], step.joint_turn[at(i)]);
    step.relative_rotation_minus_identity[at(i)] = lie::cayley_minus_identity(step.cayley[at(i)]);
    step.relative_rotation[at(i)] = Matrix3d::Identity() + step.relative_rotation_minus_identity[at(i)];
    step.next_rotation[at(i)] = step.rotation[at(i)] * step.relative_rotation[at(i)];
    if (body.parent < 0) {
      step.centre_displacement[at(i)] = step.displacement;
      continue;
    }
    const Joint& up = system.joint(body.joint);
    step.centre_displacement[at(i)] =
        step.centre_displacement[at(up.parent)] +
        step.rotation[at(up.parent)] * (step.relative_rotation_minus_identity[at(up.parent)] * up.parent_offset) -
        step.rotation[at(i)] * (step.relative_rotation_minus_identity[at(i)] * up.child_offset);
  }
}

void interval_between(const System& system, const Rotations& rotation, const Rotations& next_rotation,
                      const Vector3d& displacement, Interval& step) {
  step.rotation = rotation;
  step.displacement = displacement;
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    step.joint_turn[at(i)].setZero();
    if (body.freedoms == 3) {
      step.cayley[at(i)] = lie::inverse_cayley(rotation[at(i)].transpose() * next_rotation[at(i)]);
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const auto angles = [&](const Rotations& R) {
      return joint_angles(joint, R[at(body.parent)].transpose() * R[at(i)]);
    };
    step.joint_turn[at(i)] = (angles(next_rotation) - angles(rotation)).unaryExpr(&wrapped);
  }
  update_interval(system, step);
}

double discrete_lagrangian(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step) {
  double value = 0.0;
  for (int i = 0; i < system.body_count(); ++i)
    value += BodyLagrangian(system, lagrangian, h, i)
                 .value({step.relative_rotation[at(i)], step.relative_rotation_minus_identity[at(i)],
                         step.cayley[at(i)], step.rotation[at(i)].transpose() * step.centre_displacement[at(i)]});
  return value;
}

BodyStep body_step(const Interval& step, const DiscreteMomenta& momenta, int i) {
  return {step.relative_rotation[at(i)], step.relative_rotation_minus_identity[at(i)], step.cayley[at(i)],
          momenta.shift[at(i)]};
}

void body_momenta(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                  DiscreteMomenta& momenta) {
  for (int i = 0; i < system.body_count(); ++i) {
    const Matrix3d& R = step.rotation[at(i)];
    momenta.shift[at(i)] = R.transpose() * step.centre_displacement[at(i)];
    const BodyGradient own = BodyLagrangian(system, lagrangian, h, i).gradient(body_step(step, momenta, i));
    momenta.turn[at(i)] = own.turn;
    momenta.impulse[at(i)] = own.shift;
    momenta.subtree_linear[at(i)] = R * own.shift;
  }
  sum_subtrees(system, momenta.subtree_linear);
  momenta.linear = momenta.subtree_linear[0];
}

void momenta_at_beginning(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                          DiscreteMomenta& momenta) {
  body_momenta(system, lagrangian, h, step, momenta);
  for (std::size_t i = 0; i < momenta.turn.size(); ++i)
    momenta.joint_minus[i] = step.relative_rotation[i] * momenta.turn[i] + momenta.shift[i].cross(momenta.impulse[i]);
  gather(system, step.rotation, momenta.subtree_linear, momenta.joint_minus, momenta.minus);
}

void momenta_at_end(const System& system, const Interval& step, DiscreteMomenta& momenta) {
  momenta.joint_plus = momenta.turn;
  gather(system, step.next_rotation, momenta.subtree_linear, momenta.joint_plus, momenta.plus);
}

void discrete_momenta(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                      DiscreteMomenta& momenta) {
  momenta_at_beginning(system, lagrangian, h, step, momenta);
  momenta_at_end(system, step, momenta);
}

}  // namespace lamprey::mechanics
