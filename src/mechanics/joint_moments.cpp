#include "mechanics/joint_moments.hpp"

namespace lamprey::mechanics {

namespace {

using model::at;
using model::Body;
using model::Joint;
using model::System;

// Turn of the child against its parent, child's frame.
Vector3d relative_turn(const Matrix3d& Q, const Vectors& turns, const Joint& joint) {
  return turns[at(joint.child)] - Q.transpose() * turns[at(joint.parent)];
}

// Its change along a second direction.
Vector3d relative_turn_change(const Matrix3d& Q, const Vectors& first, const Vectors& first_changes,
                              const Vector3d& second_relative, const Joint& joint) {
  const Vector3d carried = Q.transpose() * first[at(joint.parent)];
  return first_changes[at(joint.child)] + second_relative.cross(carried) -
         Q.transpose() * first_changes[at(joint.parent)];
}

// A moment on the child and its opposite on the parent.
void add_pair(const Joint& joint, const Matrix3d& Q, const Vector3d& on_child, JointMoments& result) {
  result.body[at(joint.child)] += on_child;
  result.body[at(joint.parent)] -= Q * on_child;
}

// φ of a sprung ball joint: from its zero angle, child's frame.
Vector3d spring_turn(const Joint& joint, const Matrix3d& Q) {
  return lie::log(joint.reference_rotation.transpose() * Q);
}

// Turn Δ of a damped ball joint over a step and its rate along turns ρ at both ends.
struct BallTurn {
  BallTurn(const Interval& step, const Joint& joint)
      : Q(child_to_parent(step.rotation, joint)),
        Q_next(child_to_parent(step.next_rotation, joint)),
        D(Q.transpose() * Q_next),
        value(lie::log(D)),
        tangent(lie::log_tangent(value)) {}
  Vector3d right_turn(const Vector3d& left, const Vector3d& right) const { return right - D.transpose() * left; }
  Matrix3d Q, Q_next, D;
  Vector3d value;    // Δ
  Matrix3d tangent;  // Δ̇ = tangent · (ρ' − Dᵀρ)
};

}  // namespace

JointMoments::JointMoments(int bodies) : body(at(bodies)), along(at(bodies)) { set_zero(); }

void JointMoments::set_zero() {
  for (Vector3d& m : body) m.setZero();
  for (Vector3d& m : along) m.setZero();
}

Moments joint_moments(const System& system, const Eigen::VectorXd& control) {
  Moments moments;
  for (const Joint& joint : system.joints())
    moments.emplace_back(joint.actuation * control.segment(joint.first_control, joint.actuation.cols()));
  return moments;
}

Eigen::VectorXd along_actuation(const System& system, const Moments& moments) {
  Eigen::VectorXd control(system.control_count());
  along_actuation(system, moments, control);
  return control;
}

void along_actuation(const System& system, const Moments& moments, Eigen::Ref<Eigen::VectorXd> control) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    control.segment(joint.first_control, joint.actuation.cols()) = joint.actuation.transpose() * moments[at(j)];
  }
}

VectorXd gathered(const System& system, const Rotations& R, JointMoments& moments) {
  Vectors none(at(system.body_count()), Vector3d::Zero());
  VectorXd force = gathered(system, R, none, moments.body), along;
  pack(system, moments.along, Vector3d::Zero(), along);
  force += along;
  return force;
}

void add_node_moments(const System& system, const Rotations& R, const Moments& control, double weight,
                      JointMoments& result) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.free()) {
      const Vector3d u = weight * control[at(j)];
      result.body[at(joint.parent)] += u;
      result.body[at(joint.child)] -= R[at(joint.child)].transpose() * (R[at(joint.parent)] * u);
    } else {
      result.along[at(joint.child)] -= weight * control[at(j)];
    }
    if (joint.stiffness == 0.0) continue;
    const Matrix3d Q = child_to_parent(R, joint);
    const double k = weight * joint.stiffness;
    if (joint.free()) {
      add_pair(joint, Q, -k * spring_turn(joint, Q), result);
    } else {
      result.along[at(joint.child)] -= k * joint_angles(joint, Q);
    }
  }
}

