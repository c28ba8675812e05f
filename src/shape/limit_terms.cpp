#include "shape/limit_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

namespace {

using maneuver::body_coordinates;
using maneuver::limit_derivatives;
using maneuver::limit_value;
using maneuver::shape_offset;
using maneuver::torque_derivatives;
using Kind = LimitRow::Kind;
using model::at;
using model::System;
using optimizer::set_transposed;

constexpr double barrier_reach = 0.3;  // units of the rows, up to which the barrier is felt
constexpr int most_slack_rounds = 40;  // of Newton's method for a slack
constexpr double slack_left = 4e-16;   // of it, what they leave
constexpr double farthest = 30.0;      // times a pull that its multiplier may be in the model, and as small a share
constexpr double most_change = 0.95;   // of a slack, that one step may take without a promise
constexpr double most_broken = 0.1;    // units of the rows, by a step with one
constexpr int share_bisections = 7;    // on a logarithmic scale
constexpr double least_left = 0.05;    // of a multiplier after a step
constexpr double value_noise = 3e-15;  // units of the rows, round-off of their values

}  // namespace

LimitTerms::LimitTerms(const System& system, std::vector<LimitRow> rows, const ShapeCoordinates& coordinates, int steps,
                       double duration)
    : system_(system),
      rows_(std::move(rows)),
      shape_basis_(coordinates.shape),
      pose_basis_(coordinates.pose),
      steps_(steps),
      duration_(duration),
      turns_(system, coordinates.shape),
      by_body_(rows_.empty() ? 0 : body_coordinates(system)),
      by_moment_(rows_.empty() ? 0 : system.control_count()) {
  for (const LimitRow& row : rows_) {
    before_ = before_ || row.of_rate();
    of_moments_ = of_moments_ || row.of_moments();
  }
  worth_.multipliers.value.setZero(static_cast<Eigen::Index>(rows_.size()), steps + 1);
  worth_.estimate = pull_ = stiffness_ = change_ = beyond_ = worth_.multipliers.value;
  worth_.before_fall = before_landing_ = worth_.multipliers.value;
  keep();
  holds_.setConstant(worth_.multipliers.value.rows(), worth_.multipliers.value.cols(), false);
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
  along_.resize(2 * f + p + 1);
  const auto count = static_cast<Eigen::Index>(rows_.size());
  across_.assign(rows_.size() * at(steps + 1), Vector3d::Zero());
  slopes_.assign(at(steps + 1), MatrixXd::Zero(count, 2 * f + p + 1));
  if (of_moments_) moment_slopes_.assign(at(steps + 1), MatrixXd::Zero(count, system.control_count()));
}

LimitModel LimitTerms::model_of_size() const {
  LimitModel model;
  model.q.resize(map_.cols());
  model.Q.resize(map_.cols(), map_.cols());
  return model;
}

// Whether a row is an equality.
bool LimitTerms::tied(std::size_t row, int node) const {
  return rows_[row].equality() || (landed_ && holds_(static_cast<Eigen::Index>(row), node));
}

// Equations 10.6 and 10.7, with barrier, weight and pull over the row's time. Newton's method from a slack that is too small: what
// it solves is concave in it.
LimitTerms::Hold LimitTerms::hold(std::size_t row, int node, double value) const {
  const double lambda = worth_.multipliers.value(static_cast<Eigen::Index>(row), node), time = time_unit(rows_[row]);
  if (tied(row, node)) {
    const double weight = worth_.equality_weight * time;
    return {lambda - weight * value, 0.0, weight, (0.5 * weight * value - lambda) * value};
  }
  if (landed_) return {0.0, 0.0, 0.0, 0.0};
  const double weight = worth_.multipliers.weight * time, barrier = worth_.barrier * time;
  if (std::isnan(value)) return {value, value, value, value};  // no motion goes there
  const double far = value - lambda / weight;                  // the slack of a row that does not pull
  if (!(far < barrier_reach)) return {0.0, 0.0, 0.0, -0.5 * lambda * lambda / weight};
  const double least = far - 2.0 * barrier / (barrier_reach * weight);
  const double root = std::hypot(least, 2.0 * std::sqrt(barrier / weight));
  double slack = least > 0.0 ? 0.5 * (least + root) : 2.0 * barrier / (weight * (root - least));
  double share = 0.0, pull = 0.0, by_slack = 0.0;
  for (int round = 0;; ++round) {
    share = std::min(slack / barrier_reach, 1.0);
    pull = barrier * (1.0 - share) * (1.0 - share) / slack;
    by_slack = barrier * (1.0 - share) * (1.0 + share) / (slack * slack);
    const double change = (far + pull / weight - slack) / (1.0 + by_slack / weight);
    if (round == most_slack_rounds || !(std::abs(change) > slack_left * slack)) break;
    slack += change;
  }
  const double of_slack = -barrier * (std::log(share) + (1.0 - share) * (1.5 - 0.5 * share));
  return {pull, by_slack, by_slack / (1.0 + by_slack / weight),
          of_slack + 0.5 * (pull - lambda) * (pull + lambda) / weight};
}

