#include "mechanics/tree_motion.hpp"

#include <cmath>
#include <numbers>

namespace lamprey::mechanics {

namespace {

using model::at;
using model::Body;
using model::Joint;
using model::JointKind;
using model::System;

// Rate of the axes S when the joint turns with `sigma`: only a universal joint's first axis moves in the child's frame.
Vector3d first_axis_rate(const Joint& joint, const Vector3d& first_axis, const Vector3d& sigma) {
  return joint.kind == JointKind::universal ? Vector3d(sigma[1] * first_axis.cross(joint.child_axis))
                                            : Vector3d(Vector3d::Zero());
}

}  // namespace

JointFrame joint_frame(const Joint& joint, const Matrix3d& R_parent, const Matrix3d& R_child) {
  JointFrame frame{R_parent.transpose() * R_child, Matrix3d::Zero()};
  if (joint.kind == JointKind::hinge) frame.axes.col(0) = joint.child_axis;
  if (joint.kind == JointKind::universal) {
    frame.axes.col(0) = frame.child_to_parent.transpose() * joint.parent_axis;
    frame.axes.col(1) = joint.child_axis;
  }
  return frame;
}

void unpack(const System& system, const VectorXd& generalized, Freedoms& freedoms) {
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    if (body.freedoms == 3) {
      freedoms[at(i)] = generalized.segment<3>(body.velocity_offset);
      continue;
    }
    freedoms[at(i)].setZero();
    for (int f = 0; f < body.freedoms; ++f) freedoms[at(i)][f] = generalized[body.velocity_offset + f];
  }
}

void pack(const System& system, const Freedoms& freedoms, const Vector3d& linear, VectorXd& generalized) {
  generalized.resize(system.velocity_count());
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    for (int f = 0; f < body.freedoms; ++f) generalized[body.velocity_offset + f] = freedoms[at(i)][f];
  }
  generalized.tail<3>() = linear;
}

Vector3d joint_angles(const Joint& joint, const Matrix3d& Q) {
  Vector3d angles = Vector3d::Zero();
  if (joint.kind == JointKind::hinge) {
    const Vector3d turned = lie::log(joint.reference_rotation.transpose() * Q);
    angles[0] = joint.child_axis.dot(turned);
  }
  if (joint.kind == JointKind::universal) {
    // Q b = exp(θ_1 â) b_0 and Qᵀ a = exp(−θ_2 b̂) a_0, with b_0 = Q_0 b and a_0 = Q_0ᵀ a
    const Vector3d b0 = joint.reference_rotation * joint.child_axis;
    const Vector3d a0 = joint.reference_rotation.transpose() * joint.parent_axis;
    const Vector3d b = Q * joint.child_axis;
    const Vector3d a = Q.transpose() * joint.parent_axis;
    angles[0] = std::atan2(joint.parent_axis.dot(b0.cross(b)), b0.dot(b));
    angles[1] = std::atan2(joint.child_axis.dot(a.cross(a0)), a0.dot(a));
  }
  return angles;
}

Vector3d turn_from_zero(const Joint& joint, const Matrix3d& Q, const Vector3d& before) {
  constexpr double whole_turn = 2.0 * std::numbers::pi;
  if (!joint.free()) {
    const Vector3d angles = joint_angles(joint, Q);
    return angles + whole_turn * ((before - angles) / whole_turn).array().round().matrix();
  }
  const Vector3d turn = lie::log(Q * joint.reference_rotation.transpose());
  const double angle = turn.norm();
  // next to whole turns the axis is lost in round-off; it is the last one then
  const bool has_axis = angle > 1e-8 || before.norm() < std::numbers::pi;
  const Vector3d axis = !has_axis ? before.normalized() : angle > 0.0 ? Vector3d(turn / angle) : Vector3d::Zero();
  const double reached = has_axis ? angle : axis.dot(turn);
  return (reached + whole_turn * std::round((axis.dot(before) - reached) / whole_turn)) * axis;
}

Matrix3d rotation_at_turn(const Joint& joint, const Vector3d& turn) {
  return joint.free() ? Matrix3d(lie::exp(turn) * joint.reference_rotation) : joint_rotation(joint, turn);
}

Rotations shape_at_turns(const System& system, const Vectors& turn) {
  Rotations shape(at(system.body_count()), Matrix3d::Identity());
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.parent >= 0)
      shape[at(i)] = shape[at(body.parent)] * rotation_at_turn(system.joint(body.joint), turn[at(body.joint)]);
  }
  return shape;
}

