#include "maneuver/cost_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "maneuver/node_path.hpp"
#include "mechanics/continuous.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::maneuver {

namespace {

using model::at;
using model::System;
using optimizer::Stage;
using optimizer::StageModel;

constexpr double first_work_weight = 4.0;     // over the root mean square of the powers
constexpr double carried_work_weight = 8.0;   // most of the first, that another grid begins with
constexpr double work_weight_growth = 4.0;    // where the error has not fallen
constexpr double largest_work_weight = 1e7;   // of the first
constexpr double enough_work_progress = 0.5;  // share of the error that may be left
constexpr double multiplier_noise = 3e-8;     // that round-off in the powers may bring

}  // namespace

CostTerms::CostTerms(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates)
    : system_(system),
      turns_(system, coordinates.shape),
      pose_basis_(coordinates.pose),
      weights_(maneuver.cost_weights),
      periodic_(maneuver.periodic),
      rest_(maneuver.rest),
      free_duration_(maneuver.free_duration),
      steps_(maneuver.steps),
      shape_(static_cast<int>(coordinates.shape.cols())),
      controls_(system.control_count()),
      start_rate_(VectorXd::Zero(controls_)),
      rate_(controls_),
      changing_(controls_),
      difference_(controls_),
      pull_(controls_) {
  multipliers_.value.setZero(system.joint_count(), steps_ + 1);
  heaviest_.setConstant(system.joint_count(), steps_ + 1, std::numeric_limits<double>::infinity());
  retarget(maneuver);
}

void CostTerms::retarget(const Maneuver& maneuver) {
  weights_ = maneuver.cost_weights;
  if (empty() || periodic_) return;
  start_rate_.setZero();
  if (maneuver.start.momentum.isZero(0.0)) return;
  start_rate_ = turns_.rates(maneuver.start.rotation, mechanics::velocity_of_momentum(system_, maneuver.start.rotation,
                                                                                      maneuver.start.momentum));
}

// First moments of a periodic motion, moments at the node before, work so far.
int CostTerms::states() const {
  return (weights_.smoothness > 0.0 ? (periodic_ ? 2 : 1) * controls_ : 0) + (weights_.transport > 0.0 ? 1 : 0);
}

double CostTerms::work_weight(const CostValues& values) const {
  return weights_.work + (weights_.transport > 0.0 ? weights_.transport / values.distance : 0.0);
}

double CostTerms::weight_of_power(int joint, int node) const {
  return std::min(multipliers_.weight, heaviest_(joint, node));
}

// Equation 13.5.
CostTerms::Bend CostTerms::work_term(int joint, int node, double power) const {
  const double c = weight_of_power(joint, node), mu = multipliers_.value(joint, node);
  if (c <= 0.0) return {std::abs(power), power < 0.0 ? -1.0 : 1.0, 0.0};
  const double sign = mu + c * power;
  if (std::abs(sign) <= 1.0) return {power * (mu + 0.5 * c * power), sign, c};
  const double side = sign < 0.0 ? -1.0 : 1.0, missing = side - mu;
  return {side * power - 0.5 * missing * missing / c, side, 0.0};
}

CostTerms::Bend CostTerms::term(int joint, int node, double power, double work_weight) const {
  Bend bend{weights_.power * power * power, 2.0 * weights_.power * power, 2.0 * weights_.power};
  if (work_weight == 0.0) return bend;
  const Bend work = work_term(joint, node, power);
  return {bend.value + work_weight * work.value, bend.slope + work_weight * work.slope,
          bend.curvature + work_weight * work.curvature};
}

bool CostTerms::moves(int node) const {
  if (periodic_) return node > 0;  // the first node's moments are the last's
  return node < steps_ || rest_;
}

double CostTerms::node_time(int node, double time_step) const {
  return (!periodic_ && (node == 0 || node == steps_) ? 0.5 : 1.0) * time_step;
}

// Equation 13.2: mean rates of the joints about a node, and their part that changes with the shapes.
void CostTerms::find_rates(const CostValues& values, int node, double time_step) {
  changing_.setZero();
  if (node > 0) changing_ += values.turn.col(node - 1);
  if (node < steps_) changing_ += values.turn.col(node);
  if (periodic_ && node == steps_) changing_ += values.turn.col(0);
  changing_ *= 0.5 / time_step;
  rate_ = changing_;
  if (node == 0) algebra::add_multiple(0.5, start_rate_, rate_);
}

