#include "maneuver/limit_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "optimizer/small_dense.hpp"

namespace lamprey::maneuver {

namespace {

using Kind = LimitRow::Kind;
using model::at;
using model::System;
using optimizer::set_transposed;

constexpr double first_weight = 30.0;     // of the cost over the duration
constexpr double answers_weight = 8.0;    // of the first, where an answer's multipliers come without one
constexpr double weight_growth = 8.0;     // where the error has not fallen
constexpr double largest_weight = 1e7;    // of the first
constexpr double settled = 1e-9;          // error of limits that no weight need bring nearer
constexpr double heaviest = 1e5;          // of such, over the largest multiplier: round-off in the rows is 1e-10 of it
constexpr double enough_progress = 0.25;  // share of the error that may be left

}  // namespace

LimitTerms::LimitTerms(const System& system, std::vector<LimitRow> rows, const ShapeCoordinates& coordinates, int steps,
                       double duration)
    : system_(system),
      rows_(std::move(rows)),
      shape_basis_(coordinates.shape),
      pose_basis_(coordinates.pose),
      steps_(steps),
      duration_(duration),
      turns_(system, coordinates.shape) {
  for (const LimitRow& row : rows_) before_ = before_ || row.kind == Kind::speed;
  multipliers_.value.setZero(static_cast<Eigen::Index>(rows_.size()), steps + 1);
  if (rows_.empty()) return;
  const Eigen::Index f = shape_basis_.cols(), p = pose_basis_.cols(), bodies = body_coordinates(system);
  by_bodies_.resize(bodies);
  bend_bodies_.resize(bodies, bodies);
  map_.resize(bodies, 2 * f + p + 1);
  bent_ = map_;
  transposed_.resize(2 * f + p + 1, bodies);
  turn_shape_.resize(3, f);
  mixed_.resize(p, f);
  angle_.resize(f);
}

LimitModel LimitTerms::model_of_size() const {
  LimitModel model;
  model.q.resize(map_.cols());
  model.Q.resize(map_.cols(), map_.cols());
  return model;
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
                                VectorXd& gradient, MatrixXd& hessian) {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!rows_[r].of_moments() || !applies(rows_[r], node)) continue;
    const double pulled = pull(r, node, value[static_cast<Eigen::Index>(r)]);
    if (pulled == 0.0) continue;
    torque_derivatives(system_, rows_[r], node_at.moment, slope_, bend_);
    add_row(node_time(rows_[r], node), pulled, gradient, hessian);
  }
}

// What a row's derivatives in slope_ and bend_ make of ½ weight (g − λ/weight)².
void LimitTerms::add_row(double time, double pulled, VectorXd& gradient, MatrixXd& hessian) const {
  algebra::add_multiple(-time * pulled, slope_, gradient);
  algebra::add_multiple(-time * pulled, bend_, hessian);
  algebra::add_product(time * multipliers_.weight, slope_, slope_.transpose(), hessian);
}

void LimitTerms::model(int node, const LimitedNode& node_at, const Eigen::Ref<const VectorXd>& value,
                       LimitModel& model) {
  add_rows(node, node_at, value, model);
  if (!model.any) return;
  map_bodies(node_at);
  set_transposed(map_, transposed_);
  bent_.setZero();
  optimizer::add_product(1.0, bend_bodies_, map_, bent_);
  optimizer::add_product(1.0, transposed_, bent_, model.Q);
  optimizer::add_image(1.0, transposed_, by_bodies_, model.q);
  add_curvatures(node_at, model);
  const Eigen::Index pose = 2 * shape_basis_.cols(), p = pose_basis_.cols();
  algebra::set_product(pose_basis_.topRows<3>(), model.q.segment(pose, p), model.turn);
  algebra::set_product(pose_basis_.bottomRows<3>(), model.q.segment(pose, p), model.shift);
}