// For the model: the stiffness has the multiplier in place of the pull.
LimitTerms::Hold LimitTerms::hold_in_model(std::size_t row, int node, double value) {
  const auto r = static_cast<Eigen::Index>(row);
  Hold held = hold(row, node, value);
  if (!tied(row, node) && held.pull > 0.0) {
    double& estimate = worth_.estimate(r, node);
    if (!(estimate > 0.0)) estimate = held.pull;
    const double by_slack = held.by_slack * std::clamp(estimate / held.pull, 1.0 / farthest, farthest);
    held.stiffness = by_slack / (1.0 + by_slack / (worth_.multipliers.weight * time_unit(rows_[row])));
  }
  pull_(r, node) = held.pull;
  stiffness_(r, node) = held.stiffness;
  return held;
}

void LimitTerms::measure(int node, const LimitedNode& node_at, Eigen::Ref<VectorXd> value) {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto index = static_cast<Eigen::Index>(r);
    const double w = std::max(worth_.multipliers.weight, 1e-300) * time_unit(rows_[r]);
    const double enough = barrier_reach + std::max(worth_.multipliers.value(index, node), 0.0) / w;
    value[index] = applies(rows_[r], node) ? limit_value(system_, rows_[r], node_at, enough, across(r, node))
                                           : std::numeric_limits<double>::infinity();
  }
}

double LimitTerms::cost(int node, const Eigen::Ref<const VectorXd>& value, double& round_off) const {
  double sum = 0.0;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!applies(rows_[r], node)) continue;
    const Hold held = hold(r, node, value[static_cast<Eigen::Index>(r)]);
    const double time = node_time(rows_[r], node);
    sum += time * held.cost;
    round_off += time * std::abs(held.pull) * value_noise;
  }
  return sum;
}

void LimitTerms::add_by_moments(int node, const LimitedNode& node_at, const Eigen::Ref<const VectorXd>& value,
                                VectorXd& gradient, MatrixXd& hessian) {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!rows_[r].of_moments() || !applies(rows_[r], node)) continue;
    const Hold held = hold_in_model(r, node, value[static_cast<Eigen::Index>(r)]);
    if (held.pull == 0.0) continue;
    torque_derivatives(system_, rows_[r], node_at.moment, by_moment_.slope, by_moment_.bend);
    moment_slopes_[at(node)].row(static_cast<Eigen::Index>(r)) = by_moment_.slope.transpose();
    add_row(node_time(rows_[r], node), held, by_moment_, gradient, hessian);
  }
}

// What a row's derivatives make of it.
void LimitTerms::add_row(double time, const Hold& held, const RowDerivatives& row, VectorXd& gradient,
                         MatrixXd& hessian) {
  algebra::add_multiple(-time * held.pull, row.slope, gradient);
  algebra::add_multiple(-time * held.pull, row.bend, hessian);
  algebra::add_product(time * held.stiffness, row.slope, row.slope.transpose(), hessian);
}

