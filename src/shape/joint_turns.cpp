#include "shape/joint_turns.hpp"

#include "mechanics/continuous.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

namespace {

using maneuver::shape_offset;

}  // namespace

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

// Equations 13.10 and 13.11.
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

JointTurns::JointTurns(const System& system, const MatrixXd& shape_basis)
    : system_(system),
      shape_basis_(shape_basis),
      turns_(system, shape_basis),
      joint_rate_(3, 2 * shape_basis.cols()),
      of_bodies_(12, 2 * shape_basis.cols()),
      transposed_(2 * shape_basis.cols(), 12),
      bent_(of_bodies_),
      pull_left_(Eigen::Index{3} * system.body_count()),
      pull_right_(pull_left_) {
  for (int j = 0; j < system.joint_count(); ++j)
    for (Eigen::Index c = 0; c < system.joint(j).actuation.cols(); ++c)
      moment_.push_back({j, system.joint(j).actuation.col(c)});
}

void JointTurns::turns_of_bodies(const Interval& interval, const Joint& joint) {
  const Eigen::Index f = shape_basis_.cols();
  of_bodies_.setZero();
  of_bodies_.block(0, 0, 3, f) = turns_.of_body(interval.rotation, joint.parent);
  of_bodies_.block(3, 0, 3, f) = turns_.of_body(interval.rotation, joint.child);
  of_bodies_.block(6, f, 3, f) = turns_.of_body(interval.next_rotation, joint.parent);
  of_bodies_.block(9, f, 3, f) = turns_.of_body(interval.next_rotation, joint.child);
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

void JointTurns::derivative(const Interval& interval, MatrixXd& rate) {
  const Eigen::Index f = shape_basis_.cols();
  rate.setZero(size(), 2 * f);
  int before = -1;
  for (int c = 0; c < size(); ++c) {
    const Joint& joint = system_.joint(joint_of(c));
    if (joint_of(c) != before) {
      joint_rate_.setZero();
      if (joint.free()) {
        turns_of_bodies(interval, joint);
        algebra::set_product(ball_turn(interval, joint).derivative(), of_bodies_, joint_rate_);
      } else {
        const model::Body& child = system_.body(joint.child);
        const auto rows = shape_basis_.middleRows(shape_offset(child), child.freedoms);
        joint_rate_.topLeftCorner(child.freedoms, f) -= rows;
        joint_rate_.topRightCorner(child.freedoms, f) = rows;
      }
      before = joint_of(c);
    }
    const Vector3d down = -moment_[at(c)].direction;
    algebra::set_product(down.transpose(), joint_rate_, rate.row(c));
  }
}

void JointTurns::add_curvature(const Interval& interval, const VectorXd& pull, Eigen::Ref<MatrixXd> hessian) {
  const Eigen::Index f = shape_basis_.cols();
  pull_left_.setZero();
  pull_right_.setZero();
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    if (!joint.free()) continue;  // turns about axes are differences of angles
    Vector3d e = Vector3d::Zero();
    for (int c = 0; c < size(); ++c)
      if (joint_of(c) == j) e -= pull[c] * moment_[at(c)].direction;
    const BallTurn ball = ball_turn(interval, joint);
    turns_of_bodies(interval, joint);
    algebra::set_product(ball.curvature(e), of_bodies_, bent_);
    optimizer::set_transposed(of_bodies_, transposed_);
    optimizer::add_product(1.0, transposed_, bent_, hessian);
    const Eigen::Matrix<double, 12, 1> slope = ball.derivative().transpose() * e;
    pull_left_.segment<3>(3 * joint.parent) += slope.segment<3>(0);
    pull_left_.segment<3>(3 * joint.child) += slope.segment<3>(3);
    pull_right_.segment<3>(3 * joint.parent) += slope.segment<3>(6);
    pull_right_.segment<3>(3 * joint.child) += slope.segment<3>(9);
  }
  if (pull_left_.isZero(0.0)) return;
  turns_.add_curvature(interval.rotation, pull_left_, hessian.topLeftCorner(f, f));
  turns_.add_curvature(interval.next_rotation, pull_right_, hessian.bottomRightCorner(f, f));
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

}  // namespace lamprey::shape
