#include "maneuver/cost_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mechanics/continuous.hpp"

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
      start_rate_(VectorXd::Zero(controls_)) {
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
void CostTerms::rates(const CostValues& values, int node, double time_step, VectorXd& rate, VectorXd& changing) const {
  changing.setZero(controls_);
  if (node > 0) changing += values.turn.col(node - 1);
  if (node < steps_) changing += values.turn.col(node);
  if (periodic_ && node == steps_) changing += values.turn.col(0);
  changing *= 0.5 / time_step;
  rate = changing;
  if (node == 0) rate += 0.5 * start_rate_;
}

VectorXd CostTerms::difference(const CostedMotion& motion, int step) const {
  return motion.moment[at(step + 1)].head(controls_) - motion.moment[at(step)].head(controls_);
}

void CostTerms::measure(const CostedMotion& motion, CostValues& values) const {
  values.turn.resize(controls_, steps_);
  values.power.setZero(system_.joint_count(), steps_ + 1);
  values.parts = CostParts();
  values.reached = 0.0;
  for (int k = 0; k < steps_; ++k) turns_.evaluate(motion.step[at(k)].interval, values.turn.col(k));
  VectorXd rate(controls_), changing(controls_);
  for (int k = 0; k <= steps_; ++k) {
    if (!moves(k)) continue;
    rates(values, k, motion.time_step, rate, changing);
    for (int c = 0; c < controls_; ++c) values.power(turns_.joint_of(c), k) += motion.moment[at(k)][c] * rate[c];
    const double time = node_time(k, motion.time_step);
    for (int j = 0; j < system_.joint_count(); ++j) {
      const double power = values.power(j, k);
      values.parts.work += time * std::abs(power);
      values.parts.power += time * power * power;
      values.reached += time * work_term(j, k, power).value;
    }
  }
  for (int k = 0; k < steps_; ++k)
    values.parts.smoothness += 0.5 * difference(motion, k).squaredNorm() / motion.time_step;
  values.distance = (motion.position.back() - motion.position.front()).norm();
  values.parts.transport = values.parts.work / values.distance;
  const double others = weights_.power * values.parts.power + weights_.smoothness * values.parts.smoothness;
  values.cost = others + work_weight(values) * values.parts.work;
  values.merit = others + work_weight(values) * values.reached;
}

void CostTerms::add_by_moments(const CostedMotion& motion, const CostValues& values, int node,
                               VectorXd& gradient) const {
  if (!moves(node)) return;
  VectorXd rate(controls_), changing(controls_);
  rates(values, node, motion.time_step, rate, changing);
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  for (int c = 0; c < controls_; ++c) {
    const int joint = turns_.joint_of(c);
    gradient[c] += time * term(joint, node, values.power(joint, node), weight).slope * rate[c];
  }
  if (weights_.smoothness == 0.0) return;
  const double stiff = weights_.smoothness / motion.time_step;
  if (node > 0) gradient += stiff * difference(motion, node - 1);
  if (node < steps_) gradient -= stiff * difference(motion, node);
  if (periodic_ && node == steps_) gradient -= stiff * difference(motion, 0);
}

Vector3d CostTerms::pull_at_end(const CostedMotion& motion, const CostValues& values) const {
  if (weights_.transport == 0.0) return Vector3d::Zero();
  const double d = values.distance;
  return -weights_.transport * values.reached / (d * d * d) * (motion.position.back() - motion.position.front());
}

// Derivative of the merit by the joints' rates about a node.
VectorXd CostTerms::by_rates(const CostedMotion& motion, const CostValues& values, int node) const {
  VectorXd result = VectorXd::Zero(controls_);
  if (periodic_ && node == 0) node = steps_;
  if (!moves(node)) return result;
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  for (int c = 0; c < controls_; ++c) {
    const int joint = turns_.joint_of(c);
    result[c] = time * term(joint, node, values.power(joint, node), weight).slope * motion.moment[at(node)][c];
  }
  return result;
}

// Second derivatives of a node's term along a row of variables, and the rate of its work; `moments` and `turns`: rates of the
// node's moments and of the joints' turns about it (over twice the time step), [controls][variables].
void CostTerms::add_node_form(const CostedMotion& motion, const CostValues& values, int node, const MatrixXd& moments,
                              const MatrixXd& turns, int tau, MatrixXd& form, VectorXd& work) const {
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  VectorXd rate(controls_), changing(controls_);
  rates(values, node, motion.time_step, rate, changing);
  MatrixXd rate_by = turns;
  if (tau >= 0) rate_by.col(tau) -= changing;
  for (int j = 0; j < system_.joint_count(); ++j) {
    const double power = values.power(j, node);
    const Bend bend = term(j, node, power, weight);
    VectorXd power_by = VectorXd::Zero(form.rows());
    bool any = false;
    for (int c = 0; c < controls_; ++c) {
      if (turns_.joint_of(c) != j) continue;
      any = true;
      const double u = motion.moment[at(node)][c];
      power_by += rate[c] * moments.row(c).transpose() + u * rate_by.row(c).transpose();
      const MatrixXd mixed = time * bend.slope * moments.row(c).transpose() * rate_by.row(c);
      form += mixed + mixed.transpose();
      if (tau < 0) continue;
      const VectorXd slower = time * bend.slope * u * turns.row(c).transpose();
      form.col(tau) -= slower;
      form.row(tau) -= slower.transpose();
      form(tau, tau) += time * bend.slope * u * changing[c];
    }
    if (!any) continue;
    form.noalias() += time * bend.curvature * power_by * power_by.transpose();
    const Bend own = of_work() ? work_term(j, node, power) : Bend{0.0, 0.0, 0.0};
    work += time * own.slope * power_by;
    if (tau < 0) continue;
    form.col(tau) += time * bend.slope * power_by;
    form.row(tau) += time * bend.slope * power_by.transpose();
    form(tau, tau) += time * bend.value;
    work[tau] += time * own.value;
  }
}

// The same of ½|u_{k+1} − u_k|²/h.
void CostTerms::add_difference_form(const CostedMotion& motion, int step, const MatrixXd& difference_by, int tau,
                                    MatrixXd& form) const {
  const double stiff = weights_.smoothness / motion.time_step;
  form.noalias() += stiff * difference_by.transpose() * difference_by;
  if (tau < 0) return;
  const VectorXd change = difference(motion, step);
  const VectorXd slower = stiff * difference_by.transpose() * change;
  form.col(tau) -= slower;
  form.row(tau) -= slower.transpose();
  form(tau, tau) += 0.5 * stiff * change.squaredNorm();
}

// Derivative of a node's terms by the logarithm of the time step, shapes and moments held; smoothness counts at its step's end.
void CostTerms::add_duration(const CostedMotion& motion, const CostValues& values, int node, double& slope) const {
  if (node > 0 && weights_.smoothness > 0.0)
    slope -= 0.5 * weights_.smoothness / motion.time_step * difference(motion, node - 1).squaredNorm();
  if (!moves(node)) return;
  VectorXd rate(controls_), changing(controls_);
  rates(values, node, motion.time_step, rate, changing);
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Bend bend = term(j, node, values.power(j, node), weight);
    slope += time * bend.value;
    for (int c = 0; c < controls_; ++c)
      if (turns_.joint_of(c) == j) slope -= time * bend.slope * motion.moment[at(node)][c] * changing[c];
  }
}

