#include "maneuver/shape_step.hpp"

#include <cmath>

namespace lamprey::maneuver {

namespace {

using lie::hat;
using mechanics::Freedoms;
using mechanics::Rotations;
using model::at;
using model::System;

constexpr int most_iterations = 40;
constexpr double settled = 1e-15;    // of the largest momentum: as near to zero as sums of it come
constexpr double round_off = 1e-14;  // of inertia over time step, what rotations' round-off makes of momenta
constexpr double slow = 0.2;         // contraction that calls for a new inverse

// Coordinates of a shape out of freedoms of all bodies.
void read_shape(const System& system, const Freedoms& freedoms, Eigen::Ref<VectorXd> shape) {
  for (int i = 1; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) shape[shape_offset(system.body(i)) + f] = freedoms[at(i)][f];
}

void write_shape(const System& system, const VectorXd& shape, Freedoms& freedoms) {
  for (int i = 1; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) freedoms[at(i)][f] = shape[shape_offset(system.body(i)) + f];
}

}  // namespace

ShapeCoordinates::ShapeCoordinates(const System& system)
    : shape(MatrixXd::Identity(shape_size(system), shape_size(system))), pose(MatrixXd::Identity(6, 6)) {}

ShapeStep::ShapeStep(const System& system) : interval(system.body_count()) {}

template <typename Target>
void ShapeKernel::project(const Freedoms& freedoms, Target&& coordinates) {
  if (shape_ == along_.size()) {  // all coordinates: nothing to project
    read_shape(system_, freedoms, coordinates);
    return;
  }
  read_shape(system_, freedoms, along_);
  coordinates.noalias() = coordinates_.transpose() * along_;
}

void ShapeKernel::spread(const VectorXd& coordinates, Freedoms& freedoms) {
  along_.noalias() = coordinates_ * coordinates;
  write_shape(system_, along_, freedoms);
}

ShapeKernel::ShapeKernel(const System& system, mechanics::DiscreteLagrangian lagrangian, const MatrixXd& coordinates)
    : system_(system),
      lagrangian_(lagrangian),
      coordinates_(coordinates),
      shape_(static_cast<int>(coordinates.cols())),
      directions_(2 * shape_ + 6),
      no_moments_(at(system.joint_count()), Vector3d::Zero()),
      balance_(system.body_count()),
      direction_(at(directions_), mechanics::StepVariation(system)),
      rate_(at(directions_), mechanics::StepRate(system.body_count())),
      minus_(shape_, directions_),
      plus_(shape_, directions_),
      momentum_(6, directions_),
      multiplier_(system),
      multiplier_rate_(system.body_count()),
      second_(system.body_count()),
      by_left_(at(system.body_count())),
      by_right_(at(system.body_count())),
      along_(shape_size(system)),
      left_left_(MatrixXd::Zero(shape_size(system), shape_size(system))),
      turn_right_(MatrixXd::Zero(3, shape_size(system))),
      full_(directions_, directions_),
      map_(directions_, 2 * shape_),
      half_(directions_, 2 * shape_) {
  for (const model::Body& body : system.bodies()) {
    double reach = 0.0;  // m
    for (const model::PathPoint& point : body.path) reach += point.offset.norm();
    inertia_ = std::max(inertia_, body.inertia_matrix.norm() + body.mass_matrix.norm() * (reach + reach * reach));
  }
  for (int s = 0; s < shape_; ++s) {
    write_shape(system, coordinates.col(s), direction_[at(s)].left);
    write_shape(system, coordinates.col(s), direction_[at(shape_ + s)].right);
  }
}

// Total angular momentum about the root's mass centre and total linear momentum, seen from the root at the beginning.
Vector6d ShapeKernel::momentum(const ShapeStep& step) const {
  const Rotations& R = step.interval.rotation;
  Vector3d angular = Vector3d::Zero();
  for (int i = 0; i < system_.body_count(); ++i)
    if (free(i)) angular += R[at(i)] * balance_.minus[at(i)];
  Vector6d both;
  both << R[0].transpose() * angular, R[0].transpose() * balance_.linear;
  return both;
}

bool ShapeKernel::solve(double time_step, const Rotations& left, const Rotations& next_shape, ShapeStep& step) {
  const mechanics::ForcedStep forced{system_, lagrangian_, time_step, step.interval, no_moments_, no_moments_};
  double before = std::numeric_limits<double>::infinity();
  bool renewed = false;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Matrix3d root = left[0] * step.root_turn;
    next_ = next_shape;
    for (Matrix3d& R : next_) R = root * R;
    mechanics::interval_between(system_, left, next_, left[0] * step.root_shift, step.interval);
    evaluate_balance(forced, balance_);
    const Vector6d missed = momentum(step);
    double scale = 0.0;
    for (int i = 0; i < system_.body_count(); ++i)
      scale = std::max({scale, balance_.minus[at(i)].lpNorm<Eigen::Infinity>(),
                        balance_.momenta.impulse[at(i)].lpNorm<Eigen::Infinity>()});
    const double residual = missed.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(residual)) return false;
    const double noise = round_off * inertia_ / std::abs(time_step);
    if (residual <= settled * scale || (residual <= noise && residual >= 0.5 * before)) {
      step.minus.resize(shape_);
      step.plus.resize(shape_);
      project(balance_.minus, step.minus);
      project(balance_.plus, step.plus);
      step.momentum = missed;
      step.largest_momentum = 0.0;
      for (const Vector3d& own : balance_.minus) step.largest_momentum = std::max(step.largest_momentum, own.norm());
      return true;
    }
    if (step.momentum_inverse.isZero(0.0) || (residual > slow * before && !renewed)) {
      lay_directions(step);
      for (int d = 2 * shape_; d < directions_; ++d)
        evaluate_rate(forced, balance_, direction_[at(d)], mechanics::RateKind::tangent, rate_[at(d)]);
      measure(step, 2 * shape_);
      step.momentum_inverse = Matrix6d(momentum_.rightCols<6>()).inverse();
      if (!step.momentum_inverse.allFinite()) return false;
      renewed = true;
    } else {
      renewed = false;
    }
    const Vector6d change = step.momentum_inverse * missed;
    const double turned = change.head<3>().norm();
    if (!(turned < 10.0)) return false;
    const double share = turned > 0.5 ? 0.5 / turned : 1.0;
    step.root_turn = step.root_turn * lie::cayley(-0.5 * share * change.head<3>());
    step.root_shift -= share * change.tail<3>();
    before = residual;
  }
  return false;
}