Matrix3d joint_rotation(const Joint& joint, const Vector3d& angles) {
  if (joint.kind == JointKind::hinge) return joint.reference_rotation * lie::exp(angles[0] * joint.child_axis);
  if (joint.kind == JointKind::universal)
    return lie::exp(angles[0] * joint.parent_axis) * joint.reference_rotation * lie::exp(angles[1] * joint.child_axis);
  return joint.reference_rotation;
}

void body_turns(const System& system, const Rotations& R, const Freedoms& freedoms, Vectors& turns) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.freedoms == 3) {
      turns[at(i)] = freedoms[at(i)];
      continue;
    }
    const JointFrame frame = joint_frame(system.joint(body.joint), R[at(body.parent)], R[at(i)]);
    turns[at(i)] = frame.child_to_parent.transpose() * turns[at(body.parent)] + frame.axes * freedoms[at(i)];
  }
}

MatrixXd turn_by_freedoms(const System& system, const Rotations& R, int body) {
  MatrixXd turn(3, system.velocity_count() - 3);
  set_turn_by_freedoms(system, R, body, turn);
  return turn;
}

void set_turn_by_freedoms(const System& system, const Rotations& R, int asked, MatrixXd& turn) {
  turn.setZero();
  Matrix3d seen = Matrix3d::Identity();  // from the body on the way to the one asked for
  for (int i = asked;; i = system.body(i).parent) {
    const Body& body = system.body(i);
    if (body.freedoms == 3) {
      turn.middleCols<3>(body.velocity_offset) = seen;
      return;
    }
    const JointFrame frame = joint_frame(system.joint(body.joint), R[at(body.parent)], R[at(i)]);
    for (int f = 0; f < body.freedoms; ++f) turn.col(body.velocity_offset + f) = seen * frame.axes.col(f);
    seen = seen * frame.child_to_parent.transpose();
  }
}

void body_turn_changes(const System& system, const Rotations& R, const Freedoms& first, const Vectors& first_turns,
                       const Freedoms& second, Vectors& changes) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.freedoms == 3) {
      changes[at(i)].setZero();
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const JointFrame frame = joint_frame(joint, R[at(body.parent)], R[at(i)]);
    const Vector3d carried = frame.child_to_parent.transpose() * first_turns[at(body.parent)];
    const Vector3d joint_turn = frame.axes * second[at(i)];
    changes[at(i)] = carried.cross(joint_turn) + frame.child_to_parent.transpose() * changes[at(body.parent)] +
                     first[at(i)][0] * first_axis_rate(joint, frame.axes.col(0), second[at(i)]);
  }
}

void sum_subtrees(const System& system, Vectors& force) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int parent = system.body(*position).parent;
    if (parent >= 0) force[at(parent)] += force[at(*position)];
  }
}

void gather(const System& system, const Rotations& R, const Vectors& force, Vectors& moment, Freedoms& result) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    Vector3d& n = moment[at(i)];
    if (body.parent < 0) {
      result[at(i)] = n;
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const Matrix3d& R_parent = R[at(body.parent)];
    Vector3d& parent_moment = moment[at(body.parent)];
    n -= joint.child_offset.cross(R[at(i)].transpose() * force[at(i)]);
    parent_moment += joint.parent_offset.cross(R_parent.transpose() * force[at(i)]);
    if (joint.free()) {
      result[at(i)] = n;
      continue;
    }
    const JointFrame frame = joint_frame(joint, R_parent, R[at(i)]);
    result[at(i)] = frame.axes.transpose() * n;
    parent_moment += frame.child_to_parent * n;
  }
}

VectorXd gathered(const System& system, const Rotations& R, Vectors& force, Vectors& moment) {
  Freedoms freedoms(moment.size());
  sum_subtrees(system, force);
  gather(system, R, force, moment, freedoms);
  VectorXd result;
  pack(system, freedoms, force[0], result);
  return result;
}