void CostTerms::add_to_model(const CostedMotion& motion, const CostValues& values, const Places& places,
                             const MatrixXd& end_moments, StageModel& model) const {
  const Eigen::Index n = model.Q_end.rows(), m = controls_, ends = Eigen::Index{2} * shape_, all = n + m + 1;
  const bool smooth = weights_.smoothness > 0.0, transport = weights_.transport > 0.0;
  const int second = places.first, before = second + (smooth && periodic_ ? controls_ : 0);
  const int work_place = before + (smooth ? controls_ : 0);
  const double half = 0.5 / motion.time_step;
  MatrixXd turns_before = MatrixXd::Zero(m, ends), turns_after, first_turns;
  MatrixXd form(all, all), moments(m, all), turned(m, all), step_form(ends, ends);
  VectorXd work(all);
  for (int k = 0; k <= steps_; ++k) {
    const bool last = k == steps_;
    MatrixXd& Q = last ? model.Q_end : model.stage[at(places.leads + k)].Q;
    VectorXd& q = last ? model.q_end : model.stage[at(places.leads + k)].q;
    if (k > 0) {  // the step before, at its end
      const VectorXd pull = half * (by_rates(motion, values, k - 1) + by_rates(motion, values, k));
      step_form.setZero();
      turns_.add_curvature(motion.step[at(k - 1)].interval, pull, step_form);
      Q.topLeftCorner(ends, ends) += step_form;
      q.head(ends).noalias() += turns_before.transpose() * pull;
    }
    if (places.tau >= 0) add_duration(motion, values, k, q[places.tau]);
    form.setZero();
    work.setZero();
    if (!last) {
      Stage& stage = model.stage[at(places.leads + k)];
      turns_.derivative(motion.step[at(k)].interval, turns_after);
      if (k == 0) first_turns = turns_after;
      if (smooth) {
        stage.A.middleRows(before, m).setZero();
        stage.B.middleRows(before, m).setIdentity();
        if (periodic_ && k == 1) {
          stage.A.middleRows(second, m).setZero();
          stage.B.middleRows(second, m).setIdentity();
        }
      }
      if (moves(k)) {
        MatrixXd next(ends, all);  // shapes at the step's ends
        next << stage.A.topRows(ends), stage.B.topRows(ends), stage.gap.head(ends);
        moments.setZero();
        moments.middleCols(n, m).setIdentity();
        turned.noalias() = half * turns_after * next;
        turned.leftCols(ends) += half * turns_before;
        add_node_form(motion, values, k, moments, turned, places.tau, form, work);
        if (smooth && k > (periodic_ ? 1 : 0)) {
          moments.middleCols(before, m) = -MatrixXd::Identity(m, m);
          add_difference_form(motion, k - 1, moments, places.tau, form);
        }
      }
      stage.Q += form.topLeftCorner(n, n);
      stage.S += form.block(n, 0, m, n);
      stage.R += form.block(n, n, m, m);
      stage.weight += std::max(form.block(n, n, m, m).diagonal().maxCoeff(), 0.0);
      stage.q += form.col(n + m).head(n);
      stage.r += form.col(n + m).segment(n, m);
      if (transport) {
        stage.A.row(work_place) += work.head(n).transpose();
        stage.B.row(work_place) += work.segment(n, m).transpose();
        stage.gap[work_place] += work[n + m];
      }
      std::swap(turns_before, turns_after);
      continue;
    }
    if (moves(k)) {
      moments.setZero();
      moments.leftCols(n) = end_moments;
      turned.setZero();
      turned.leftCols(ends) = half * turns_before;
      if (periodic_) turned.middleCols(places.copies, ends) += half * first_turns;
      add_node_form(motion, values, k, moments, turned, places.tau, form, work);
      if (smooth && periodic_ && steps_ > 1) {
        MatrixXd first = -moments;
        first.middleCols(second, m) += MatrixXd::Identity(m, m);
        add_difference_form(motion, 0, first, places.tau, form);
      }
      if (smooth && steps_ > (periodic_ ? 1 : 0)) {
        moments.middleCols(before, m) -= MatrixXd::Identity(m, m);
        add_difference_form(motion, k - 1, moments, places.tau, form);
      }
    }
    Q += form.topLeftCorner(n, n);
    if (!transport) continue;
    // J = w W/D
    work[work_place] += 1.0;
    const double d = values.distance, weight = weights_.transport;
    const Vector3d direction = (motion.position.back() - motion.position.front()) / d;
    VectorXd away = VectorXd::Zero(n);
    const Eigen::Index pose = ends;
    const auto shift = pose_basis_.bottomRows<3>();
    away.segment(pose, pose_basis_.cols()) = shift.transpose() * direction;
    q += -weight * values.reached / (d * d) * away;
    const MatrixXd mixed = -weight / (d * d) * work.head(n) * away.transpose();
    Q += mixed + mixed.transpose() + 2.0 * weight * values.reached / (d * d * d) * away * away.transpose();
    const Eigen::Matrix3d bend = (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / d;
    Q.block(pose, pose, pose_basis_.cols(), pose_basis_.cols()) -=
        weight * values.reached / (d * d) * shift.transpose() * bend * shift;
  }
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
    rates(values, k, motion.time_step, rate_, changing_);
    largest_moment = std::max(largest_moment, motion.moment[at(k)].head(controls_).lpNorm<Eigen::Infinity>());
    largest_rate = std::max(largest_rate, rate_.lpNorm<Eigen::Infinity>());
  }
  heaviest_.setConstant(std::numeric_limits<double>::infinity());
  for (int k = 0; k <= steps_; ++k) {
    rates(values, k, motion.time_step, rate_, changing_);
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

void CostTerms::choose_weight(const CostValues& values) {
  if (!of_work()) return;
  const double mean = std::sqrt(values.power.squaredNorm() / static_cast<double>(values.power.size()));
  multipliers_.weight = first_work_weight / std::max(mean, 1e-300);
  multipliers_.largest_weight = largest_work_weight * multipliers_.weight;
}

void CostTerms::take(const WorkMultipliers& from) {
  last_error_ = 0.0;
  multipliers_.value.setZero();
  heaviest_.setConstant(std::numeric_limits<double>::infinity());
  multipliers_.largest_weight = from.largest_weight;
  multipliers_.weight = std::min(from.weight, carried_work_weight / largest_work_weight * from.largest_weight);
  const auto coarse = static_cast<int>(from.value.cols()) - 1;
  if (coarse < 1) return;
  for (int k = 0; k <= steps_; ++k) {
    const double place = static_cast<double>(k) * coarse / steps_;
    const int left = std::min(static_cast<int>(place), coarse - 1);
    const double share = place - left;
    multipliers_.value.col(k) = (1.0 - share) * from.value.col(left) + share * from.value.col(left + 1);
  }
}

}  // namespace lamprey::maneuver