// Directions of the root's turn and shift: all bodies turn with it at the end.
void ShapeKernel::lay_directions(const ShapeStep& step) {
  const mechanics::Interval& interval = step.interval;
  for (int c = 0; c < 3; ++c) {
    const Vector3d turn = interval.next_rotation[0].col(c);
    for (int i = 0; i < system_.body_count(); ++i)
      if (free(i)) direction_[at(2 * shape_ + c)].right[at(i)] = interval.next_rotation[at(i)].transpose() * turn;
    direction_[at(2 * shape_ + 3 + c)].displacement = interval.rotation[0].col(c);
  }
}

// Rates of E⁻, E⁺ and total momentum of the directions from `first` on.
void ShapeKernel::measure(const ShapeStep& step, int first) {
  const Rotations& R = step.interval.rotation;
  for (int d = first; d < directions_; ++d) {
    const mechanics::StepRate& rate = rate_[at(d)];
    project(rate.minus, minus_.col(d));
    project(rate.plus, plus_.col(d));
    Vector3d angular = Vector3d::Zero();
    for (int i = 0; i < system_.body_count(); ++i) {
      if (!free(i)) continue;
      Vector3d own = rate.minus[at(i)];
      if (i > 0) own += direction_[at(d)].left[at(i)].cross(balance_.minus[at(i)]);  // the body's frame turns
      angular += R[at(i)] * own;
    }
    momentum_.col(d).head<3>() = R[0].transpose() * angular;
    momentum_.col(d).tail<3>() = R[0].transpose() * rate.linear;
  }
}