void add_node_moment_rates(const System& system, const Rotations& R, const Moments& control, NodeTurns along,
                           const Moments& control_rate, RateKind kind, double weight, JointMoments& result) {
  const bool by_control = kind == RateKind::tangent && !control_rate.empty();
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    const double k = weight * joint.stiffness;
    if (!joint.free()) {
      if (by_control) result.along[at(joint.child)] -= weight * control_rate[at(j)];
      result.along[at(joint.child)] -= k * along.freedoms[at(joint.child)];
      continue;
    }
    const Matrix3d Q = child_to_parent(R, joint);
    const Vector3d turn = relative_turn(Q, along.turns, joint);
    if (kind == RateKind::tangent) {
      result.body[at(joint.child)] += weight * turn.cross(Q.transpose() * control[at(j)]);
      if (by_control) add_pair(joint, Q, -weight * (Q.transpose() * control_rate[at(j)]), result);
    } else {
      result.body[at(joint.parent)] += weight * (Q * turn).cross(control[at(j)]);
    }
    if (k == 0.0) continue;
    const Vector3d phi = spring_turn(joint, Q);
    const Vector3d phi_rate = lie::log_tangent(phi) * turn;
    result.body[at(joint.child)] -= k * phi_rate;
    result.body[at(joint.parent)] += k * (Q * (turn.cross(phi) + phi_rate));
  }
}

void add_node_moment_second_rates(const System& system, const Rotations& R, const Moments& control, NodeTurns first,
                                  NodeTurns second, const Vectors& first_changes, const Moments& second_control_rate,
                                  double weight, JointMoments& result) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (!joint.free()) continue;  // along axes all rates are constant
    const Matrix3d Q = child_to_parent(R, joint);
    const Vector3d turn_1 = relative_turn(Q, first.turns, joint);
    const Vector3d turn_2 = relative_turn(Q, second.turns, joint);
    const Vector3d turn_12 = relative_turn_change(Q, first.turns, first_changes, turn_2, joint);
    Vector3d& on_parent = result.body[at(joint.parent)];
    on_parent += weight * (Q * (turn_2.cross(turn_1) + turn_12)).cross(control[at(j)]);
    if (!second_control_rate.empty()) on_parent += weight * (Q * turn_1).cross(second_control_rate[at(j)]);
    const double k = weight * joint.stiffness;
    if (k == 0.0) continue;
    const Vector3d phi = spring_turn(joint, Q);
    const Matrix3d T = lie::log_tangent(phi);
    const Vector3d phi_1 = T * turn_1;
    const Vector3d phi_2 = T * turn_2;
    const Vector3d phi_12 = T * turn_12 + lie::log_tangent_rate(phi, phi_2) * turn_1;
    result.body[at(joint.child)] -= k * phi_12;
    on_parent +=
        k * (Q * (turn_2.cross(turn_1.cross(phi) + phi_1) + turn_12.cross(phi) + turn_1.cross(phi_2) + phi_12));
  }
}

void control_work(const System& system, const Rotations& R, NodeTurns along, Moments& result) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.free()) {
      const Matrix3d Q = child_to_parent(R, joint);
      result[at(j)] = -(Q * relative_turn(Q, along.turns, joint));
    } else {
      result[at(j)] = -along.freedoms[at(joint.child)];
    }
  }
}

void control_work_rate(const System& system, const Rotations& R, NodeTurns first, NodeTurns second,
                       const Vectors& first_changes, Moments& result) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    result[at(j)].setZero();
    if (!joint.free()) continue;
    const Matrix3d Q = child_to_parent(R, joint);
    const Vector3d turn_1 = relative_turn(Q, first.turns, joint);
    const Vector3d turn_2 = relative_turn(Q, second.turns, joint);
    result[at(j)] = -(Q * (turn_2.cross(turn_1) + relative_turn_change(Q, first.turns, first_changes, turn_2, joint)));
  }
}

void damping_momenta(const System& system, const Interval& step, JointMoments& minus, JointMoments& plus) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.damping == 0.0) continue;
    const double half = 0.5 * joint.damping;
    if (joint.free()) {
      const BallTurn ball(step, joint);
      add_pair(joint, ball.Q, half * ball.value, minus);
      add_pair(joint, ball.Q_next, half * ball.value, plus);
    } else {
      minus.along[at(joint.child)] += half * step.joint_turn[at(joint.child)];
      plus.along[at(joint.child)] += half * step.joint_turn[at(joint.child)];
    }
  }
}

void add_damping_rates(const System& system, const Interval& step, NodeTurns left, NodeTurns right, double right_sign,
                       double minus_weight, double plus_weight, JointMoments& minus, JointMoments& plus) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.damping == 0.0) continue;
    const double half = 0.5 * joint.damping;
    if (!joint.free()) {
      const std::size_t c = at(joint.child);
      const Vector3d rate = half * (right_sign * right.freedoms[c] - left.freedoms[c]);
      minus.along[c] += minus_weight * rate;
      plus.along[c] += plus_weight * rate;
      continue;
    }
    const BallTurn ball(step, joint);
    const Vector3d turn = relative_turn(ball.Q, left.turns, joint);
    const Vector3d turn_next = right_sign * relative_turn(ball.Q_next, right.turns, joint);
    const Vector3d rate = ball.tangent * ball.right_turn(turn, turn_next);
    const auto add = [&](const Matrix3d& Q, const Vector3d& relative, double weight, JointMoments& result) {
      result.body[at(joint.child)] += weight * half * rate;
      result.body[at(joint.parent)] -= weight * half * (Q * (relative.cross(ball.value) + rate));
    };
    add(ball.Q, turn, minus_weight, minus);
    add(ball.Q_next, turn_next, plus_weight, plus);
  }
}

