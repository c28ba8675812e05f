#include "maneuver/limit_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamprey::maneuver {

namespace {

using Kind = LimitRow::Kind;
using mechanics::Freedoms;
using model::at;
using model::System;

constexpr double first_weight = 30.0;     // of the cost over the duration
constexpr double answers_weight = 8.0;    // of the first, where an answer's multipliers come without one
constexpr double weight_growth = 8.0;     // where the error has not fallen
constexpr double largest_weight = 1e7;    // of the first
constexpr double enough_progress = 0.25;  // share of the error that may be left

}  // namespace

MatrixXd turn_curvature(const System& system, const mechanics::Rotations& R, const Eigen::Ref<const VectorXd>& pull) {
  const int size = shape_size(system);
  const std::size_t bodies = at(system.body_count());
  std::vector<Freedoms> unit;
  std::vector<mechanics::Vectors> turns;
  for (int i = 1; i < system.body_count(); ++i)
    for (int c = 0; c < system.body(i).freedoms; ++c) {
      unit.emplace_back(bodies, Vector3d::Zero());
      unit.back()[at(i)][c] = 1.0;
      turns.emplace_back(bodies);
      mechanics::body_turns(system, R, unit.back(), turns.back());
    }
  MatrixXd result(size, size);
  mechanics::Vectors changes(bodies);
  for (std::size_t a = 0; a < unit.size(); ++a)
    for (std::size_t b = 0; b < unit.size(); ++b) {
      mechanics::body_turn_changes(system, R, unit[a], turns[a], unit[b], changes);
      double sum = 0.0;
      for (std::size_t i = 0; i < bodies; ++i) sum += changes[i].dot(pull.segment<3>(static_cast<Eigen::Index>(3 * i)));
      result(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = sum;
    }
  return 0.5 * (result + result.transpose());
}

LimitTerms::LimitTerms(const System& system, std::vector<LimitRow> rows, const ShapeCoordinates& coordinates, int steps,
                       double duration)
    : system_(system),
      rows_(std::move(rows)),
      shape_basis_(coordinates.shape),
      pose_basis_(coordinates.pose),
      steps_(steps),
      duration_(duration) {
  for (const LimitRow& row : rows_) before_ = before_ || row.kind == Kind::speed;
  multipliers_.value.setZero(static_cast<Eigen::Index>(rows_.size()), steps + 1);
}

// λ − weight g, what pulls the row up; 0 where a limit is kept and does not hold anything.
double LimitTerms::pull(std::size_t row, int node, double value) const {
  const double pull = multipliers_.value(static_cast<Eigen::Index>(row), node) - multipliers_.weight * value;
  return rows_[row].equality() ? pull : std::max(pull, 0.0);
}

void LimitTerms::measure(int node, const LimitedNode& node_at, Eigen::Ref<VectorXd> value) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto index = static_cast<Eigen::Index>(r);
    const double enough = multipliers_.value(index, node) / std::max(multipliers_.weight, 1e-300);
    value[index] = applies(rows_[r], node) ? limit_value(system_, rows_[r], node_at, std::max(enough, 0.0))
                                           : std::numeric_limits<double>::infinity();
  }
}

double LimitTerms::cost(int node, const Eigen::Ref<const VectorXd>& value) const {
  double sum = 0.0;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!applies(rows_[r], node)) continue;
    const auto index = static_cast<Eigen::Index>(r);
    const double lambda = multipliers_.value(index, node), pulled = pull(r, node, value[index]);
    sum += node_time(rows_[r], node) * 0.5 * (pulled * pulled - lambda * lambda) / multipliers_.weight;
  }
  return sum;
}

void LimitTerms::add_by_moments(int node, const LimitedNode& node_at, const Eigen::Ref<const VectorXd>& value,
                                VectorXd& gradient, MatrixXd& hessian) const {
  VectorXd slope;
  MatrixXd bend;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!rows_[r].of_moments() || !applies(rows_[r], node)) continue;
    const double pulled = pull(r, node, value[static_cast<Eigen::Index>(r)]);
    if (pulled == 0.0) continue;
    torque_derivatives(system_, rows_[r], node_at.moment, slope, bend);
    const double time = node_time(rows_[r], node);
    gradient -= time * pulled * slope;
    hessian += time * (multipliers_.weight * slope * slope.transpose() - pulled * bend);
  }
}

