// Second derivatives of a step (chapter 9, equations 9.8, 9.9 and 9.36; in free time 10.14).
#include "optimizer/small_dense.hpp"
#include "shape/pose_at_end.hpp"
#include "shape/shape_step.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Index;
using lie::hat;
using maneuver::shape_offset;
using mechanics::Rotations;
using model::at;
using optimizer::add_image;
using optimizer::add_product;
using optimizer::add_product_transposed;
using optimizer::set_transposed;

// C += ½ (A + Aᵀ).
void add_symmetric_part(const Eigen::Ref<const MatrixXd>& A, Eigen::Ref<MatrixXd> C) {
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < A.rows(); ++i) C(i, j) += 0.5 * (A(i, j) + A(j, i));
}

}  // namespace

// The motion along which the Lagrangian's momenta are weighed.
void ShapeKernel::lay_multiplier(const ShapeStep& step, const Vector6d& pi, const ShapeMultipliers& m) {
  const Rotations& rotation = step.interval.rotation;
  const Vector3d spin = rotation[0] * pi.head<3>();  // world
  multiplier_.left[0].setZero();
  spread(m.minus, multiplier_.left);
  spread(m.plus, multiplier_.right);
  for (Vector3d& turn : multiplier_.left) turn = -turn;
  for (Vector3d& turn : multiplier_.right) turn = -turn;
  for (int i = 0; i < system_.body_count(); ++i)
    if (free(i)) multiplier_.left[at(i)] -= rotation[at(i)].transpose() * spin;
  multiplier_.displacement = rotation[0] * pi.tail<3>();
}

// The coefficients Q_iᵀπ turn with the shape at the beginning.
void ShapeKernel::add_changes_of_coefficients(const ShapeStep& step, const Vector3d& spin) {
  const mechanics::RowRange by_left(left_rows_), by_right(left_rows_, rows_);
  for (int i = 1; i < system_.body_count(); ++i) {
    if (!free(i)) continue;
    const Vector3d seen = step.interval.rotation[at(i)].transpose() * spin;
    // and so do, along the shape at the beginning, the derivatives by it: what is symmetrised counts twice
    mechanics::add_product(-2.0 * hat(seen), rate_.minus[at(i)], by_left, second_.minus[at(i)]);
    mechanics::add_product(-hat(seen), rate_.minus[at(i)], by_right, second_.minus[at(i)]);
    const int s = shape_offset(system_.body(i));
    left_left_.block<3, 3>(s, s) = lie::double_cross(balance_.minus[at(i)], seen);
  }
}

// By rows of directions; by the right shape and the root's motion along these alone, the rest is symmetric.
void ShapeKernel::read_second_rates(const ShapeStep& step) {
  const mechanics::RowRange by_right(left_rows_, rows_);
  const Rotations& R_next = step.interval.next_rotation;
  mechanics::clear_rows(by_right, angular_);
  for (int i = 0; i < system_.body_count(); ++i)
    if (free(i)) mechanics::add_product(R_next[0].transpose() * R_next[at(i)], second_.plus[at(i)], by_right, angular_);
  mechanics::set_product(step.interval.rotation[0].transpose(), second_.linear, by_right, linear_);
  for (int c = 0; c < 3; ++c) {
    pack(angular_, c, by_root_.col(c));
    pack(linear_, c, by_root_.col(3 + c));
  }
  project_rows(second_.minus, by_left_);
  project_rows(second_.plus, by_right_);

  for (int i = 1; i < system_.body_count(); ++i) {
    if (!free(i)) continue;
    // root's turn first, then the shape's: exp(α) exp(θ) = exp(α + θ + ½ α × θ + …), α = Q_iᵀ φ
    turn_right_.middleRows<3>(shape_offset(system_.body(i))) =
        0.5 * hat(multiplier_rate_.plus[at(i)]) * (R_next[at(i)].transpose() * R_next[0]);
  }
}