// All rows but those of moments, by the body coordinates; those that are a coordinate of the shape into the model itself.
void LimitTerms::add_rows(int node, const LimitedNode& node_at, const Eigen::Ref<const VectorXd>& value,
                          LimitModel& model) {
  const Eigen::Index f = shape_basis_.cols();
  model.any = false;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const LimitRow& row = rows_[r];
    if (row.of_moments() || !applies(row, node)) continue;
    const double pulled = pull(r, node, value[static_cast<Eigen::Index>(r)]);
    if (pulled == 0.0) continue;
    if (!model.any) {
      model.any = true;
      model.q.setZero();
      model.Q.setZero();
      by_bodies_.setZero();
      bend_bodies_.setZero();
    }
    const double time = node_time(row, node);
    if (row.kind == Kind::angle_above || row.kind == Kind::angle_below) {
      angle_ = shape_basis_.row(shape_offset(system_.body(system_.joint(row.joint).child))).transpose();
      angle_ *= (row.kind == Kind::angle_above ? 1.0 : -1.0) / row.unit;
      algebra::add_multiple(-time * pulled, angle_, model.q.segment(f, f));
      algebra::add_product(time * multipliers_.weight, angle_, angle_.transpose(), model.Q.block(f, f, f, f));
      continue;
    }
    limit_derivatives(system_, row, node_at, slope_, bend_);
    add_row(time, pulled, by_bodies_, bend_bodies_);
  }
}

// Body coordinates by (shape before, shape, pose, logarithm of the time step), to first order.
void LimitTerms::map_bodies(const LimitedNode& node_at) {
  const Eigen::Index f = shape_basis_.cols(), p = pose_basis_.cols(), bodies = system_.body_count();
  map_.setZero();
  map_(map_.rows() - 1, 2 * f + p) = 1.0;
  for (int i = 0; i < system_.body_count(); ++i) {
    algebra::set_product(node_at.rotation[at(i)].transpose(), pose_basis_.topRows<3>(), map_.block(3 * i, 2 * f, 3, p));
    if (i == 0) continue;
    map_.block(3 * i, f, 3, f) = turns_.of_body(node_at.rotation, i);
    if (before_) map_.block(3 * (bodies + 1 + i), 0, 3, f) = turns_.of_body(node_at.rotation_before, i);
  }
  map_.block(3 * bodies, 2 * f, 3, p) = pose_basis_.bottomRows<3>();
}

// What the map's own derivatives add.
void LimitTerms::add_curvatures(const LimitedNode& node_at, LimitModel& model) {
  const Eigen::Index f = shape_basis_.cols(), p = pose_basis_.cols(), turns = Eigen::Index{3} * system_.body_count();
  turn_shape_.setZero();  // of turns after the swimmer's own
  for (int i = 1; i < system_.body_count(); ++i) {
    const Matrix3d bracket = node_at.rotation[at(i)] * lie::hat(by_bodies_.segment<3>(3 * i));
    algebra::add_product(-0.5, bracket, map_.block(3 * i, f, 3, f), turn_shape_);
  }
  algebra::set_product(pose_basis_.topRows<3>().transpose(), turn_shape_, mixed_);
  model.Q.block(2 * f, f, p, f) += mixed_;
  model.Q.block(f, 2 * f, f, p) += mixed_.transpose();
  turns_.add_curvature(node_at.rotation, by_bodies_.head(turns), model.Q.block(f, f, f, f));
  if (before_)
    turns_.add_curvature(node_at.rotation_before, by_bodies_.segment(turns + 3, turns), model.Q.topLeftCorner(f, f));
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

bool LimitTerms::renew(const MatrixXd& value, bool heavier) {
  const double error = this->error(value).value;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r)
      if (applies(rows_[r], k))
        multipliers_.value(static_cast<Eigen::Index>(r), k) = pull(r, k, value(static_cast<Eigen::Index>(r), k));
  if (heavier && last_error_ > 0.0 && error > enough_progress * last_error_)
    multipliers_.weight = std::min(weight_growth * multipliers_.weight, multipliers_.largest_weight);
  last_error_ = error;
  const double first = multipliers_.largest_weight / largest_weight;
  const double enough = std::max(first, heaviest * multipliers_.value.lpNorm<Eigen::Infinity>());
  if (error > settled || multipliers_.weight <= enough) return false;
  multipliers_.weight = enough;
  return true;
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
