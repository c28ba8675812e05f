#include "shape/shape_step.hpp"

#include <cmath>

#include "optimizer/small_dense.hpp"
#include "shape/pose_at_end.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Index;
using maneuver::read_shape;
using maneuver::shape_offset;
using maneuver::shape_size;
using maneuver::write_shape;
using mechanics::FreedomRows;
using mechanics::Freedoms;
using mechanics::Rotations;
using mechanics::Rows3;
using model::at;
using model::System;
using optimizer::add_product;
using optimizer::add_product_transposed;
using optimizer::set_transposed;

constexpr int most_iterations = 40;
constexpr double least_learning = 0.1;  // cosine and length of what the inverse foretells, against what was
constexpr double slow = 0.2;            // contraction that calls for a new inverse

// Beside those of shapes.
Index columns_of(TotalMomentum carries) {
  return carries == TotalMomentum::zero ? 0 : carries == TotalMomentum::any ? 6 : 7;
}

}  // namespace

MomentumNoise::MomentumNoise(const System& system) : length(system.length_unit()) {
  for (const model::Body& body : system.bodies()) {
    double reach = 0.0;  // m
    for (const model::PathPoint& point : body.path) reach += point.offset.norm();
    inertia = std::max(inertia, body.inertia_matrix.norm() + body.mass_matrix.norm() * (length + reach) * reach);
  }
}

ShapeStep ShapeStep::of_root() {
  ShapeStep step{mechanics::Interval(0)};
  step.interval.rotation.assign(1, Matrix3d::Identity());
  step.interval.next_rotation.assign(1, Matrix3d::Identity());
  return step;
}

ShapeKernel::ShapeKernel(const System& system, mechanics::DiscreteLagrangian lagrangian, const MatrixXd& coordinates,
                         TotalMomentum carries)
    : system_(system),
      lagrangian_(lagrangian),
      coordinates_(coordinates),
      noise_(system),
      shape_(static_cast<int>(coordinates.cols())),
      by_(2 * shape_ + columns_of(carries)),
      directions_(2 * shape_ + 6),
      left_rows_(mechanics::rows_for(shape_)),
      rows_(left_rows_ + shape_ + 6),
      no_moments_(at(system.joint_count()), Vector3d::Zero()),
      balance_(system.body_count()),
      block_(at(system.body_count())),
      body_rate_(at(system.body_count())),
      direction_(system.body_count(), rows_),
      rate_(system.body_count(), rows_),
      second_(system.body_count(), rows_),
      angular_(mechanics::rows_for(rows_), 3),
      linear_(mechanics::rows_for(rows_), 3),
      minus_(directions_, shape_),
      plus_(directions_, shape_),
      momentum_(directions_, 6),
      root_(by_, 6),
      pose_(by_, 6),
      ends_(by_, shape_),
      multiplier_(system),
      multiplier_rate_(system.body_count()),
      next_(at(system.body_count())),
      lever_(at(system.body_count())),
      along_(shape_size(system)),
      along_rows_(directions_, shape_size(system)),
      by_left_(directions_, shape_),
      by_right_(directions_, shape_),
      by_root_(directions_, 6),
      left_left_(MatrixXd::Zero(shape_size(system), shape_size(system))),
      left_half_(shape_size(system), shape_),
      turn_right_(MatrixXd::Zero(shape_size(system), 3)),
      turn_shape_(shape_, 3),
      ends_root_(by_, 6) {
  for (int i = 1; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) {
      const auto row = coordinates.row(shape_offset(system.body(i)) + f).transpose();
      direction_.left[at(i)].col(f).head(shape_) = row;
      direction_.right[at(i)].col(f).segment(left_rows_, shape_) = row;
    }
  const mechanics::RowRange root_turns(left_rows_ + shape_, left_rows_ + shape_ + 3);
  direction_.left_support[0] = {-1, {0}};
  direction_.right_support[0] = {-1, root_turns};
  for (int i = 1; i < system.body_count() && all_coordinates(); ++i) {
    if (!free(i)) continue;
    const Index place = shape_offset(system.body(i));
    direction_.left_support[at(i)] = {place, {0}};
    direction_.right_support[at(i)] = {left_rows_ + place, root_turns};
  }
}

// One coordinate of rows, a direction beside the other.
void ShapeKernel::pack(const Rows3& rows, int coordinate, Eigen::Ref<VectorXd> column) const {
  const double* from = rows.data() + coordinate * rows.rows();
  std::copy_n(from, shape_, column.data());
  std::copy_n(from + left_rows_, shape_ + 6, column.data() + shape_);
}

