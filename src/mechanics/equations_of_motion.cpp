#include "mechanics/equations_of_motion.hpp"

#include <limits>

namespace lamprey::mechanics {

namespace {

using model::at;
using model::Body;
using model::Joint;
using model::System;

// Rates of the bodies' momenta where ξ̇ = 0 as forces (world) and moments (body frames); turn_rate and acceleration: buffers.
void find_momentum_rates(const System& system, const Rotations& R, const BodyMotion& motion, Vectors& turn_rate,
                         Vectors& acceleration, Vectors& force, Vectors& moment) {
  body_turn_changes(system, R, motion.freedoms, motion.turn, motion.freedoms, turn_rate);
  spread(
      system, R, Vector3d::Zero(),
      [&](int i, const Vector3d& offset) {
        const Vector3d& Omega = motion.turn[at(i)];
        return Vector3d(Omega.cross(Omega.cross(offset)) + turn_rate[at(i)].cross(offset));
      },
      acceleration);
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Vector3d& Omega = motion.turn[at(i)];
    const Vector3d V = R[at(i)].transpose() * motion.velocity[at(i)];
    const Vector3d V_rate = R[at(i)].transpose() * acceleration[at(i)] - Omega.cross(V);
    const BodyMomentum p = body_momentum(body, V, Omega);
    const BodyMomentum p_rate = body_momentum(body, V_rate, turn_rate[at(i)]);
    force[at(i)] = R[at(i)] * (p_rate.linear + Omega.cross(p.linear));
    moment[at(i)] = p_rate.angular + Omega.cross(p.angular) + V.cross(p.linear);
  }
}

void add_damping(const System& system, const Rotations& R, const BodyMotion& motion, JointMoments& moments) {
  for (const Joint& joint : system.joints()) {
    if (joint.damping == 0.0) continue;
    const std::size_t c = at(joint.child);
    if (!joint.free()) {
      moments.along[c] -= joint.damping * motion.freedoms[c];
      continue;
    }
    const Matrix3d Q = child_to_parent(R, joint);
    const Vector3d relative = motion.turn[c] - Q.transpose() * motion.turn[at(joint.parent)];
    moments.body[c] -= joint.damping * relative;
    moments.body[at(joint.parent)] += joint.damping * (Q * relative);
  }
}

}  // namespace

VectorXd bias(const System& system, const Rotations& R, const VectorXd& velocity) {
  const std::size_t bodies = at(system.body_count());
  Vectors turn_rate(bodies), acceleration(bodies), force(bodies), moment(bodies);
  find_momentum_rates(system, R, body_motion(system, R, velocity), turn_rate, acceleration, force, moment);
  return gathered(system, R, force, moment);
}

VectorXd damping_force(const System& system, const Rotations& R, const VectorXd& velocity) {
  JointMoments moments(system.body_count());
  add_damping(system, R, body_motion(system, R, velocity), moments);
  return gathered(system, R, moments);
}

VectorXd acceleration(const System& system, const Rotations& R, const VectorXd& velocity, const Moments& control) {
  EquationsOfMotion equations(system);
  equations.evaluate(R, velocity, control);
  return equations.acceleration();
}

EquationsOfMotion::EquationsOfMotion(const System& system)
    : system_(system),
      inertia_(system),
      blocks_(at(system.body_count())),
      motion_{Freedoms(blocks_.size()), Vectors(blocks_.size()), Vectors(blocks_.size())},
      moments_(system.body_count()),
      turn_rate_(blocks_.size()),
      centre_rate_(blocks_.size()),
      force_(blocks_.size()),
      moment_(blocks_.size()),
      along_(blocks_.size()),
      acceleration_(system.velocity_count()) {}

void EquationsOfMotion::evaluate(const Rotations& R, const VectorXd& velocity, const Moments& control) {
  find_motion(system_, R, velocity, motion_);
  find_momentum_rates(system_, R, motion_, turn_rate_, centre_rate_, force_, moment_);
  moments_.set_zero();
  add_node_moments(system_, R, control, 1.0, moments_);
  add_damping(system_, R, motion_, moments_);
  for (std::size_t i = 0; i < force_.size(); ++i) {
    force_[i] = -force_[i];
    moment_[i] = moments_.body[i] - moment_[i];
  }
  sum_subtrees(system_, force_);
  gather(system_, R, force_, moment_, along_);
  for (std::size_t i = 0; i < along_.size(); ++i) along_[i] += moments_.along[i];
  find_inertia_blocks(system_, R, blocks_);
  if (!inertia_.factor(system_, R, R, blocks_, {})) {
    acceleration_.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  inertia_.solve(system_, R, R, along_, force_[0]);
  pack(system_, along_, force_[0], acceleration_);
}

}  // namespace lamprey::mechanics
