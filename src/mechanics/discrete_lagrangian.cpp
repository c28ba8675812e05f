#include "mechanics/discrete_lagrangian.hpp"

#include <cmath>
#include <numbers>

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

// F − I, F and R' of all bodies from their Cayley vectors: F − I = 2/(1 + |ζ|²) (ζ̂ + ζζᵀ − |ζ|² I).
void turn_bodies(Interval& step) {
  for_each_four(step.cayley.size(), [&](const FourBodies& four) {
    const Four3 zeta = four.read(step.cayley);
    const Four square = dot(zeta, zeta);
    const Four factor = 2.0 / (1.0 + square);
    const Four3 z = factor * zeta;
    const Four33 turned = plus_hat(minus_diagonal(dyad(z, zeta), factor * square), z);
    const Four33 F = plus_identity(turned);
    four.write(turned, step.relative_rotation_minus_identity);
    four.write(F, step.relative_rotation);
    four.write(four.read(step.rotation) * F, step.next_rotation);
  });
}

// ζ of all bodies from their rotations at both nodes: 2 vee(F)/(1 + tr F), but for turns towards a half turn.
void cayley_between(const Rotations& rotation, const Rotations& next_rotation, Vectors& cayley) {
  for_each_four(cayley.size(), [&](const FourBodies& four) {
    const Four33 F = transposed(four.read(rotation)) * four.read(next_rotation);
    const Four trace_F = trace(F);
    four.write((1.0 / (1.0 + trace_F)) * Four3{F.y.z - F.z.y, F.z.x - F.x.z, F.x.y - F.y.x}, cayley);
    for (std::size_t l = 0; l < 4; ++l)
      if (const std::size_t n = four.body(l); !(trace_F[l] > 0.0))
        cayley[n] = lie::inverse_cayley(rotation[n].transpose() * next_rotation[n]);
  });
}

void four_momenta(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                  const FourBodies& four, DiscreteMomenta& momenta) {
  const FourShares shares(system, lagrangian, h, step, four);
  const Four3 zeta = four.read(step.cayley);
  const Four3 w = transposed(shares.R) * four.read(step.centre_displacement);
  const TurnAndShift<Four3> translation = shares.with_shift(w).translation_gradient();
  // 2 vee(J_d (F − I)) = 2/(1 + |ζ|²) (Jζ + Jζ × ζ), J = tr(J_d) I − J_d
  const Four3 spin = trace(shares.trace_weight) * zeta - shares.trace_weight * zeta;
  const Four factor = 2.0 / (1.0 + dot(zeta, zeta));
  const Four3 turn = shares.rate * (factor * (spin + cross(spin, zeta)) + translation.turn);
  const Four3 impulse = shares.rate * translation.shift;
  four.write(w, momenta.shift);
  four.write(turn, momenta.turn);
  four.write(impulse, momenta.impulse);
  four.write(shares.F * turn + cross(w, impulse), momenta.own_minus);
  four.write(shares.R * impulse, momenta.subtree_linear);
}

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
      own_minus(at(bodies)),
      joint_minus(at(bodies)),
      joint_plus(at(bodies)) {}

void update_interval(const System& system, Interval& step) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.freedoms < 3)
      step.cayley[at(i)] = led_cayley(system.joint(body.joint), step.rotation[at(body.parent)], step.rotation[at(i)],
                                      step.cayley[at(body.parent)], step.joint_turn[at(i)]);
  }
  turn_bodies(step);
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
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
  cayley_between(rotation, next_rotation, step.cayley);
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    step.joint_turn[at(i)].setZero();
    if (body.freedoms == 3) continue;
    const Joint& joint = system.joint(body.joint);
    const auto angles = [&](const Rotations& R) {
      return joint_angles(joint, R[at(body.parent)].transpose() * R[at(i)]);
    };
    step.joint_turn[at(i)] = (angles(next_rotation) - angles(rotation)).unaryExpr(&lie::shorter_way);
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

bool all_plain(const System& system, DiscreteLagrangian lagrangian) {
  const Quadrature weights = quadrature(lagrangian);
  return !system.coupled() && !weights.trace_form && weights.middle == 0.0;
}

FourShares::FourShares(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                       const FourBodies& four)
    : mass(four.read(system.bodies(), &Body::mass_matrix)),
      trace_weight(four.read(system.bodies(), &Body::trace_weight)),
      R(four.read(step.rotation)),
      F(four.read(step.relative_rotation)),
      weights(quadrature(lagrangian)),
      rate(1.0 / h) {}

BodyStep body_step(const Interval& step, const DiscreteMomenta& momenta, int i) {
  return {step.relative_rotation[at(i)], step.relative_rotation_minus_identity[at(i)], step.cayley[at(i)],
          momenta.shift[at(i)]};
}

void body_momenta(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                  DiscreteMomenta& momenta) {
  if (all_plain(system, lagrangian)) {
    for_each_four(momenta.turn.size(),
                  [&](const FourBodies& four) { four_momenta(system, lagrangian, h, step, four, momenta); });
  } else {
    for (int i = 0; i < system.body_count(); ++i) {
      const std::size_t n = at(i);
      const Matrix3d& R = step.rotation[n];
      momenta.shift[n] = R.transpose() * step.centre_displacement[n];
      const BodyGradient own = BodyLagrangian(system, lagrangian, h, i).gradient(body_step(step, momenta, i));
      momenta.turn[n] = own.turn;
      momenta.impulse[n] = own.shift;
      momenta.own_minus[n] = step.relative_rotation[n] * own.turn + momenta.shift[n].cross(own.shift);
      momenta.subtree_linear[n] = R * own.shift;
    }
  }
  sum_subtrees(system, momenta.subtree_linear);
  momenta.linear = momenta.subtree_linear[0];
}

void momenta_at_beginning(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                          DiscreteMomenta& momenta) {
  body_momenta(system, lagrangian, h, step, momenta);
  momenta.joint_minus = momenta.own_minus;
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
