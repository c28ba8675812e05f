#include "mechanics/continuous.hpp"

#include <limits>

namespace lamprey::mechanics {

using model::at;
using model::Body;
using model::Joint;
using model::System;

MatrixXd generalized_inertia(const System& system, const Rotations& R) {
  const int size = system.velocity_count();
  MatrixXd inertia(size, size);
  for (int c = 0; c < size; ++c) inertia.col(c) = generalized_momentum(system, R, VectorXd::Unit(size, c));
  return 0.5 * (inertia + inertia.transpose());
}

VectorXd velocity_of_momentum(const System& system, const Rotations& R, const VectorXd& momentum) {
  TreeElimination inertia(system);
  Freedoms freedoms(at(system.body_count()));
  unpack(system, momentum, freedoms);
  Vector3d linear = momentum.tail<3>();
  std::vector<BodyBlock> blocks(at(system.body_count()));
  find_inertia_blocks(system, R, blocks);
  if (!inertia.factor(system, R, R, blocks, {}))
    return VectorXd::Constant(system.velocity_count(), std::numeric_limits<double>::quiet_NaN());
  inertia.solve(system, R, R, freedoms, linear);
  VectorXd velocity;
  pack(system, freedoms, linear, velocity);
  return velocity;
}

VectorXd velocity_of_bodies(const System& system, const Rotations& R, const Vectors& angular_velocity,
                            const Vector3d& linear_velocity) {
  Freedoms freedoms(angular_velocity);
  for (const Joint& joint : system.joints()) {
    if (joint.free()) continue;
    const std::size_t c = at(joint.child);
    const JointFrame frame = joint_frame(joint, R[at(joint.parent)], R[c]);
    const int count = system.body(joint.child).freedoms;
    const Vector3d relative =
        angular_velocity[c] - frame.child_to_parent.transpose() * angular_velocity[at(joint.parent)];
    freedoms[c].setZero();
    if (count > 0) freedoms[c].head<2>() = lie::coordinates_along(frame.axes.leftCols<2>(), relative);
  }
  VectorXd velocity;
  pack(system, freedoms, linear_velocity, velocity);
  return velocity;
}

Vectors applied_moments(const System& system, const Rotations& R, const Moments& moments) {
  Vectors applied(moments);
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.free()) continue;
    const JointFrame frame = joint_frame(joint, R[at(joint.parent)], R[at(joint.child)]);
    applied[at(j)] = frame.child_to_parent * (frame.axes * moments[at(j)]);
  }
  return applied;
}

Moments moments_of_applied(const System& system, const Rotations& R, const Vectors& applied) {
  Moments moments(applied);
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.free()) continue;
    const JointFrame frame = joint_frame(joint, R[at(joint.parent)], R[at(joint.child)]);
    // the axes of a universal joint are orthogonal as the moments see them: a and Q b
    const Matrix3d axes = frame.child_to_parent * frame.axes;
    moments[at(j)] = axes.transpose() * applied[at(j)];
  }
  return moments;
}

Vectors angular_velocities(const System& system, const Rotations& R, const VectorXd& velocity) {
  return body_motion(system, R, velocity).turn;
}

double kinetic_energy(const System& system, const Rotations& R, const VectorXd& velocity) {
  const BodyMotion motion = body_motion(system, R, velocity);
  double energy = 0.0;
  for (int i = 0; i < system.body_count(); ++i) {
    const Vector3d V = R[at(i)].transpose() * motion.velocity[at(i)];
    const Vector3d& Omega = motion.turn[at(i)];
    const BodyMomentum p = body_momentum(system.body(i), V, Omega);
    energy += 0.5 * (V.dot(p.linear) + Omega.dot(p.angular));
  }
  return energy;
}

double energy(const System& system, const Rotations& R, const VectorXd& velocity) {
  return kinetic_energy(system, R, velocity) + spring_energy(system, R);
}