void LimitTerms::model(int node, const LimitedNode& node_at, const Eigen::Ref<const VectorXd>& value,
                       LimitModel& model) {
  add_rows(node, node_at, value, model);
  if (!model.any) return;
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
    const Hold held = hold_in_model(r, node, value[static_cast<Eigen::Index>(r)]);
    if (held.pull == 0.0) continue;
    if (!model.any) {
      map_bodies(node_at);
      set_transposed(map_, transposed_);
      model.any = true;
      model.q.setZero();
      model.Q.setZero();
      by_bodies_.setZero();
      bend_bodies_.setZero();
    }
    const double time = node_time(row, node);
    auto slope = slopes_[at(node)].row(static_cast<Eigen::Index>(r));
    if (row.kind == Kind::angle_above || row.kind == Kind::angle_below) {
      angle_ = shape_basis_.row(shape_offset(system_.body(system_.joint(row.joint).child)) + row.freedom()).transpose();
      angle_ *= (row.kind == Kind::angle_above ? 1.0 : -1.0) / row.unit;
      algebra::add_multiple(-time * held.pull, angle_, model.q.segment(f, f));
      algebra::add_product(time * held.stiffness, angle_, angle_.transpose(), model.Q.block(f, f, f, f));
      slope.setZero();
      slope.segment(f, f) = angle_.transpose();
      continue;
    }
    limit_derivatives(system_, row, node_at, across(r, node), by_body_.slope, by_body_.bend);
    add_row(time, held, by_body_, by_bodies_, bend_bodies_);
    along_.setZero();
    optimizer::add_image(1.0, transposed_, by_body_.slope, along_);
    slope = along_.transpose();
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

void LimitTerms::foresee(int node, const Eigen::Ref<const VectorXd>& state, const Eigen::Ref<const VectorXd>& moments) {
  const Eigen::Index size = state.size();
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    double& change = change_(row, node);
    change = 0.0;
    if (stiffness_(row, node) == 0.0) continue;
    if (rows_[r].of_moments())
      change = moment_slopes_[at(node)].row(row).dot(moments.transpose());
    else
      change = slopes_[at(node)].row(row).head(size).dot(state.head(size).transpose());
  }
}

void LimitTerms::compare(const MatrixXd& value, const MatrixXd& trial, double share) {
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      double& beyond = beyond_(row, k);
      beyond = 0.0;
      if (stiffness_(row, k) == 0.0) continue;
      const double bent = trial(row, k) - value(row, k) - share * change_(row, k);
      beyond = node_time(rows_[r], k) * stiffness_(row, k) * bent / share;
    }
}

void LimitTerms::add_bend(int node, double factor, Eigen::Index size, VectorXd& by_state) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    const double beyond = factor * beyond_(row, node);
    if (beyond != 0.0 && !rows_[r].of_moments())
      algebra::add_multiple(beyond, slopes_[at(node)].row(row).head(size).transpose(), by_state.head(size));
  }
}

void LimitTerms::add_bend_by_moments(int node, double factor, VectorXd& by_moments) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    const double beyond = factor * beyond_(row, node);
    if (beyond != 0.0 && rows_[r].of_moments())
      algebra::add_multiple(beyond, moment_slopes_[at(node)].row(row).transpose(), by_moments);
  }
}

// That leaves every slack some of its length, or breaks rows by so much; gaps and durations, which a step foresees for a short way
// alone, by nothing.
double LimitTerms::share_within(const MatrixXd& value, double broken) const {
  double share = 1.0;
  for (Eigen::Index k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      if (tied(r, static_cast<int>(k)) || !(change_(row, k) < 0.0)) continue;
      const double w = worth_.multipliers.weight * time_unit(rows_[r]);
      double room = most_change * (std::max(value(row, k), 0.0) + pull_(row, k) / w);
      if (!rows_[r].of_gap() && !rows_[r].of_duration()) room += broken;
      if (-share * change_(row, k) > room) share = -room / change_(row, k);
    }
  return share;
}

// A share of the step away, rows as foreseen.
double LimitTerms::gain_rate(const MatrixXd& value, const optimizer::Promise& promise, double share) const {
  double rate = promise.rate - promise.bend * share;
  for (Eigen::Index k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      const int node = static_cast<int>(k);
      if (change_(row, k) == 0.0 || tied(r, node)) continue;
      const double changed = share * change_(row, k), modelled = pull_(row, k) - stiffness_(row, k) * changed;
      const double pull = hold(r, node, value(row, k) + changed).pull;
      rate += node_time(rows_[r], node) * (pull - modelled) * change_(row, k);
    }
  return rate;
}

double LimitTerms::share_worth(const MatrixXd& value, const optimizer::Promise& promise) const {
  double worth = share_within(value, 0.0);
  if (worth >= 1.0 || !(promise.rate > 0.0)) return worth;
  double beyond = share_within(value, most_broken);
  if (gain_rate(value, promise, beyond) >= 0.0) return beyond;
  for (int n = 0; n < share_bisections; ++n) {
    const double middle = std::sqrt(worth * beyond);
    (gain_rate(value, promise, middle) >= 0.0 ? worth : beyond) = middle;
  }
  return worth;
}

void LimitTerms::follow(double share) {
  for (Eigen::Index k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      double& estimate = worth_.estimate(row, k);
      const double next = pull_(row, k) - stiffness_(row, k) * change_(row, k);
      if (tied(r, static_cast<int>(k)))
        estimate += share * (next - estimate);
      else
        estimate = std::max(estimate + share * (next - estimate), least_left * estimate);
    }
}

}  // namespace lamprey::shape