void LimitTerms::model(int node, const LimitedNode& node_at, const Eigen::Ref<const VectorXd>& value,
                       LimitModel& model) const {
  const Eigen::Index f = shape_basis_.cols(), p = pose_basis_.cols(), all = shape_basis_.rows();
  const Eigen::Index bodies = system_.body_count();
  model.any = false;
  VectorXd by_bodies, slope;   // gradient by the body coordinates
  MatrixXd bend_bodies, bend;  // Hessian
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const LimitRow& row = rows_[r];
    if (row.of_moments() || !applies(row, node)) continue;
    const double pulled = pull(r, node, value[static_cast<Eigen::Index>(r)]);
    if (pulled == 0.0) continue;
    if (!model.any) {
      model.any = true;
      model.q.setZero(2 * f + p + 1);
      model.Q.setZero(2 * f + p + 1, 2 * f + p + 1);
      by_bodies.setZero(body_coordinates(system_));
      bend_bodies.setZero(by_bodies.size(), by_bodies.size());
    }
    const double time = node_time(row, node);
    if (row.kind == Kind::angle_above || row.kind == Kind::angle_below) {  // a coordinate of the shape
      const double sign = (row.kind == Kind::angle_above ? 1.0 : -1.0) / row.unit;
      const VectorXd along =
          sign * shape_basis_.row(shape_offset(system_.body(system_.joint(row.joint).child))).transpose();
      model.q.segment(f, f) -= time * pulled * along;
      model.Q.block(f, f, f, f) += time * multipliers_.weight * along * along.transpose();
      continue;
    }
    limit_derivatives(system_, row, node_at, slope, bend);
    by_bodies -= time * pulled * slope;
    bend_bodies += time * (multipliers_.weight * slope * slope.transpose() - pulled * bend);
  }
  if (!model.any) return;

  // body coordinates by (shape before, shape, pose)
  MatrixXd map = MatrixXd::Zero(by_bodies.size(), 2 * f + p + 1);
  map(by_bodies.size() - 1, 2 * f + p) = 1.0;
  MatrixXd turn_shape = MatrixXd::Zero(3, f);  // curvature of turns after the swimmer's own
  for (int i = 0; i < system_.body_count(); ++i) {
    const Matrix3d& R = node_at.rotation[at(i)];
    map.block(3 * i, 2 * f, 3, p) = R.transpose() * pose_basis_.topRows<3>();
    if (i == 0) continue;
    const MatrixXd turns = mechanics::turn_by_freedoms(system_, node_at.rotation, i).rightCols(all) * shape_basis_;
    map.block(3 * i, f, 3, f) = turns;
    turn_shape -= 0.5 * R * lie::hat(by_bodies.segment<3>(3 * i)) * turns;
    if (before_)
      map.block(3 * (bodies + 1 + i), 0, 3, f) =
          mechanics::turn_by_freedoms(system_, node_at.rotation_before, i).rightCols(all) * shape_basis_;
  }
  map.block(3 * bodies, 2 * f, 3, p) = pose_basis_.bottomRows<3>();
  model.q.noalias() += map.transpose() * by_bodies;
  model.Q.noalias() += map.transpose() * bend_bodies * map;
  const MatrixXd mixed = pose_basis_.topRows<3>().transpose() * turn_shape;
  model.Q.block(2 * f, f, p, f) += mixed;
  model.Q.block(f, 2 * f, f, p) += mixed.transpose();
  const bool led = !system_.only_free_joints();
  if (led) {
    model.Q.block(f, f, f, f) +=
        shape_basis_.transpose() * turn_curvature(system_, node_at.rotation, by_bodies.head(3 * bodies)) * shape_basis_;
    if (before_)
      model.Q.topLeftCorner(f, f) +=
          shape_basis_.transpose() *
          turn_curvature(system_, node_at.rotation_before, by_bodies.segment(3 * bodies + 3, 3 * bodies)) *
          shape_basis_;
  }
  const VectorXd pose = pose_basis_ * model.q.segment(2 * f, p);
  model.turn = pose.head<3>();
  model.shift = pose.tail<3>();
}

LimitError LimitTerms::error(const MatrixXd& value) const {
  LimitError worst;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (!applies(rows_[r], k)) continue;
      const double g = value(static_cast<Eigen::Index>(r), k);
      const double held = multipliers_.value(static_cast<Eigen::Index>(r), k) / std::max(multipliers_.weight, 1e-300);
      const double error = std::abs(rows_[r].equality() ? g : std::min(g, held));
      if (error > worst.value || worst.row < 0) worst = {error, static_cast<int>(r), k};
    }
  return worst;
}

void LimitTerms::renew(const MatrixXd& value, bool heavier) {
  const double error = this->error(value).value;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r)
      if (applies(rows_[r], k))
        multipliers_.value(static_cast<Eigen::Index>(r), k) = pull(r, k, value(static_cast<Eigen::Index>(r), k));
  if (heavier && last_error_ > 0.0 && error > enough_progress * last_error_)
    multipliers_.weight = std::min(weight_growth * multipliers_.weight, multipliers_.largest_weight);
  last_error_ = error;
}

void LimitTerms::take(const LimitMultipliers& from, double cost) {
  last_error_ = 0.0;
  multipliers_.value.setZero();
  const double first = first_weight * cost / duration_;
  multipliers_.weight = from.weight > 0.0 ? from.weight : (from.value.size() > 0 ? answers_weight * first : first);
  multipliers_.largest_weight = from.weight > 0.0 ? from.largest_weight : largest_weight * first;
  const auto coarse = static_cast<int>(from.value.cols()) - 1;
  if (coarse < 1) return;
  for (int k = 0; k <= steps_; ++k) {
    const double place = static_cast<double>(k) * coarse / steps_;
    const int left = std::min(static_cast<int>(place), coarse - 1);
    const double share = place - left;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      if (rows_[r].time >= 0.0)
        multipliers_.value(row, k) = applies(rows_[r], k) ? from.value.row(row).sum() : 0.0;
      else if (applies(rows_[r], k))
        multipliers_.value(row, k) = (1.0 - share) * from.value(row, left) + share * from.value(row, left + 1);
    }
  }
}

}  // namespace lamprey::maneuver
