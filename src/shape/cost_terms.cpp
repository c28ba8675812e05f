#include "shape/cost_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mechanics/continuous.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

namespace {

using maneuver::work_per_distance;
using model::at;
using model::System;
using optimizer::Stage;
using optimizer::StageModel;

}  // namespace

CostTerms::CostTerms(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates)
    : system_(system),
      turns_(system, coordinates.shape),
      pose_basis_(coordinates.pose),
      weights_(maneuver.cost_weights),
      periodic_(maneuver.periodic),
      rest_(maneuver.rest),
      steps_(maneuver.steps),
      shape_(static_cast<int>(coordinates.shape.cols())),
      controls_(system.control_count()),
      start_rate_(VectorXd::Zero(controls_)),
      rate_(controls_, kinds),
      changing_(controls_, kinds),
      difference_(controls_),
      pull_(controls_) {
  for (int d = 0; d < system.drive_count(); ++d) drive_.insert(drive_.end(), at(system.drive(d).controls), d);
  multipliers_.set_zero(system.drive_count(), steps_ + 1);
  heaviest_.setConstant(system.drive_count(), steps_ + 1, std::numeric_limits<double>::infinity());
  settled_.setConstant(system.drive_count(), steps_ + 1, false);
  retarget(maneuver);
}

void CostTerms::retarget(const Maneuver& maneuver) {
  weights_ = maneuver.cost_weights;
  let_signs_change();
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

double CostTerms::weight_of_power(int drive, int node) const {
  return settled_(drive, node) ? 0.0 : std::min(multipliers_.weight, heaviest_(drive, node));
}

WorkTerm CostTerms::work_term(const CostValues& values, int drive, int node) const {
  return shape::work_term({values.power(drive, node), values.change(drive, node)}, multipliers_.at(drive, node),
                          weight_of_power(drive, node));
}

// Of squared power the mean is m² + d²/3.
WorkTerm CostTerms::term(const CostValues& values, int drive, int node, double work_weight) const {
  const NodePower power(values.power(drive, node), values.change(drive, node));
  const Eigen::Vector2d squares(weights_.power, weights_.power / 3.0);
  const Eigen::Vector2d slope = squares.cwiseProduct(power);
  WorkTerm term{slope.dot(power), 2.0 * slope, Eigen::Matrix2d::Zero()};
  term.curvature.diagonal() = 2.0 * squares;
  if (work_weight == 0.0) return term;
  const WorkTerm work = work_term(values, drive, node);
  term.value += work_weight * work.value;
  term.slope += work_weight * work.slope;
  term.curvature += work_weight * work.curvature;
  return term;
}

bool CostTerms::moves(int node) const {
  if (periodic_) return node > 0;  // the first node's moments are the last's
  return node < steps_ || rest_;
}

double CostTerms::node_time(int node, double time_step) const {
  return (!periodic_ && (node == 0 || node == steps_) ? 0.5 : 1.0) * time_step;
}

// Equation 13.2: rates of the joints about a node, and their part that changes with the shapes.
void CostTerms::find_rates(const CostValues& values, int node, double time_step) {
  const double half = 0.5 / time_step;
  changing_.setZero();
  auto mean = changing_.col(0), change = changing_.col(1);
  const auto add = [&](int step, double side) {
    algebra::add_multiple(half, values.turn.col(step), mean);
    algebra::add_multiple(side * half, values.turn.col(step), change);
  };
  if (node > 0) add(node - 1, -1.0);
  if (node < steps_) add(node, 1.0);
  if (periodic_ && node == steps_) add(0, 1.0);
  rate_ = changing_;
  if (node > 0) return;
  algebra::add_multiple(0.5, start_rate_, rate_.col(0));
  algebra::add_multiple(-0.5, start_rate_, rate_.col(1));
}

void CostTerms::find_difference(const CostedMotion& motion, int step) {
  difference_ = motion.moment[at(step + 1)].head(controls_);
  difference_ -= motion.moment[at(step)].head(controls_);
}

void CostTerms::measure(const CostedMotion& motion, CostValues& values) {
  values.turn.resize(controls_, steps_);
  values.power.setZero(system_.drive_count(), steps_ + 1);
  values.change.setZero(system_.drive_count(), steps_ + 1);
  values.parts = CostParts();
  values.reached = 0.0;
  for (int k = 0; k < steps_; ++k) turns_.evaluate(motion.step[at(k)].interval, values.turn.col(k));
  for (int k = 0; k <= steps_; ++k) {
    if (!moves(k)) continue;
    find_rates(values, k, motion.time_step);
    for (int c = 0; c < controls_; ++c) {
      values.power(drive_[at(c)], k) += motion.moment[at(k)][c] * rate_(c, 0);
      values.change(drive_[at(c)], k) += motion.moment[at(k)][c] * rate_(c, 1);
    }
    const double time = node_time(k, motion.time_step);
    for (int d = 0; d < system_.drive_count(); ++d) {
      const NodePower power(values.power(d, k), values.change(d, k));
      values.parts.work += time * mean_work(power);
      values.parts.power += time * (power[0] * power[0] + power[1] * power[1] / 3.0);
      values.reached += time * work_term(values, d, k).value;
    }
  }
  for (int k = 0; k < steps_; ++k) {
    find_difference(motion, k);
    values.parts.smoothness += 0.5 * difference_.squaredNorm() / motion.time_step;
    values.parts.angular_velocity += 0.5 * values.turn.col(k).squaredNorm() / motion.time_step;
  }
  values.distance = (motion.position.back() - motion.position.front()).norm();
  values.parts.transport = work_per_distance(values.parts.work, values.distance, system_.length_unit());
  const double others = weights_.power * values.parts.power + weights_.smoothness * values.parts.smoothness +
                        weights_.angular_velocity * values.parts.angular_velocity;
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
    const WorkTerm bend = term(values, drive_[at(c)], node, weight);
    gradient[c] += time * (bend.slope[0] * rate_(c, 0) + bend.slope[1] * rate_(c, 1));
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

// Derivative of the merit by a turn with which the joints' rates about a node change so.
void CostTerms::add_by_rates(const CostedMotion& motion, const CostValues& values, int node, const NodePower& by_turn) {
  if (periodic_ && node == 0) node = steps_;
  if (!moves(node)) return;
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  for (int c = 0; c < controls_; ++c) {
    const WorkTerm bend = term(values, drive_[at(c)], node, weight);
    pull_[c] += time * bend.slope.dot(by_turn) * motion.moment[at(node)][c];
  }
}

// Second derivatives of a node's term along a row of variables, and the rate of its work, from the rates of the node's moments
// and of the joints' rates about it in moments_ and turned_.
void CostTerms::add_node_form(const CostedMotion& motion, const CostValues& values, int node, int tau) {
  const double time = node_time(node, motion.time_step), weight = work_weight(values);
  find_rates(values, node, motion.time_step);
  for (int a = 0; a < kinds; ++a) {
    rate_by_[at(a)] = turned_[at(a)];
    if (tau >= 0) rate_by_[at(a)].col(tau) -= changing_.col(a);
  }
  for (int d = 0; d < system_.drive_count(); ++d) {
    const auto& [joint, first, controls] = system_.drive(d);
    if (controls == 0) continue;
    const WorkTerm bend = term(values, d, node, weight);
    for (VectorXd& by : power_by_) by.setZero();
    for (int c = first; c < first + controls; ++c) {
      const double u = motion.moment[at(node)][c];
      const auto moment_by = moments_.row(c);
      for (int a = 0; a < kinds; ++a) {
        const double slope = time * bend.slope[a];
        const auto rate_by = rate_by_[at(a)].row(c), turned = turned_[at(a)].row(c);
        algebra::add_multiple(rate_(c, a), moment_by.transpose(), power_by_[at(a)]);
        algebra::add_multiple(u, rate_by.transpose(), power_by_[at(a)]);
        algebra::add_product(slope, moment_by.transpose(), rate_by, form_);
        algebra::add_product(slope, rate_by.transpose(), moment_by, form_);
        if (tau < 0) continue;
        algebra::add_multiple(-slope * u, turned.transpose(), form_.col(tau));
        algebra::add_multiple(-slope * u, turned, form_.row(tau));
        form_(tau, tau) += slope * u * changing_(c, a);
      }
    }
    const bool counted = of_work();
    const WorkTerm own = counted ? work_term(values, d, node) : WorkTerm{};
    for (int a = 0; a < kinds; ++a) {
      const VectorXd& by = power_by_[at(a)];
      for (int b = 0; b < kinds; ++b)
        algebra::add_product(time * bend.curvature(a, b), by, power_by_[at(b)].transpose(), form_);
      if (counted) algebra::add_multiple(time * own.slope[a], by, work_);
      if (tau < 0) continue;
      algebra::add_multiple(time * bend.slope[a], by, form_.col(tau));
      algebra::add_multiple(time * bend.slope[a], by.transpose(), form_.row(tau));
    }
    if (tau < 0) continue;
    form_(tau, tau) += time * bend.value;
    if (counted) work_[tau] += time * own.value;
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
  for (int d = 0; d < system_.drive_count(); ++d) {
    const auto& [joint, first, controls] = system_.drive(d);
    const WorkTerm bend = term(values, d, node, weight);
    slope += time * bend.value;
    for (int c = first; c < first + controls; ++c)
      slope -= time * motion.moment[at(node)][c] * changing_.row(c).dot(bend.slope.transpose());
  }
}

void CostTerms::add_to_model(const CostedMotion& motion, const CostValues& values, const Places& places,
                             const Eigen::Ref<const MatrixXd>& end_moments, StageModel& model) {
  const Eigen::Index ends = Eigen::Index{2} * shape_, all = model.Q_end.rows() + controls_ + 1;
  turns_before_.setZero(controls_, ends);
  next_.resize(ends, all);
  for (MatrixXd* by : {&moments_, &turned_next_, &turned_[0], &turned_[1]}) by->resize(controls_, all);
  for (VectorXd* row : {&work_, &power_by_[0], &power_by_[1], &slower_}) row->resize(all);
  for (int k = 0; k <= steps_; ++k) {
    const bool last = k == steps_;
    MatrixXd& Q = last ? model.Q_end : model.stage[at(places.leads + k)].Q;
    VectorXd& q = last ? model.q_end : model.stage[at(places.leads + k)].q;
    if (k > 0) add_step_form(motion, values, k - 1, places.tau, Q, q);
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
void CostTerms::add_step_form(const CostedMotion& motion, const CostValues& values, int step, int tau, MatrixXd& Q,
                              VectorXd& q) {
  const double half = 0.5 / motion.time_step;
  const Eigen::Index ends = turns_before_.cols();
  pull_.setZero();
  if (weights_.angular_velocity > 0.0) add_angular_velocity(motion, values, step, tau, Q, q);
  add_by_rates(motion, values, step, {half, half});
  add_by_rates(motion, values, step + 1, {half, -half});
  turns_.add_curvature(motion.step[at(step)].interval, pull_, Q.topLeftCorner(ends, ends));
  optimizer::add_transposed_image(1.0, turns_before_, pull_, q.head(ends));
}

// ½ w|ψ|²/h of the joints' turns over a step; what it pulls with goes to pull_.
void CostTerms::add_angular_velocity(const CostedMotion& motion, const CostValues& values, int step, int tau,
                                     MatrixXd& Q, VectorXd& q) {
  const double stiff = weights_.angular_velocity / motion.time_step;
  const Eigen::Index ends = turns_before_.cols();
  const auto turn = values.turn.col(step);
  algebra::add_multiple(stiff, turn, pull_);
  algebra::add_product(stiff, turns_before_.transpose(), turns_before_, Q.topLeftCorner(ends, ends));
  if (tau < 0) return;
  const double value = 0.5 * stiff * turn.squaredNorm();
  turned_pull_.setZero(ends);
  optimizer::add_transposed_image(1.0, turns_before_, pull_, turned_pull_);
  algebra::add_multiple(-1.0, turned_pull_, Q.col(tau).head(ends));
  algebra::add_multiple(-1.0, turned_pull_.transpose(), Q.row(tau).head(ends));
  q[tau] -= value;
  Q(tau, tau) += value;
}

// Of the turns over the steps before and after a node.
void CostTerms::find_turned(const CostedMotion& motion) {
  const double half = 0.5 / motion.time_step;
  turned_next_ *= half;
  for (int a = 0; a < kinds; ++a) {
    turned_[at(a)] = turned_next_;
    algebra::add_multiple(a == 0 ? half : -half, turns_before_, turned_[at(a)].leftCols(turns_before_.cols()));
  }
}

void CostTerms::add_to_stage(const CostedMotion& motion, const CostValues& values, const Places& places, int k,
                             Stage& stage) {
  const Eigen::Index n = stage.Q.rows(), m = controls_, ends = turns_before_.cols();
  const int second = places.first, before = place_before(places), work_place = place_of_work(places);
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
    algebra::set_product(turns_after_, next_, turned_next_);
    find_turned(motion);
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
  if (moves(steps_)) {
    moments_.setZero();
    moments_.leftCols(n) = end_moments;
    turned_next_.setZero();
    if (periodic_) turned_next_.middleCols(places.copies, ends) = first_turns_;
    find_turned(motion);
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

}  // namespace lamprey::shape