void add_damping_second_rates(const System& system, const Interval& step, const StepTurns& first,
                              const StepTurns& second, const Vectors& first_left_changes,
                              const Vectors& first_right_changes, double minus_weight, double plus_weight,
                              JointMoments& minus, JointMoments& plus) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.damping == 0.0 || !joint.free()) continue;
    const double half = 0.5 * joint.damping;
    const BallTurn ball(step, joint);
    const Vector3d left_1 = relative_turn(ball.Q, first.left.turns, joint);
    const Vector3d left_2 = relative_turn(ball.Q, second.left.turns, joint);
    const Vector3d left_12 = relative_turn_change(ball.Q, first.left.turns, first_left_changes, left_2, joint);
    const Vector3d right_1 = first.right_sign * relative_turn(ball.Q_next, first.right.turns, joint);
    const Vector3d right_2 = second.right_sign * relative_turn(ball.Q_next, second.right.turns, joint);
    const Vector3d right_12 =
        first.right_sign * relative_turn_change(ball.Q_next, first.right.turns, first_right_changes, right_2, joint);
    const Vector3d turn_1 = ball.right_turn(left_1, right_1);
    const Vector3d turn_2 = ball.right_turn(left_2, right_2);
    const Vector3d turn_12 = ball.right_turn(left_12, right_12) + turn_2.cross(ball.D.transpose() * left_1);
    const Vector3d rate_1 = ball.tangent * turn_1;
    const Vector3d rate_2 = ball.tangent * turn_2;
    const Vector3d rate_12 = ball.tangent * turn_12 + lie::log_tangent_rate(ball.value, rate_2) * turn_1;
    const auto add = [&](const Matrix3d& Q, const Vector3d& r1, const Vector3d& r2, const Vector3d& r12, double weight,
                         JointMoments& result) {
      result.body[at(joint.child)] += weight * half * rate_12;
      result.body[at(joint.parent)] -=
          weight * half *
          (Q * (r2.cross(r1.cross(ball.value) + rate_1) + r12.cross(ball.value) + r1.cross(rate_2) + rate_12));
    };
    add(ball.Q, left_1, left_2, left_12, minus_weight, minus);
    add(ball.Q_next, right_1, right_2, right_12, plus_weight, plus);
  }
}

void damping_blocks(const System& system, const Interval& step, std::vector<Matrix3d>& blocks) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.damping == 0.0) continue;
    const double half = 0.5 * joint.damping;
    blocks[at(joint.child)] = half * Matrix3d::Identity();
    if (joint.free()) blocks[at(joint.child)] = half * BallTurn(step, joint).tangent;
  }
}

void add_spring_work(const System& system, const Rotations& R, NodeTurns along, double weight, VectorXd& result) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.stiffness == 0.0) continue;
    const Matrix3d Q = child_to_parent(R, joint);
    result[j] -= weight * (joint.free() ? spring_turn(joint, Q).dot(relative_turn(Q, along.turns, joint))
                                        : joint_angles(joint, Q).dot(along.freedoms[at(joint.child)]));
  }
}

void add_damping_work(const System& system, const Interval& step, NodeTurns left, NodeTurns right, VectorXd& result) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (joint.damping == 0.0) continue;
    const std::size_t c = at(joint.child);
    if (!joint.free()) {
      result[j] -= 0.5 * step.joint_turn[c].dot(left.freedoms[c] + right.freedoms[c]);
      continue;
    }
    const BallTurn ball(step, joint);
    result[j] -=
        0.5 * ball.value.dot(relative_turn(ball.Q, left.turns, joint) + relative_turn(ball.Q_next, right.turns, joint));
  }
}

double virtual_work(const JointMoments& moments, NodeTurns along) {
  double work = 0.0;
  for (std::size_t i = 0; i < moments.body.size(); ++i)
    work += moments.body[i].dot(along.turns[i]) + moments.along[i].dot(along.freedoms[i]);
  return work;
}

double spring_energy(const System& system, const Rotations& R) {
  double energy = 0.0;
  for (const Joint& joint : system.joints()) {
    if (joint.stiffness == 0.0) continue;
    const Matrix3d Q = child_to_parent(R, joint);
    const Vector3d turn = joint.free() ? spring_turn(joint, Q) : joint_angles(joint, Q);
    energy += 0.5 * joint.stiffness * turn.squaredNorm();
  }
  return energy;
}

}  // namespace lamprey::mechanics
