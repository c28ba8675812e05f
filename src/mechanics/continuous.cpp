#include "mechanics/continuous.hpp"

#include <limits>

#include "mechanics/joint_moments.hpp"
#include "mechanics/tree_elimination.hpp"

namespace lamprey::mechanics {

namespace {

using model::at;
using model::Body;
using model::Joint;
using model::System;

// Motion of all bodies at velocity ξ.
struct BodyMotion {
  Freedoms freedoms;
  Vectors turn;      // Ω_i, rad/s, body frames
  Vectors velocity;  // of the mass centres, m/s, world
};

// World vector of each mass centre from one for the root and terms R_i f_i(d) that a joint's offsets add.
template <typename Term>
void spread(const System& system, const Rotations& R, const Vector3d& root, const Term& term, Vectors& result) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.parent < 0) {
      result[at(i)] = root;
      continue;
    }
    const Joint& up = system.joint(body.joint);
    result[at(i)] = result[at(up.parent)] + R[at(up.parent)] * term(up.parent, up.parent_offset) -
                    R[at(i)] * term(i, up.child_offset);
  }
}

BodyMotion body_motion(const System& system, const Rotations& R, const VectorXd& velocity) {
  const std::size_t bodies = at(system.body_count());
  BodyMotion motion{Freedoms(bodies), Vectors(bodies), Vectors(bodies)};
  unpack(system, velocity, motion.freedoms);
  body_turns(system, R, motion.freedoms, motion.turn);
  spread(
      system, R, velocity.tail<3>(),
      [&](int i, const Vector3d& offset) { return Vector3d(motion.turn[at(i)].cross(offset)); }, motion.velocity);
  return motion;
}

struct BodyMomentum {
  Vector3d linear, angular;  // body frame
};

BodyMomentum body_momentum(const Body& body, const Vector3d& V, const Vector3d& Omega) {
  return {body.mass_matrix * V + body.coupling_matrix * Omega,
          body.inertia_matrix * Omega + body.coupling_matrix.transpose() * V};
}

VectorXd gathered(const System& system, const Rotations& R, Vectors& force, Vectors& moment) {
  Freedoms freedoms(moment.size());
  sum_subtrees(system, force);
  gather(system, R, force, moment, freedoms);
  VectorXd result;
  pack(system, freedoms, force[0], result);
  return result;
}

std::vector<BodyBlock> inertia_blocks(const System& system, const Rotations& R) {
  std::vector<BodyBlock> blocks;
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Matrix3d by_turn = R[at(i)] * body.coupling_matrix;
    blocks.push_back(
        {body.inertia_matrix, by_turn.transpose(), by_turn, R[at(i)] * body.mass_matrix * R[at(i)].transpose()});
  }
  return blocks;
}

}  // namespace

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
  std::vector<BodyBlock> blocks = inertia_blocks(system, R);
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

VectorXd bias(const System& system, const Rotations& R, const VectorXd& velocity) {
  const std::size_t bodies = at(system.body_count());
  const BodyMotion motion = body_motion(system, R, velocity);
  Vectors turn_rate(bodies), acceleration(bodies), force(bodies), moment(bodies);
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
  return gathered(system, R, force, moment);
}

VectorXd generalized_force(const System& system, const Rotations& R, const Moments& control) {
  JointMoments moments(system.body_count());
  add_node_moments(system, R, control, 1.0, moments);
  Vectors none(at(system.body_count()), Vector3d::Zero());
  VectorXd force = gathered(system, R, none, moments.body);
  VectorXd along;
  pack(system, moments.along, Vector3d::Zero(), along);
  return force + along;
}

VectorXd damping_force(const System& system, const Rotations& R, const VectorXd& velocity) {
  const BodyMotion motion = body_motion(system, R, velocity);
  JointMoments moments(system.body_count());
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
  Vectors none(at(system.body_count()), Vector3d::Zero());
  VectorXd force = gathered(system, R, none, moments.body);
  VectorXd along;
  pack(system, moments.along, Vector3d::Zero(), along);
  return force + along;
}

VectorXd acceleration(const System& system, const Rotations& R, const VectorXd& velocity, const Moments& control) {
  return velocity_of_momentum(
      system, R,
      generalized_force(system, R, control) + damping_force(system, R, velocity) - bias(system, R, velocity));
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

}  // namespace lamprey::mechanics