void gather_rate(const System& system, const Rotations& R, const Vectors& force, const Vectors& moment,
                 const GatherRate& along, Vectors& moment_rate, Freedoms& result) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    Vector3d& n_rate = moment_rate[at(i)];
    if (body.parent < 0) {
      result[at(i)] = n_rate;
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const int parent = body.parent;
    const auto seen_rate = [&](int from) {  // rate of R_fromᵀ P
      return Vector3d(R[at(from)].transpose() * along.force[at(i)] -
                      along.turns[at(from)].cross(R[at(from)].transpose() * force[at(i)]));
    };
    n_rate -= joint.child_offset.cross(seen_rate(i));
    moment_rate[at(parent)] += joint.parent_offset.cross(seen_rate(parent));
    if (joint.free()) {
      result[at(i)] = n_rate;
      continue;
    }
    const JointFrame frame = joint_frame(joint, R[at(parent)], R[at(i)]);
    const Vector3d& sigma = along.freedoms[at(i)];
    const Vector3d& n = moment[at(i)];
    result[at(i)] = frame.axes.transpose() * n_rate;
    result[at(i)][0] += first_axis_rate(joint, frame.axes.col(0), sigma).dot(n);
    moment_rate[at(parent)] += frame.child_to_parent * (Vector3d(frame.axes * sigma).cross(n) + n_rate);
  }
}

void gather_second_rate(const System& system, const Rotations& R, const Vectors& force, const Vectors& moment,
                        const GatherRate& first, const Vectors& first_moment, const GatherRate& second,
                        const Vectors& second_moment, const Vectors& first_changes, const Vectors& force_second,
                        Vectors& moment_second, Freedoms& result) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    Vector3d& n_12 = moment_second[at(i)];
    if (body.parent < 0) {
      result[at(i)] = n_12;
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const int parent = body.parent;
    const auto seen_second_rate = [&](int from) {  // second rate of R_fromᵀ P
      const Matrix3d& R_from = R[at(from)];
      const Vector3d& turn_1 = first.turns[at(from)];
      const Vector3d& turn_2 = second.turns[at(from)];
      const Vector3d seen = R_from.transpose() * force[at(i)];
      const Vector3d seen_1 = R_from.transpose() * first.force[at(i)];
      const Vector3d seen_2 = R_from.transpose() * second.force[at(i)] - turn_2.cross(seen);
      return Vector3d(R_from.transpose() * force_second[at(i)] - turn_2.cross(seen_1) -
                      first_changes[at(from)].cross(seen) - turn_1.cross(seen_2));
    };
    n_12 -= joint.child_offset.cross(seen_second_rate(i));
    moment_second[at(parent)] += joint.parent_offset.cross(seen_second_rate(parent));
    if (joint.free()) {
      result[at(i)] = n_12;
      continue;
    }
    const JointFrame frame = joint_frame(joint, R[at(parent)], R[at(i)]);
    const Vector3d& n = moment[at(i)];
    const Vector3d& n_1 = first_moment[at(i)];
    const Vector3d& n_2 = second_moment[at(i)];
    const Vector3d& sigma_1 = first.freedoms[at(i)];
    const Vector3d& sigma_2 = second.freedoms[at(i)];
    const Vector3d axis_1 = first_axis_rate(joint, frame.axes.col(0), sigma_1);
    const Vector3d axis_2 = first_axis_rate(joint, frame.axes.col(0), sigma_2);
    const Vector3d axis_12 = first_axis_rate(joint, axis_2, sigma_1);
    const Vector3d turn_1 = frame.axes * sigma_1;
    const Vector3d turn_2 = frame.axes * sigma_2;
    const Vector3d turn_12 = sigma_1[0] * axis_2;
    result[at(i)] = frame.axes.transpose() * n_12;
    result[at(i)][0] += axis_12.dot(n) + axis_1.dot(n_2) + axis_2.dot(n_1);
    moment_second[at(parent)] +=
        frame.child_to_parent * (turn_2.cross(turn_1.cross(n) + n_1) + turn_12.cross(n) + turn_1.cross(n_2) + n_12);
  }
}

Vector3d turn_between(const model::Joint& joint, const Matrix3d& from, const Matrix3d& to) {
  if (joint.free()) return lie::log(from.transpose() * to);
  Vector3d turn = joint_angles(joint, to) - joint_angles(joint, from);
  for (double& angle : turn) angle = lie::shorter_way(angle);
  return turn;
}

Matrix3d turned_by(const model::Joint& joint, const Matrix3d& from, const Vector3d& turn) {
  if (joint.free()) return from * lie::exp(turn);
  return joint_rotation(joint, joint_angles(joint, from) + turn);
}

}  // namespace lamprey::mechanics