void CostTerms::find_difference(const CostedMotion& motion, int step) {
  difference_ = motion.moment[at(step + 1)].head(controls_);
  difference_ -= motion.moment[at(step)].head(controls_);
}

void CostTerms::measure(const CostedMotion& motion, CostValues& values) {
  values.turn.resize(controls_, steps_);
  values.power.setZero(system_.joint_count(), steps_ + 1);
  values.parts = CostParts();
  values.reached = 0.0;
  for (int k = 0; k < steps_; ++k) turns_.evaluate(motion.step[at(k)].interval, values.turn.col(k));
  for (int k = 0; k <= steps_; ++k) {
    if (!moves(k)) continue;
    find_rates(values, k, motion.time_step);
    for (int c = 0; c < controls_; ++c) values.power(turns_.joint_of(c), k) += motion.moment[at(k)][c] * rate_[c];
    const double time = node_time(k, motion.time_step);
    for (int j = 0; j < system_.joint_count(); ++j) {
      const double power = values.power(j, k);
      values.parts.work += time * std::abs(power);
      values.parts.power += time * power * power;
      values.reached += time * work_term(j, k, power).value;
    }
  }
  for (int k = 0; k < steps_; ++k) {
    find_difference(motion, k);
    values.parts.smoothness += 0.5 * difference_.squaredNorm() / motion.time_step;
  }
  values.distance = (motion.position.back() - motion.position.front()).norm();
  values.parts.transport = values.parts.work / values.distance;
  const double others = weights_.power * values.parts.power + weights_.smoothness * values.parts.smoothness;
  values.cost = others + work_weight(values) * values.parts.work;
  values.merit = others + work_weight(values) * values.reached;
}

void CostTerms::add_difference(double factor, const CostedMotion& motion, int step, VectorXd& gradient) {
  find_difference(motion, step);
  algebra::add_multiple(factor, difference_, gradient);
}

void CostTerms::add_by_moments(const CostedMotion& motion, const CostValues& values, int node, VectorXd& gradient) {
  if (!moves(node)) return;
  find_rates(values, node, motion.time_step);
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  for (int c = 0; c < controls_; ++c) {
    const int joint = turns_.joint_of(c);
    gradient[c] += time * term(joint, node, values.power(joint, node), weight).slope * rate_[c];
  }
  if (!smooth()) return;
  const double stiff = weights_.smoothness / motion.time_step;
  if (node > 0) add_difference(stiff, motion, node - 1, gradient);
  if (node < steps_) add_difference(-stiff, motion, node, gradient);
  if (periodic_ && node == steps_) add_difference(-stiff, motion, 0, gradient);
}

Vector3d CostTerms::pull_at_end(const CostedMotion& motion, const CostValues& values) const {
  if (weights_.transport == 0.0) return Vector3d::Zero();
  const double d = values.distance;
  return -weights_.transport * values.reached / (d * d * d) * (motion.position.back() - motion.position.front());
}

// Derivative of the merit by the joints' rates about a node.
void CostTerms::add_by_rates(double factor, const CostedMotion& motion, const CostValues& values, int node,
                             VectorXd& pull) {
  if (periodic_ && node == 0) node = steps_;
  if (!moves(node)) return;
  const double time = factor * node_time(node, motion.time_step), weight = work_weight(values);
  for (int c = 0; c < controls_; ++c) {
    const int joint = turns_.joint_of(c);
    pull[c] += time * term(joint, node, values.power(joint, node), weight).slope * motion.moment[at(node)][c];
  }
}

// Second derivatives of a node's term along a row of variables, and the rate of its work, from the rates of the node's moments
// and of the joints' turns about it (over twice the time step) in moments_ and turned_.
void CostTerms::add_node_form(const CostedMotion& motion, const CostValues& values, int node, int tau) {
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  find_rates(values, node, motion.time_step);
  rate_by_ = turned_;
  if (tau >= 0) rate_by_.col(tau) -= changing_;
  for (int j = 0; j < system_.joint_count(); ++j) {
    const double power = values.power(j, node);
    const Bend bend = term(j, node, power, weight);
    power_by_.setZero();
    bool any = false;
    for (int c = 0; c < controls_; ++c) {
      if (turns_.joint_of(c) != j) continue;
      any = true;
      const double u = motion.moment[at(node)][c], slope = time * bend.slope;
      const auto moment_by = moments_.row(c), rate_by = rate_by_.row(c);
      algebra::add_multiple(rate_[c], moment_by.transpose(), power_by_);
      algebra::add_multiple(u, rate_by.transpose(), power_by_);
      algebra::add_product(slope, moment_by.transpose(), rate_by, form_);
      algebra::add_product(slope, rate_by.transpose(), moment_by, form_);
      if (tau < 0) continue;
      algebra::add_multiple(-slope * u, turned_.row(c).transpose(), form_.col(tau));
      algebra::add_multiple(-slope * u, turned_.row(c), form_.row(tau));
      form_(tau, tau) += slope * u * changing_[c];
    }
    if (!any) continue;
    algebra::add_product(time * bend.curvature, power_by_, power_by_.transpose(), form_);
    const Bend own = of_work() ? work_term(j, node, power) : Bend{0.0, 0.0, 0.0};
    algebra::add_multiple(time * own.slope, power_by_, work_);
    if (tau < 0) continue;
    algebra::add_multiple(time * bend.slope, power_by_, form_.col(tau));
    algebra::add_multiple(time * bend.slope, power_by_.transpose(), form_.row(tau));
    form_(tau, tau) += time * bend.value;
    work_[tau] += time * own.value;
  }
}