void ShapeKernel::tangent(double time_step, const mechanics::Moments& control, const mechanics::Moments& control_next,
                          ShapeStep& step, ShapeTangent& tangent) {
  const mechanics::ForcedStep forced{system_, lagrangian_, time_step, step.interval, control, control_next};
  evaluate_balance(forced, balance_);
  lay_directions(step);
  for (int d = 0; d < directions_; ++d)
    evaluate_rate(forced, balance_, direction_[at(d)], mechanics::RateKind::tangent, rate_[at(d)]);
  measure(step, 0);
  step.momentum_inverse = Matrix6d(momentum_.rightCols<6>()).inverse();
  const auto ends = 2 * shape_;
  tangent.root.noalias() = -step.momentum_inverse * momentum_.leftCols(ends);
  tangent.pose.resize(6, ends);
  tangent.pose.topRows<3>() = step.interval.next_rotation[0] * tangent.root.topRows<3>();
  tangent.pose.bottomRows<3>() = step.interval.rotation[0] * tangent.root.bottomRows<3>();
  tangent.minus = minus_.leftCols(ends);
  tangent.minus.noalias() += minus_.rightCols<6>() * tangent.root;
  tangent.plus = plus_.leftCols(ends);
  tangent.plus.noalias() += plus_.rightCols<6>() * tangent.root;
}