// Along the coordinates of shapes, [directions][f].
void ShapeKernel::project_rows(const FreedomRows& rows, MatrixXd& result) {
  MatrixXd& along = all_coordinates() ? result : along_rows_;
  for (int i = 1; i < system_.body_count(); ++i)
    for (int f = 0; f < system_.body(i).freedoms; ++f)
      pack(rows[at(i)], f, along.col(shape_offset(system_.body(i)) + f));
  if (all_coordinates()) return;
  result.setZero();
  add_product(1.0, along_rows_, coordinates_, result);
}

void ShapeKernel::project(const Freedoms& freedoms, VectorXd& coordinates) {
  if (all_coordinates()) {
    read_shape(system_, freedoms, coordinates);
    return;
  }
  read_shape(system_, freedoms, along_);
  algebra::set_product(coordinates_.transpose(), along_, coordinates);
}

void ShapeKernel::spread(const VectorXd& coordinates, Freedoms& freedoms) {
  if (all_coordinates()) return write_shape(system_, coordinates, freedoms);
  algebra::set_product(coordinates_, coordinates, along_);
  write_shape(system_, along_, freedoms);
}

void ShapeKernel::find_levers(const Rotations& left) {
  for (int i = 1; i < system_.body_count(); ++i) {
    const model::Joint& up = system_.joint(system_.body(i).joint);
    lever_[at(i)] = left[at(up.parent)] * up.parent_offset - left[at(i)] * up.child_offset;
  }
}

// Total angular momentum about the root's mass centre and total linear momentum, seen from the root at the beginning;
// scale: the largest of what is summed, linear ones by their length.
Vector6d ShapeKernel::momentum(const mechanics::Interval& interval, double& scale) const {
  const mechanics::DiscreteMomenta& p = balance_.momenta;
  Vector3d angular = Vector3d::Zero();
  scale = 0.0;
  for (int i = 0; i < system_.body_count(); ++i) {
    const std::size_t n = at(i);
    const Vector3d own = interval.rotation[n] * p.own_minus[n];
    angular += own;
    scale = std::max({scale, own.lpNorm<Eigen::Infinity>(), noise_.length * p.impulse[n].lpNorm<Eigen::Infinity>()});
    if (i == 0) continue;
    const Vector3d by_force = lever_[n].cross(p.subtree_linear[n]);
    angular += by_force;
    scale = std::max(scale, by_force.lpNorm<Eigen::Infinity>());
  }
  Vector6d both;
  both << interval.rotation[0].transpose() * angular, interval.rotation[0].transpose() * p.linear;
  return both;
}

bool ShapeKernel::solve(double time_step, const Rotations& left, const Rotations& next_shape, ShapeStep& step,
                        const Vector6d& total) {
  const mechanics::ForcedStep forced{system_, lagrangian_, time_step, step.interval, no_moments_, no_moments_};
  double before = std::numeric_limits<double>::infinity();
  bool renewed = false;
  Vector6d missed_before = Vector6d::Zero(), moved = Vector6d::Zero();
  find_levers(left);
  step.carried = total;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Matrix3d root = left[0] * step.root_turn;
    for (std::size_t i = 0; i < next_.size(); ++i) next_[i].noalias() = root * next_shape[i];
    mechanics::interval_between(system_, left, next_, left[0] * step.root_shift, step.interval);
    mechanics::body_momenta(system_, lagrangian_, time_step, step.interval, balance_.momenta);
    double scale = 0.0;
    const Vector6d missed = momentum(step.interval, scale) - total;
    const double residual = std::max(missed.head<3>().lpNorm<Eigen::Infinity>(),
                                     noise_.length * missed.tail<3>().lpNorm<Eigen::Infinity>());
    if (!std::isfinite(residual)) return false;
    const double noise = noise_.of_rotations(time_step);
    const bool at_noise = residual <= noise && (residual >= 0.5 * before || iteration + 1 == most_iterations);
    if (residual <= MomentumNoise::of_sums * scale || at_noise) {
      read_balance(forced, step);
      return true;
    }
    if (iteration > 0 && residual > noise) learn_inverse(moved, missed - missed_before, step.momentum_inverse);
    if (step.momentum_inverse.isZero(0.0) || (residual > std::max(slow * before, noise) && !renewed)) {
      gather_balance(forced, balance_);
      measure_rates(forced, step);
      if (!find_momentum_inverse(step)) return false;
      renewed = true;
    } else {
      renewed = false;
    }
    const Vector6d change = step.momentum_inverse * missed;
    const double turned = change.head<3>().norm();
    if (!(turned < 10.0)) return false;
    const double share = turned > 0.5 ? 0.5 / turned : 1.0;
    moved = -share * change;
    step.root_turn = step.root_turn * lie::cayley(0.5 * moved.head<3>());
    step.root_shift += moved.tail<3>();
    missed_before = missed;
    before = residual;
  }
  return false;
}