// The same of ½|u_{k+1} − u_k|²/h, whose difference has these rates.
void CostTerms::add_difference_form(const CostedMotion& motion, int step, const MatrixXd& difference_by, int tau) {
  const double stiff = weights_.smoothness / motion.time_step;
  algebra::add_product(stiff, difference_by.transpose(), difference_by, form_);
  if (tau < 0) return;
  find_difference(motion, step);
  algebra::set_product(difference_by.transpose(), difference_, slower_);
  algebra::add_multiple(-stiff, slower_, form_.col(tau));
  algebra::add_multiple(-stiff, slower_.transpose(), form_.row(tau));
  form_(tau, tau) += 0.5 * stiff * difference_.squaredNorm();
}

// Derivative of a node's terms by the logarithm of the time step, shapes and moments held; smoothness counts at its step's end.
void CostTerms::add_duration(const CostedMotion& motion, const CostValues& values, int node, double& slope) {
  if (node > 0 && smooth()) {
    find_difference(motion, node - 1);
    slope -= 0.5 * weights_.smoothness / motion.time_step * difference_.squaredNorm();
  }
  if (!moves(node)) return;
  find_rates(values, node, motion.time_step);
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Bend bend = term(j, node, values.power(j, node), weight);
    slope += time * bend.value;
    for (int c = 0; c < controls_; ++c)
      if (turns_.joint_of(c) == j) slope -= time * bend.slope * motion.moment[at(node)][c] * changing_[c];
  }
}

void CostTerms::add_to_model(const CostedMotion& motion, const CostValues& values, const Places& places,
                             const Eigen::Ref<const MatrixXd>& end_moments, StageModel& model) {
  const Eigen::Index ends = Eigen::Index{2} * shape_, all = model.Q_end.rows() + controls_ + 1;
  turns_before_.setZero(controls_, ends);
  next_.resize(ends, all);
  for (MatrixXd* by : {&moments_, &turned_}) by->resize(controls_, all);
  for (VectorXd* row : {&work_, &power_by_, &slower_}) row->resize(all);
  for (int k = 0; k <= steps_; ++k) {
    const bool last = k == steps_;
    MatrixXd& Q = last ? model.Q_end : model.stage[at(places.leads + k)].Q;
    VectorXd& q = last ? model.q_end : model.stage[at(places.leads + k)].q;
    if (k > 0) add_step_form(motion, values, k - 1, Q, q);
    if (places.tau >= 0) add_duration(motion, values, k, q[places.tau]);
    form_.setZero(all, all);
    work_.setZero();
    if (last)
      add_to_end(motion, values, places, end_moments, model);
    else
      add_to_stage(motion, values, places, k, model.stage[at(places.leads + k)]);
  }
}

// The joints' turns over a step, with the state at its end.
void CostTerms::add_step_form(const CostedMotion& motion, const CostValues& values, int step, MatrixXd& Q,
                              VectorXd& q) {
  const double half = 0.5 / motion.time_step;
  const Eigen::Index ends = turns_before_.cols();
  pull_.setZero();
  add_by_rates(half, motion, values, step, pull_);
  add_by_rates(half, motion, values, step + 1, pull_);
  turns_.add_curvature(motion.step[at(step)].interval, pull_, Q.topLeftCorner(ends, ends));
  optimizer::add_transposed_image(1.0, turns_before_, pull_, q.head(ends));
}