VectorXd generalized_momentum(const System& system, const Rotations& R, const VectorXd& velocity) {
  const BodyMotion motion = body_motion(system, R, velocity);
  Vectors force(at(system.body_count())), moment(at(system.body_count()));
  for (int i = 0; i < system.body_count(); ++i) {
    const BodyMomentum p =
        body_momentum(system.body(i), R[at(i)].transpose() * motion.velocity[at(i)], motion.turn[at(i)]);
    force[at(i)] = R[at(i)] * p.linear;
    moment[at(i)] = p.angular;
  }
  return gathered(system, R, force, moment);
}

VectorXd generalized_momentum_rate(const System& system, const Rotations& R, const VectorXd& velocity,
                                   const Freedoms& turn) {
  const std::size_t bodies = at(system.body_count());
  const BodyMotion motion = body_motion(system, R, velocity);
  Vectors eta(bodies), Omega_rate(bodies), centre_rate(bodies);
  body_turns(system, R, turn, eta);
  body_turn_changes(system, R, motion.freedoms, motion.turn, turn, Omega_rate);
  spread(
      system, R, Vector3d::Zero(),
      [&](int i, const Vector3d& offset) {
        return Vector3d(eta[at(i)].cross(motion.turn[at(i)].cross(offset)) + Omega_rate[at(i)].cross(offset));
      },
      centre_rate);
  Vectors force(bodies), moment(bodies), force_rate(bodies), moment_rate(bodies);
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Vector3d V = R[at(i)].transpose() * motion.velocity[at(i)];
    const Vector3d V_rate = R[at(i)].transpose() * centre_rate[at(i)] - eta[at(i)].cross(V);
    const BodyMomentum p = body_momentum(body, V, motion.turn[at(i)]);
    const BodyMomentum p_rate = body_momentum(body, V_rate, Omega_rate[at(i)]);
    force[at(i)] = R[at(i)] * p.linear;
    moment[at(i)] = p.angular;
    force_rate[at(i)] = R[at(i)] * (p_rate.linear + eta[at(i)].cross(p.linear));
    moment_rate[at(i)] = p_rate.angular;
  }
  sum_subtrees(system, force);
  sum_subtrees(system, force_rate);
  Freedoms along(bodies), rate(bodies);
  gather(system, R, force, moment, along);
  gather_rate(system, R, force, moment, {turn, eta, force_rate}, moment_rate, rate);
  VectorXd result;
  pack(system, rate, force_rate[0], result);
  return result;
}

VectorXd generalized_force(const System& system, const Rotations& R, const Moments& control) {
  JointMoments moments(system.body_count());
  add_node_moments(system, R, control, 1.0, moments);
  return gathered(system, R, moments);
}

SpatialMomentum spatial_momentum(const System& system, const Rotations& R, const Vector3d& position,
                                 const VectorXd& momentum) {
  SpatialMomentum total;
  total.linear = momentum.tail<3>();
  total.angular = position.cross(total.linear);
  for (int i = 0; i < system.body_count(); ++i)
    if (system.body(i).freedoms == 3) total.angular += R[at(i)] * momentum.segment<3>(system.body(i).velocity_offset);
  return total;
}

SpatialMomentum momentum_of_bodies(const System& system, const Rotations& R, const Vector3d& position,
                                   const VectorXd& velocity) {
  const std::vector<Vector3d> centres = system.mass_centres(R, position);
  const BodyMotion motion = body_motion(system, R, velocity);
  SpatialMomentum total;
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Vector3d p = body.mass * motion.velocity[at(i)];
    total.linear += p;
    total.angular += centres[at(i)].cross(p) + R[at(i)] * (body.body_inertia * motion.turn[at(i)]);
  }
  return total;
}

VectorXd answers_to_moments(const System& system, const Rotations& R) {
  const auto force = [&](const VectorXd& control) {
    return generalized_force(system, R, joint_moments(system, control));
  };
  const VectorXd springs = force(VectorXd::Zero(system.control_count()));
  VectorXd answers(system.control_count());
  for (Eigen::Index c = 0; c < answers.size(); ++c) {
    const VectorXd own = force(VectorXd::Unit(answers.size(), c)) - springs;
    answers[c] = own.dot(velocity_of_momentum(system, R, own));
  }
  return answers;
}

}  // namespace lamprey::mechanics
