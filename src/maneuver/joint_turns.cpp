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

namespace {

BallTurn ball_turn(const Interval& interval, const Joint& joint) {
  return {mechanics::child_to_parent(interval.rotation, joint),
          mechanics::child_to_parent(interval.next_rotation, joint)};
}

}  // namespace

BallTurn::BallTurn(const Matrix3d& before, const Matrix3d& after)
    : before_(before),
      after_(after),
      turn_(after * before.transpose()),
      psi_(lie::log(turn_)),
      tangent_(lie::log_tangent(psi_)) {}

Eigen::Matrix<double, 3, 12> BallTurn::derivative() const {
  const Matrix3d later = tangent_ * turn_.transpose();
  Eigen::Matrix<double, 3, 12> rate;
  rate << tangent_, -tangent_ * before_, -later, later * after_;
  return rate;
}

// Equations 13.8 and 13.9.
Eigen::Matrix<double, 12, 12> BallTurn::curvature(const Vector3d& pull) const {
  const Vector3d turned = tangent_.transpose() * pull;  // gradient of pull·ψ by a turn of Q'Qᵀ
  Matrix3d bend;
  for (int c = 0; c < 3; ++c) bend.col(c) = lie::log_tangent_rate(psi_, tangent_.col(c)).transpose() * pull;
  bend = (0.5 * (bend + bend.transpose())).eval();
  // turns of the child against the parent, parent's frame
  Eigen::Matrix<double, 3, 12> left = Eigen::Matrix<double, 3, 12>::Zero(), right = left;
  left.leftCols<6>() << -Matrix3d::Identity(), before_;
  right.rightCols<6>() << -turn_.transpose(), turn_.transpose() * after_;
  Eigen::Matrix<double, 12, 12> hessian = (right - left).transpose() * bend * (right - left);
  const Eigen::Matrix<double, 12, 12> mixed = -0.5 * left.transpose() * hat(turned) * right;
  hessian += mixed + mixed.transpose();
  // the parent's turn first, then the child's: exp(−p) exp(c) = exp(c − p − ½ p × c + …)
  const auto add_bracket = [&](int place, const Matrix3d& child) {
    hessian.block<3, 3>(place, place + 3) += child;
    hessian.block<3, 3>(place + 3, place) += child.transpose();
  };
  add_bracket(0, -0.5 * hat(turned) * before_);
  add_bracket(6, 0.5 * hat(turn_ * turned) * after_);
  return hessian;
}

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
      child_turn = joint.free() ? ball_turn(interval, joint).psi() : interval.joint_turn[at(joint.child)];
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
        const Eigen::Matrix<double, 3, 12> ball = ball_turn(interval, joint).derivative();
        joint_rate.leftCols(f) = ball.middleCols<3>(0) * turns_of(interval.rotation, joint.parent) +
                                 ball.middleCols<3>(3) * turns_of(interval.rotation, joint.child);
        joint_rate.rightCols(f) = ball.middleCols<3>(6) * turns_of(interval.next_rotation, joint.parent) +
                                  ball.middleCols<3>(9) * turns_of(interval.next_rotation, joint.child);
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
    const BallTurn ball = ball_turn(interval, joint);
    MatrixXd turns = MatrixXd::Zero(12, 2 * f);
    turns.block(0, 0, 3, f) = turns_of(interval.rotation, joint.parent);
    turns.block(3, 0, 3, f) = turns_of(interval.rotation, joint.child);
    turns.block(6, f, 3, f) = turns_of(interval.next_rotation, joint.parent);
    turns.block(9, f, 3, f) = turns_of(interval.next_rotation, joint.child);
    hessian.noalias() += turns.transpose() * ball.curvature(e) * turns;
    const Eigen::Matrix<double, 12, 1> slope = ball.derivative().transpose() * e;
    pull_left.segment<3>(3 * joint.parent) += slope.segment<3>(0);
    pull_left.segment<3>(3 * joint.child) += slope.segment<3>(3);
    pull_right.segment<3>(3 * joint.parent) += slope.segment<3>(6);
    pull_right.segment<3>(3 * joint.child) += slope.segment<3>(9);
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