void CostTerms::add_to_stage(const CostedMotion& motion, const CostValues& values, const Places& places, int k,
                             Stage& stage) {
  const Eigen::Index n = stage.Q.rows(), m = controls_, ends = turns_before_.cols();
  const int second = places.first, before = place_before(places), work_place = place_of_work(places);
  const double half = 0.5 / motion.time_step;
  turns_.derivative(motion.step[at(k)].interval, turns_after_);
  if (k == 0) first_turns_ = turns_after_;
  if (smooth()) {
    stage.A.middleRows(before, m).setZero();
    stage.B.middleRows(before, m).setIdentity();
    if (periodic_ && k == 1) {
      stage.A.middleRows(second, m).setZero();
      stage.B.middleRows(second, m).setIdentity();
    }
  }
  if (moves(k)) {
    next_.leftCols(n) = stage.A.topRows(ends);
    next_.middleCols(n, m) = stage.B.topRows(ends);
    next_.col(n + m) = stage.gap.head(ends);
    moments_.setZero();
    moments_.middleCols(n, m).setIdentity();
    algebra::set_product(turns_after_, next_, turned_);
    turned_ *= half;
    algebra::add_multiple(half, turns_before_, turned_.leftCols(ends));
    add_node_form(motion, values, k, places.tau);
    if (smooth() && k > (periodic_ ? 1 : 0)) {
      moments_.middleCols(before, m).diagonal().array() -= 1.0;
      add_difference_form(motion, k - 1, moments_, places.tau);
    }
  }
  stage.Q += form_.topLeftCorner(n, n);
  stage.S += form_.block(n, 0, m, n);
  stage.R += form_.block(n, n, m, m);
  stage.weight += std::max(form_.block(n, n, m, m).diagonal().maxCoeff(), 0.0);
  stage.q += form_.col(n + m).head(n);
  stage.r += form_.col(n + m).segment(n, m);
  if (weights_.transport > 0.0) {
    stage.A.row(work_place) += work_.head(n).transpose();
    stage.B.row(work_place) += work_.segment(n, m).transpose();
    stage.gap[work_place] += work_[n + m];
  }
  std::swap(turns_before_, turns_after_);
}

void CostTerms::add_to_end(const CostedMotion& motion, const CostValues& values, const Places& places,
                           const Eigen::Ref<const MatrixXd>& end_moments, StageModel& model) {
  const Eigen::Index n = model.Q_end.rows(), m = controls_, ends = turns_before_.cols();
  const int before = place_before(places);
  const double half = 0.5 / motion.time_step;
  if (moves(steps_)) {
    moments_.setZero();
    moments_.leftCols(n) = end_moments;
    turned_.setZero();
    algebra::add_multiple(half, turns_before_, turned_.leftCols(ends));
    if (periodic_) algebra::add_multiple(half, first_turns_, turned_.middleCols(places.copies, ends));
    add_node_form(motion, values, steps_, places.tau);
    if (smooth() && periodic_ && steps_ > 1) {
      difference_by_ = moments_;
      difference_by_ *= -1.0;
      difference_by_.middleCols(places.first, m).diagonal().array() += 1.0;
      add_difference_form(motion, 0, difference_by_, places.tau);
    }
    if (smooth() && steps_ > (periodic_ ? 1 : 0)) {
      moments_.middleCols(before, m).diagonal().array() -= 1.0;
      add_difference_form(motion, steps_ - 1, moments_, places.tau);
    }
  }
  model.Q_end += form_.topLeftCorner(n, n);
  if (weights_.transport == 0.0) return;
  work_[place_of_work(places)] += 1.0;
  add_transport(motion, values, model);
}

// Second derivatives of J = w W/D by the last state, with those of W in work_.
void CostTerms::add_transport(const CostedMotion& motion, const CostValues& values, StageModel& model) {
  const Eigen::Index n = model.Q_end.rows(), pose = Eigen::Index{2} * shape_, p = pose_basis_.cols();
  MatrixXd& Q = model.Q_end;
  const double d = values.distance, weight = weights_.transport, reached = weight * values.reached;
  const Vector3d direction = (motion.position.back() - motion.position.front()) / d;
  const auto shift = pose_basis_.bottomRows<3>();
  away_.setZero(n);
  optimizer::add_transposed_image(1.0, shift, direction, away_.segment(pose, p));
  algebra::add_multiple(-reached / (d * d), away_, model.q_end);
  const auto work = work_.head(n);
  algebra::add_product(-weight / (d * d), work, away_.transpose(), Q);
  algebra::add_product(-weight / (d * d), away_, work.transpose(), Q);
  algebra::add_product(2.0 * reached / (d * d * d), away_, away_.transpose(), Q);
  const Matrix3d bend = (Matrix3d::Identity() - direction * direction.transpose()) / d;
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> bent = bend.lazyProduct(shift);
  algebra::add_product(-reached / (d * d), shift.transpose(), bent, Q.block(pose, pose, p, p));
}