// By both shapes and, where momentum is carried, the root's pose, the root's motion following them.
void ShapeKernel::assemble_hessian(MatrixXd& hessian) {
  const Index n = shape_, ends = 2 * n;
  auto whole = hessian.topLeftCorner(by_, by_);
  if (by_ > ends) whole.setZero();
  auto left = whole.topLeftCorner(n, n);
  if (all_coordinates()) {
    left = left_left_;
    turn_shape_ = turn_right_;
  } else {
    algebra::set_product(left_left_, coordinates_, left_half_);
    algebra::set_product(coordinates_.transpose(), left_half_, left);
    algebra::set_product(coordinates_.transpose(), turn_right_, turn_shape_);
  }
  add_symmetric_part(by_left_.topRows(n), left);
  whole.block(n, 0, n, n) = by_left_.middleRows(n, n);
  set_transposed(by_left_.middleRows(n, n), whole.block(0, n, n, n));
  auto right = whole.block(n, n, n, n);
  right.setZero();
  add_symmetric_part(by_right_.middleRows(n, n), right);

  const Matrix6d root = 0.5 * (by_root_.bottomRows<6>() + by_root_.bottomRows<6>().transpose());
  ends_root_.bottomRows(by_ - ends).setZero();
  set_transposed(by_left_.bottomRows<6>(), ends_root_.topRows(n));
  set_transposed(by_right_.bottomRows<6>(), ends_root_.middleRows(n, n));
  ends_root_.middleRows(n, n) += by_root_.middleRows(n, n);
  ends_root_.middleRows(n, n) *= 0.5;
  ends_root_.block(n, 0, n, 3) += turn_shape_;
  add_product(0.5, root_, root, ends_root_);
  add_product_transposed(1.0, ends_root_, root_, whole);
  add_product_transposed(1.0, root_, ends_root_, whole);
}

void ShapeKernel::curvature(double time_step, const mechanics::Moments& control, const mechanics::Moments& control_next,
                            const ShapeStep& step, const ShapeMultipliers& m, MatrixXd& hessian) {
  const mechanics::ForcedStep forced{system_, lagrangian_, time_step, step.interval, control, control_next};
  const Matrix3d& R = step.interval.rotation[0];
  const Matrix3d& R_next = step.interval.next_rotation[0];

  // the momentum's multipliers π make the Lagrangian stationary in the root's motion
  Vector6d pull;
  pull << R_next.transpose() * m.turn, R.transpose() * m.shift;
  add_image(1.0, minus_.bottomRows<6>(), m.minus, pull);
  add_image(-1.0, plus_.bottomRows<6>(), m.plus, pull);
  const Vector6d pi = -step.momentum_inverse.transpose() * pull;

  lay_multiplier(step, pi, m);
  evaluate_rate(forced, balance_, multiplier_, mechanics::RateKind::adjoint, multiplier_rate_);
  mechanics::adjoint_rates(forced, balance_, block_, body_rate_, multiplier_, multiplier_rate_, direction_, rate_,
                           left_rows_, rows_, second_);
  add_changes_of_coefficients(step, R * pi.head<3>());
  read_second_rates(step);
  assemble_hessian(hessian);
  if (by_ > 2 * shape_) return add_changes_of_carried(step, pi, m.turn, m.shift, hessian);

  // the world's view: ρ' = ρ + R'φ + ½ ρ × R'φ, x' = x + exp(ρ̂)(Δx + R d)
  const int ends = 2 * shape_;
  auto coupling = hessian.topRightCorner(ends, 3);
  coupling = pose_.leftCols<3>().lazyProduct(0.5 * hat(m.turn));
  coupling += pose_.rightCols<3>().lazyProduct(hat(m.shift));
  set_transposed(coupling, hessian.bottomLeftCorner(3, ends));
  hessian.bottomRightCorner<3, 3>() = lie::double_cross(m.shift, step.interval.displacement);
}

// The world's view where momentum is carried: the root's motion answers to its pose at the beginning as well, and what is carried
// is seen from there, exp(−ρ̂)(L − χ × P) and exp(−ρ̂) P.
void ShapeKernel::add_changes_of_carried(const ShapeStep& step, const Vector6d& pi, const Vector3d& turn,
                                         const Vector3d& shift, MatrixXd& hessian) const {
  const Index place = 2 * Index{shape_};
  const MatrixXd& pose = pose_;
  auto by_turn = hessian.middleCols(place, 3);
  auto turn_by = hessian.middleRows(place, 3);
  for (Index r = 0; r < by_; ++r) {
    const Vector3d coupled = -0.5 * turn.cross(pose.row(r).head<3>().transpose().eval()) -
                             shift.cross(pose.row(r).tail<3>().transpose().eval());
    by_turn.row(r) += coupled.transpose();
    turn_by.col(r) += coupled;
  }
  const Matrix3d& R = step.interval.rotation[0];
  const Vector3d spin = R * pi.head<3>(), push = R * pi.tail<3>();
  hessian.block<3, 3>(place, place) += lie::double_cross(shift, step.interval.displacement);
  hessian.block<6, 6>(place, place) -= bend_of_seen(spin, push, angular_carried_, linear_carried_);
  if (by_ == place + 6) return;
  const Vector6d mixed = seen_by_pose(R, angular_carried_, linear_carried_).transpose() * pi;
  hessian.block<6, 1>(place, place + 6) -= mixed;
  hessian.block<1, 6>(place + 6, place) -= mixed.transpose();
  hessian(place + 6, place + 6) -= pi.dot(step.carried);
}

}  // namespace lamprey::shape