// Broyden's update: the inverse maps the change of momentum to the motion that made it, shifts counted by their length.
void ShapeKernel::learn_inverse(const Vector6d& moved, const Vector6d& change, Matrix6d& inverse) const {
  const Vector6d foretold = inverse * change;
  Vector6d weighed = moved;
  weighed.tail<3>() /= noise_.length * noise_.length;
  const double share = weighed.dot(foretold);
  if (share < least_learning * weighed.dot(moved)) return;
  const Vector6d row = inverse.transpose() * weighed, learnt = (moved - foretold) / share;
  for (int c = 0; c < 6; ++c) inverse.col(c) += row[c] * learnt;
}

// What a solved step keeps: E⁻ and E⁺ along the coordinates, and the momentum that all bodies have.
void ShapeKernel::read_balance(const mechanics::ForcedStep& forced, ShapeStep& step) {
  const Rotations& R = step.interval.rotation;
  gather_balance(forced, balance_);
  step.minus.resize(shape_);
  step.plus.resize(shape_);
  project(balance_.minus, step.minus);
  project(balance_.plus, step.plus);
  Vector3d angular = Vector3d::Zero();
  step.largest_momentum = 0.0;
  for (int i = 0; i < system_.body_count(); ++i) {
    const Vector3d& own = balance_.minus[at(i)];
    if (free(i)) angular += R[at(i)] * own;
    step.largest_momentum = std::max(step.largest_momentum, own.norm());
  }
  step.momentum << R[0].transpose() * angular, R[0].transpose() * balance_.linear;
}

// Rates of E⁻, E⁺ and total momentum along all directions. Where the root turns or shifts at the end, all bodies do.
void ShapeKernel::measure_rates(const mechanics::ForcedStep& forced, const ShapeStep& step) {
  const Rotations& R = step.interval.rotation;
  const Rotations& R_next = step.interval.next_rotation;
  const Index turn = left_rows_ + shape_;
  for (int i = 0; i < system_.body_count(); ++i)
    if (free(i)) direction_.right[at(i)].block<3, 3>(turn, 0) = R_next[0].transpose() * R_next[at(i)];
  direction_.displacement.block<3, 3>(turn + 3, 0) = R[0].transpose();
  mechanics::body_rates(forced, balance_.momenta, block_, body_rate_);
  mechanics::rates_at_both_ends(forced, balance_, block_, body_rate_, direction_, left_rows_, rows_, rate_);

  mechanics::clear_rows(rows_, angular_);
  for (int i = 0; i < system_.body_count(); ++i) {
    if (!free(i)) continue;
    const Matrix3d seen = R[0].transpose() * R[at(i)];
    mechanics::add_product(seen, rate_.minus[at(i)], rows_, angular_);
    if (i > 0)  // the body's frame turns
      mechanics::add_product(-lie::times_hat(seen, balance_.minus[at(i)]), direction_.left[at(i)], left_rows_,
                             angular_);
  }
  mechanics::set_product(R[0].transpose(), rate_.linear, rows_, linear_);
  for (int c = 0; c < 3; ++c) {
    pack(angular_, c, momentum_.col(c));
    pack(linear_, c, momentum_.col(3 + c));
  }
}

// Of the two three-row halves the shift's is always well conditioned: it is condensed away.
bool ShapeKernel::find_momentum_inverse(ShapeStep& step) const {
  const Matrix6d by_root = momentum_.bottomRows<6>().transpose();
  const Matrix3d shift_inverse = by_root.bottomRightCorner<3, 3>().inverse();
  const Matrix3d from_turn = shift_inverse * by_root.bottomLeftCorner<3, 3>();
  const Matrix3d to_angular = by_root.topRightCorner<3, 3>() * shift_inverse;
  const Matrix3d turn_inverse = (by_root.topLeftCorner<3, 3>() - by_root.topRightCorner<3, 3>() * from_turn).inverse();
  Matrix6d& inverse = step.momentum_inverse;
  inverse.topLeftCorner<3, 3>() = turn_inverse;
  inverse.topRightCorner<3, 3>() = -turn_inverse * to_angular;
  inverse.bottomLeftCorner<3, 3>() = -from_turn * turn_inverse;
  inverse.bottomRightCorner<3, 3>() = shift_inverse + from_turn * turn_inverse * to_angular;
  return inverse.allFinite();
}