double CostTerms::error(const CostValues& values) const {
  if (!of_work()) return 0.0;
  const double largest = values.power.lpNorm<Eigen::Infinity>();
  double error = 0.0;
  for (Eigen::Index k = 0; k <= steps_; ++k)
    for (Eigen::Index j = 0; j < values.power.rows(); ++j) {
      const double renewed = work_term(static_cast<int>(j), static_cast<int>(k), values.power(j, k)).slope;
      error = std::max(error, std::abs(renewed - multipliers_.value(j, k)) /
                                  weight_of_power(static_cast<int>(j), static_cast<int>(k)));
    }
  return error / std::max(largest, 1e-300);
}

// Moments follow from second differences of the shapes, rates from first ones: relative to what they are like, round-off in
// them is ε N² and ε N (equation 13.16). A weight turns what that makes of a power into an error of its multiplier.
void CostTerms::find_heaviest(const CostedMotion& motion, const CostValues& values) {
  const double epsilon = std::numeric_limits<double>::epsilon();
  double largest_moment = 0.0, largest_rate = 0.0;
  for (int k = 0; k <= steps_; ++k) {
    find_rates(values, k, motion.time_step);
    largest_moment = std::max(largest_moment, motion.moment[at(k)].head(controls_).lpNorm<Eigen::Infinity>());
    largest_rate = std::max(largest_rate, rate_.lpNorm<Eigen::Infinity>());
  }
  heaviest_.setConstant(std::numeric_limits<double>::infinity());
  for (int k = 0; k <= steps_; ++k) {
    find_rates(values, k, motion.time_step);
    for (int c = 0; c < controls_; ++c) {
      const double of_moment = std::abs(rate_[c]) * largest_moment * steps_;
      const double of_rate = std::abs(motion.moment[at(k)][c]) * largest_rate;
      const double noise = epsilon * steps_ * (of_moment + of_rate);
      double& heaviest = heaviest_(turns_.joint_of(c), k);
      if (noise > 0.0) heaviest = std::min(heaviest, multiplier_noise / noise);
    }
  }
}

void CostTerms::renew(const CostedMotion& motion, const CostValues& values, bool heavier) {
  if (!of_work()) return;
  const double error = this->error(values);
  for (int k = 0; k <= steps_; ++k)
    for (int j = 0; j < system_.joint_count(); ++j)
      multipliers_.value(j, k) = moves(k) ? work_term(j, k, values.power(j, k)).slope : 0.0;
  if (periodic_) multipliers_.value.col(0) = multipliers_.value.col(steps_);
  if (heavier && last_error_ > 0.0 && error > enough_work_progress * last_error_)
    multipliers_.weight = std::min(work_weight_growth * multipliers_.weight, multipliers_.largest_weight);
  last_error_ = error;
  find_heaviest(motion, values);
}

// Heavier ones make narrow bent valleys of the kinks, u = 0 or ω = 0, that a search creeps along.
void CostTerms::choose_weight(const CostValues& values) {
  if (!of_work()) return;
  const double mean = std::sqrt(values.power.squaredNorm() / static_cast<double>(values.power.size()));
  const double first = first_work_weight / std::max(mean, 1e-300),
               before = multipliers_.largest_weight / largest_work_weight;
  const double carried = before > 0.0 ? std::min(multipliers_.weight / before, carried_work_weight) : 1.0;
  multipliers_.weight = carried * first;
  multipliers_.largest_weight = largest_work_weight * first;
}

void CostTerms::take(const WorkMultipliers& from) {
  last_error_ = 0.0;
  multipliers_.value.setZero();
  heaviest_.setConstant(std::numeric_limits<double>::infinity());
  multipliers_.largest_weight = from.largest_weight;
  multipliers_.weight = from.weight;
  const auto coarse = static_cast<int>(from.value.cols()) - 1;
  if (coarse < 1) return;
  for (int k = 0; k <= steps_; ++k) {
    const auto [left, share] = place_on_grid(k, steps_, coarse);
    auto at_node = multipliers_.value.col(k);
    at_node = from.value.col(left);
    at_node *= 1.0 - share;
    algebra::add_multiple(share, from.value.col(left + 1), at_node);
  }
}

}  // namespace lamprey::maneuver