void ShapeKernel::curvature(double time_step, const mechanics::Moments& control, const mechanics::Moments& control_next,
                            const ShapeStep& step, const ShapeTangent& tangent, const ShapeMultipliers& m,
                            MatrixXd& hessian) {
  const mechanics::ForcedStep forced{system_, lagrangian_, time_step, step.interval, control, control_next};
  const mechanics::Interval& interval = step.interval;
  const Matrix3d& R = interval.rotation[0];
  const Matrix3d& R_next = interval.next_rotation[0];
  const int turn = 2 * shape_;

  // the momentum's multipliers π make the Lagrangian stationary in the root's motion
  Vector6d pull = minus_.rightCols<6>().transpose() * m.minus - plus_.rightCols<6>().transpose() * m.plus;
  pull.head<3>() += R_next.transpose() * m.turn;
  pull.tail<3>() += R.transpose() * m.shift;
  const Vector6d pi = -step.momentum_inverse.transpose() * pull;
  const Vector3d spin = R * pi.head<3>();  // world

  spread(-m.minus, multiplier_.left);
  spread(-m.plus, multiplier_.right);
  multiplier_.left[0].setZero();
  multiplier_.right[0].setZero();
  for (int i = 0; i < system_.body_count(); ++i)
    if (free(i)) multiplier_.left[at(i)] -= interval.rotation[at(i)].transpose() * spin;
  multiplier_.displacement = R * pi.tail<3>();
  evaluate_rate(forced, balance_, multiplier_, mechanics::RateKind::adjoint, multiplier_rate_);

  // at constant coefficients, a column for each direction
  for (int d = 0; d < directions_; ++d) {
    evaluate_adjoint_rate(forced, balance_, multiplier_, multiplier_rate_, direction_[at(d)], rate_[at(d)], second_,
                          by_left_, by_right_, linear_);
    auto column = full_.col(d);
    project(by_left_, column.head(shape_));
    project(by_right_, column.segment(shape_, shape_));
    Vector3d whole = Vector3d::Zero();
    for (int i = 0; i < system_.body_count(); ++i)
      if (free(i)) whole += interval.next_rotation[at(i)] * by_right_[at(i)];
    column.segment<3>(turn) = R_next.transpose() * whole;
    column.tail<3>() = R.transpose() * linear_;
  }
  full_ = (0.5 * (full_ + full_.transpose())).eval();

  // the coefficients Q_iᵀπ turn with the shape at the beginning
  for (int d = 0; d < directions_; ++d) {
    along_.setZero();
    for (int i = 1; i < system_.body_count(); ++i)
      if (free(i))
        along_.segment<3>(shape_offset(system_.body(i))) =
            rate_[at(d)].minus[at(i)].cross(interval.rotation[at(i)].transpose() * spin);
    const VectorXd turned = coordinates_.transpose() * along_;
    full_.col(d).head(shape_) += turned;
    full_.row(d).head(shape_) += turned.transpose();
  }
  for (int i = 1; i < system_.body_count(); ++i) {
    if (!free(i)) continue;
    const int s = shape_offset(system_.body(i));
    left_left_.block<3, 3>(s, s) =
        lie::double_cross(balance_.minus[at(i)], interval.rotation[at(i)].transpose() * spin);
    // root's turn first, then the shape's: exp(α) exp(θ) = exp(α + θ + ½ α × θ + …), α = Q_iᵀ φ
    const Matrix3d frame = R_next.transpose() * interval.next_rotation[at(i)];
    turn_right_.middleCols<3>(s) = -0.5 * frame * hat(multiplier_rate_.plus[at(i)]);
  }
  full_.topLeftCorner(shape_, shape_) += coordinates_.transpose() * left_left_ * coordinates_;
  const MatrixXd bracket = turn_right_ * coordinates_;
  full_.block(turn, shape_, 3, shape_) += bracket;
  full_.block(shape_, turn, shape_, 3) += bracket.transpose();

  map_.topRows(2 * shape_).setIdentity();
  map_.bottomRows<6>() = tangent.root;
  half_.noalias() = full_ * map_;
  hessian.topLeftCorner(2 * shape_, 2 * shape_).noalias() = map_.transpose() * half_;

  // the world's view: ρ' = ρ + R'φ + ½ ρ × R'φ, x' = x + exp(ρ̂)(Δx + R d)
  const Vector3d& shift = interval.displacement;
  const auto by_turn = tangent.root.topRows<3>();
  const auto by_shift = tangent.root.bottomRows<3>();
  auto coupling = hessian.bottomLeftCorner(3, 2 * shape_);
  coupling.noalias() = -0.5 * hat(m.turn) * R_next * by_turn;
  coupling.noalias() -= hat(m.shift) * R * by_shift;
  hessian.topRightCorner(2 * shape_, 3) = coupling.transpose();
  hessian.bottomRightCorner<3, 3>() = lie::double_cross(m.shift, shift);
}

double momentum_left(const std::vector<ShapeStep>& steps, const std::vector<Rotations>& rotation,
                     const mechanics::Vectors& position) {
  double left = 0.0, scale = 0.0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Matrix3d& R = rotation[k][0];
    const Vector3d linear = R * steps[k].momentum.tail<3>();
    const Vector3d angular = R * steps[k].momentum.head<3>() + position[k].cross(linear);
    left = std::max({left, linear.norm(), angular.norm()});
    scale = std::max(scale, steps[k].largest_momentum);
  }
  return left == 0.0 ? 0.0 : left / scale;
}

void move_shape(const System& system, const Rotations& shape, const VectorXd& along, mechanics::Interval& buffer,
                Rotations& moved) {
  buffer.rotation = shape;
  for (Vector3d& v : buffer.cayley) v.setZero();
  for (Vector3d& v : buffer.joint_turn) v.setZero();
  for (int i = 1; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) {
      buffer.cayley[at(i)] = 0.5 * along.segment<3>(shape_offset(body));
      continue;
    }
    for (int f = 0; f < body.freedoms; ++f) buffer.joint_turn[at(i)][f] = along[shape_offset(body) + f];
  }
  buffer.displacement.setZero();
  mechanics::update_interval(system, buffer);
  moved = buffer.next_rotation;
  for (Matrix3d& R : moved) R = lie::renormalized(R);
}

}  // namespace lamprey::maneuver
