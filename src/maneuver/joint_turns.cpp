#include "maneuver/joint_turns.hpp"

#include "maneuver/limit_terms.hpp"
#include "mechanics/continuous.hpp"

namespace lamprey::maneuver {

using lie::hat;
using mechanics::Freedoms;
using mechanics::Interval;
using mechanics::Rotations;
using model::at;
using model::Joint;
using model::System;

// A ball joint over a step: ψ = log(Q'Qᵀ), the child's turn in the parent's frame, where the attitude at either end shows it alike.
struct JointTurns::BallStep {
  Matrix3d Q, Q_next, M;
  Vector3d psi;
  BallStep(const Interval& interval, const Joint& joint)
      : Q(mechanics::child_to_parent(interval.rotation, joint)),
        Q_next(mechanics::child_to_parent(interval.next_rotation, joint)),
        M(Q_next * Q.transpose()),
        psi(lie::log(M)) {}
};

JointTurns::JointTurns(const System& system, const MatrixXd& shape_basis) : system_(system), shape_basis_(shape_basis) {
  for (int j = 0; j < system.joint_count(); ++j)
    for (Eigen::Index c = 0; c < system.joint(j).actuation.cols(); ++c)
      moment_.push_back({j, system.joint(j).actuation.col(c)});
}

MatrixXd JointTurns::turns_of(const Rotations& R, int body) const {
  if (body == 0) return MatrixXd::Zero(3, shape_basis_.cols());
  if (system_.body(body).freedoms == 3) return shape_basis_.middleRows<3>(shape_offset(system_.body(body)));
  return mechanics::turn_by_freedoms(system_, R, body).rightCols(shape_basis_.rows()) * shape_basis_;
}

// Moments act on the parent, their opposites on the child: hence the signs.
void JointTurns::evaluate(const Interval& interval, Eigen::Ref<VectorXd> turn) const {
  int before = -1;
  Vector3d child_turn = Vector3d::Zero();
  for (std::size_t c = 0; c < moment_.size(); ++c) {
    const Joint& joint = system_.joint(moment_[c].joint);
    if (moment_[c].joint != before)
      child_turn = joint.free() ? BallStep(interval, joint).psi : interval.joint_turn[at(joint.child)];
    before = moment_[c].joint;
    turn[static_cast<Eigen::Index>(c)] = -moment_[c].direction.dot(child_turn);
  }
}

void JointTurns::derivative(const Interval& interval, MatrixXd& rate) const {
  const Eigen::Index f = shape_basis_.cols();
  rate.setZero(size(), 2 * f);
  int before = -1;
  MatrixXd joint_rate(3, 2 * f);
  for (int c = 0; c < size(); ++c) {
    const Joint& joint = system_.joint(joint_of(c));
    if (joint_of(c) != before) {
      joint_rate.setZero();
      if (joint.free()) {
        const BallStep ball(interval, joint);
        const Matrix3d T = lie::log_tangent(ball.psi);
        joint_rate.leftCols(f) =
            -T * (ball.Q * turns_of(interval.rotation, joint.child) - turns_of(interval.rotation, joint.parent));
        joint_rate.rightCols(f) = T * ball.M.transpose() *
                                  (ball.Q_next * turns_of(interval.next_rotation, joint.child) -
                                   turns_of(interval.next_rotation, joint.parent));
      } else {
        const model::Body& child = system_.body(joint.child);
        const auto rows = shape_basis_.middleRows(shape_offset(child), child.freedoms);
        joint_rate.topLeftCorner(child.freedoms, f) = -rows;
        joint_rate.topRightCorner(child.freedoms, f) = rows;
      }
      before = joint_of(c);
    }
    rate.row(c) = -moment_[at(c)].direction.transpose() * joint_rate;
  }
}

void JointTurns::add_curvature(const Interval& interval, const VectorXd& pull, MatrixXd& hessian) const {
  const Eigen::Index f = shape_basis_.cols();
  VectorXd pull_left = VectorXd::Zero(Eigen::Index{3} * system_.body_count()), pull_right = pull_left;
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    if (!joint.free()) continue;  // turns about axes are differences of angles
    Vector3d e = Vector3d::Zero();
    for (int c = 0; c < size(); ++c)
      if (joint_of(c) == j) e -= pull[c] * moment_[at(c)].direction;
    const BallStep ball(interval, joint);
    const MatrixXd parent = turns_of(interval.rotation, joint.parent);
    const MatrixXd child = ball.Q * turns_of(interval.rotation, joint.child);
    const MatrixXd parent_next = turns_of(interval.next_rotation, joint.parent);
    const MatrixXd child_next = ball.Q_next * turns_of(interval.next_rotation, joint.child);
    const Matrix3d T = lie::log_tangent(ball.psi);
    const Vector3d turned = T.transpose() * e;  // gradient of e·ψ by a turn of M
    Matrix3d bend;
    for (int c = 0; c < 3; ++c) bend.col(c) = lie::log_tangent_rate(ball.psi, T.col(c)).transpose() * e;
    bend = (0.5 * (bend + bend.transpose())).eval();
    // (left, right) as turns of the child against the parent, parent's frame
    const MatrixXd left = child - parent, right = ball.M.transpose() * (child_next - parent_next);
    MatrixXd both(3, 2 * f);
    both << -left, right;
    hessian.noalias() += both.transpose() * bend * both;
    const MatrixXd mixed = -0.5 * left.transpose() * hat(turned) * right;
    hessian.topRightCorner(f, f) += mixed;
    hessian.bottomLeftCorner(f, f) += mixed.transpose();
    // parent's turn first, then the child's: exp(−p) exp(c) = exp(c − p − ½ p × c + …)
    const Vector3d at_left = -turned, at_right = ball.M * turned;
    const MatrixXd bracket = 0.5 * parent.transpose() * hat(at_left) * child;
    const MatrixXd bracket_next = 0.5 * parent_next.transpose() * hat(at_right) * child_next;
    hessian.topLeftCorner(f, f) += bracket + bracket.transpose();
    hessian.bottomRightCorner(f, f) += bracket_next + bracket_next.transpose();
    pull_left.segment<3>(3 * joint.parent) -= at_left;
    pull_left.segment<3>(3 * joint.child) += ball.Q.transpose() * at_left;
    pull_right.segment<3>(3 * joint.parent) -= at_right;
    pull_right.segment<3>(3 * joint.child) += ball.Q_next.transpose() * at_right;
  }
  if (system_.only_free_joints() || pull_left.isZero(0.0)) return;
  hessian.topLeftCorner(f, f) +=
      shape_basis_.transpose() * turn_curvature(system_, interval.rotation, pull_left) * shape_basis_;
  hessian.bottomRightCorner(f, f) +=
      shape_basis_.transpose() * turn_curvature(system_, interval.next_rotation, pull_right) * shape_basis_;
}

VectorXd JointTurns::rates(const Rotations& rotation, const VectorXd& velocity) const {
  Freedoms freedoms(at(system_.body_count()));
  mechanics::Vectors turns(at(system_.body_count()));
  mechanics::Moments by_joint(at(system_.joint_count()));
  mechanics::unpack(system_, velocity, freedoms);
  mechanics::body_turns(system_, rotation, freedoms, turns);
  mechanics::control_work(system_, rotation, {freedoms, turns}, by_joint);
  VectorXd result(size());
  for (int c = 0; c < size(); ++c) result[c] = moment_[at(c)].direction.dot(by_joint[at(joint_of(c))]);
  return result;
}

}  // namespace lamprey::maneuver