void ShapeKernel::tangent(double time_step, const mechanics::Moments& control, const mechanics::Moments& control_next,
                          ShapeStep& step, ShapeTangent& tangent) {
  const mechanics::ForcedStep forced{system_, lagrangian_, time_step, step.interval, control, control_next};
  evaluate_balance(forced, balance_);
  measure_rates(forced, step);
  project_rows(rate_.minus, minus_);
  project_rows(rate_.plus, plus_);
  find_momentum_inverse(step);
  const Index ends = 2 * shape_;
  root_.setZero();
  add_product_transposed(-1.0, momentum_.topRows(ends), step.momentum_inverse, root_.topRows(ends));
  if (by_ > ends) find_carried(step);
  tangent.pose.resize(6, by_);
  tangent.minus.resize(shape_, by_);
  tangent.plus.resize(shape_, by_);
  pose_.leftCols<3>() = root_.leftCols<3>().lazyProduct(step.interval.next_rotation[0].transpose());
  pose_.rightCols<3>() = root_.rightCols<3>().lazyProduct(step.interval.rotation[0].transpose());
  set_transposed(pose_, tangent.pose);
  const Index pose = by_ - ends;
  ends_.topRows(ends) = minus_.topRows(ends);
  ends_.bottomRows(pose).setZero();
  add_product(1.0, root_, minus_.bottomRows<6>(), ends_);
  set_transposed(ends_, tangent.minus);
  ends_.topRows(ends) = plus_.topRows(ends);
  ends_.bottomRows(pose).setZero();
  add_product(1.0, root_, plus_.bottomRows<6>(), ends_);
  set_transposed(ends_, tangent.plus);
}

// What is carried, seen from the root at the beginning, as that turns and moves, or as more is carried: the root's motion answers.
void ShapeKernel::find_carried(const ShapeStep& step) {
  const Matrix3d& R = step.interval.rotation[0];
  angular_carried_ = R * step.carried.head<3>();
  linear_carried_ = R * step.carried.tail<3>();
  const Index ends = 2 * Index{shape_};
  root_.middleRows<6>(ends) = (step.momentum_inverse * seen_by_pose(R, angular_carried_, linear_carried_)).transpose();
  if (by_ > ends + 6) root_.row(ends + 6) = (step.momentum_inverse * step.carried).transpose();
}

void follow_root(const Rotations& rotation, const Rotations& next_shape, ShapeStep& step, Rotations& next_rotation) {
  next_rotation[0] = lie::renormalized(rotation[0] * step.root_turn);
  for (std::size_t i = 1; i < next_rotation.size(); ++i) next_rotation[i] = next_rotation[0] * next_shape[i];
  step.interval.displacement = rotation[0] * step.root_shift;
  step.interval.rotation[0] = rotation[0];
  step.interval.next_rotation[0] = next_rotation[0];
}

bool turns_too_far(const Rotations& from, const Rotations& to) {
  constexpr double trace_of_quarter_turn = 1.0;
  for (std::size_t i = 0; i < from.size(); ++i)
    if (!(from[i].cwiseProduct(to[i]).sum() > trace_of_quarter_turn)) return true;
  return false;
}

double momentum_left(const System& system, const std::vector<ShapeStep>& steps, const std::vector<Rotations>& rotation,
                     const mechanics::Vectors& position, const mechanics::SpatialMomentum& total) {
  double left = 0.0, scale = std::max(total.angular.norm(), system.length_unit() * total.linear.norm());
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Matrix3d& R = rotation[k][0];
    const Vector3d linear = R * steps[k].momentum.tail<3>();
    const Vector3d angular = R * steps[k].momentum.head<3>() + (position[k] - position[0]).cross(linear);
    left = std::max({left, system.length_unit() * (linear - total.linear).norm(), (angular - total.angular).norm()});
    scale = std::max(scale, steps[k].largest_momentum);
  }
  return left == 0.0 ? 0.0 : left / scale;
}

}  // namespace lamprey::shape
