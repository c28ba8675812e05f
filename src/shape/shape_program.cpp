#include "shape/shape_program.hpp"

#include <algorithm>
#include <cmath>

#include "algebra/tiles.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

namespace {

using maneuver::bodies_momentum;
using maneuver::cayley_between;
using maneuver::has_momentum;
using maneuver::is_identity;
using maneuver::move_shape;
using maneuver::shape_size;
using maneuver::stated_end_rows;
using mechanics::Rotations;
using model::at;
using model::System;
using optimizer::Merit;
using optimizer::StageStep;

constexpr double longest_turn = 0.6;     // rad, of one shape coordinate in one step of the search
constexpr double longest_stretch = 0.3;  // of the logarithm of the duration
constexpr double worth_of_round_off =
    1e-8;  // of a momentum, or what turns by 1 rad in a step, over a step: moments that are next to none
constexpr double needed_by_round_off = 1e-6;  // of the same, moments of which round-off leaves idle ones of 2e-11
constexpr double goal_met = 1e-6;             // end rows of a motion that is an answer

}  // namespace

ShapeProgram::NodeModel::NodeModel(const System& system, int shape)
    : control_by_shape(system.control_count(), shape),
      multiplier(shape),
      by_control(system.control_count()),
      by_control_twice(system.control_count(), system.control_count()),
      control(at(system.joint_count())) {}

ShapeProgram::ShapeProgram(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
                           std::vector<EndRow> end_rows, std::vector<LimitRow> limits, Steps use)
    : system_(system),
      maneuver_(maneuver),
      end_rows_(std::move(end_rows)),
      stated_rows_(stated_end_rows(system, maneuver, {})),
      shape_basis_(coordinates.shape),
      pose_basis_(coordinates.pose),
      all_shapes_(is_identity(shape_basis_)),
      all_poses_(is_identity(pose_basis_)),
      steps_(maneuver.steps),
      use_(use),
      drifts_(!maneuver.periodic && has_momentum(system, maneuver.start)),
      shape_(static_cast<int>(shape_basis_.cols())),
      pose_(static_cast<int>(pose_basis_.cols())),
      controls_(system.control_count()),
      terms_(system, maneuver, coordinates),
      leads_((own_states() - tau() + controls_ - 1) / controls_),
      h_(maneuver.time_step()),
      turned_inertia_(MomentumNoise(system).inertia),
      kernel_(system, maneuver.lagrangian, shape_basis_, carries()),
      moments_(system, shape_basis_, maneuver.start.rotation),
      end_curvature_(system, end_rows_, shape_basis_, pose_basis_),
      limits_(system, std::move(limits), coordinates, maneuver.steps, maneuver.duration),
      limit_model_(at(steps_ + 1), limits_.model_of_size()),
      pose_turn_(at(steps_ + 1)),
      pose_shift_(at(steps_ + 1)),
      node_(5, NodeModel(system, shape_)),
      start_impulse_(VectorXd::Zero(shape_)),
      end_multiplier_(VectorXd::Zero(static_cast<Eigen::Index>(end_rows_.size()))),
      end_kept_(end_multiplier_),
      idle_multiplier_(at(steps_), VectorXd::Zero(shape_ - controls_)),
      idle_bend_(idle_multiplier_),
      missed_idle_(shape_ - controls_),
      next_by_idle_(at(steps_), MatrixXd::Zero(states(), shape_ - controls_)),
      buffer_(system.body_count()),
      along_(shape_size(system)),
      spread_(at(system.body_count()), Vector3d::Zero()),
      spread_next_(spread_),
      spread_turn_(spread_),
      work_(shape_size(system), moments_.size()),
      by_shape_(controls_, shape_size(system)),
      equations_(MatrixXd::Zero(mechanics::rows_for(shape_), 2 * shape_ + felt())),
      pose_step_(pose_, 2 * shape_),
      pose_moments_(shape_, 6),
      moments_by_shapes_(shape_, shape_ + felt()),
      weighed_(moments_by_shapes_),
      transposed_(shape_ + felt(), shape_),
      moment_form_(shape_ + felt(), shape_ + felt()),
      pull_(pose_),
      end_by_state_(shape_, states()),
      end_weighed_(controls_, states()),
      end_transposed_(states(), controls_),
      end_mixed_(states(), shape_),
      rate_(shape_),
      ends_rate_(2 * shape_),
      step_rate_(2 * shape_ + step_columns()),
      mixed_(shape_),
      by_moments_(controls_),
      timed_equations_(MatrixXd::Zero(mechanics::rows_for(shape_), shape_ + 1)),
      timed_minus_(VectorXd::Zero(shape_)),
      timed_before_(timed_minus_),
      timed_plus_(timed_minus_),
      timed_first_(timed_minus_),
      timed_(timed_minus_),
      by_first_(shape_size(system) + 6),
      by_last_(shape_size(system) + 6),
      four_tangents_(4),
      four_hessians_(4, MatrixXd(2 * shape_ + step_columns(), 2 * shape_ + step_columns())),
      pose_at_end_(2 * shape_, 2 * shape_ + step_columns()),
      pose_pull_(drifts_ ? at(steps_) : 0),
      end_impulses_(shape_, felt()),
      first_node_(node_.front()) {
  if (!drifts_ && FourSteps::serves(system, maneuver.lagrangian))
    four_steps_.emplace(system, maneuver.lagrangian, shape_basis_);
  if (maneuver.free_duration && system.compliant()) compliant_time_.emplace(system);
  if (limits_.of_moments() && by_shapes()) moments_of_stage_.assign(at(steps_), MatrixXd(shape_, shape_ + felt()));
  if (drifts_ && maneuver.rest) {
    resting_.emplace(system);
    resting_rates_.setZero(shape_size(system), shape_size(system));
    resting_form_ = resting_rates_;
    resting_by_total_.setZero(shape_size(system), 6);
    carried_at_end_.setZero(shape_, shape_ + pose_);
    carried_bend_ = carried_at_end_;
    along_shapes_.setZero(shape_size(system), shape_);
    along_poses_.setZero(shape_size(system), pose_);
    seen_along_poses_.setZero(6, pose_);
    pose_bend_.setZero(pose_, pose_);
  }
  take_start_impulse();
  take_total();
  find_idle_violation();
  for (Motion* motion : {&now_, &trial_}) {
    motion->shape.assign(at(steps_ + 1), Rotations(at(system.body_count()), Matrix3d::Identity()));
    motion->rotation = motion->shape;
    motion->position.assign(at(steps_ + 1), Vector3d::Zero());
    motion->step.assign(at(steps_), keeps_roots_alone() ? ShapeStep::of_root() : ShapeStep(system));
    motion->impulse.assign(at(steps_ + 1), joint_by_joint() ? MatrixXd() : MatrixXd(shape_, shape_));
    motion->moment.assign(at(steps_ + 1), VectorXd::Zero(shape_));
    motion->end_rows = VectorXd::Zero(end_multiplier_.size());
    motion->limit_value.setZero(static_cast<Eigen::Index>(limits_.rows().size()), steps_ + 1);
  }
  if (!limits_.empty()) aloft_ = now_;
}

void ShapeProgram::take_start_impulse() {
  if (maneuver_.periodic) return;
  algebra::set_product(shape_basis_.transpose(), maneuver_.start.momentum.segment(3, shape_basis_.rows()),
                       start_impulse_);
}

// N m, what takes the momentum of the start, and what turns a body by 1 rad in a step, off in one step: of motions that go on by
// themselves moments are what round-off leaves of these, and nothing to measure others by. 0 of a start at rest.
double ShapeProgram::at_once(const Motion& motion) const {
  const double time_step = h_ * motion.stretch;
  return begun_ > 0.0 ? (begun_ + turned_inertia_ / time_step) / time_step : 0.0;
}

double ShapeProgram::least_moment() const { return worth_of_round_off * at_once(now_); }

void ShapeProgram::take_total() {
  begun_ = maneuver_.periodic ? 0.0 : bodies_momentum(system_, maneuver_.start);
  if (drifts_)
    total_ = mechanics::spatial_momentum(system_, maneuver_.start.rotation, Vector3d::Zero(), maneuver_.start.momentum);
}

void ShapeProgram::retarget(const Maneuver& maneuver) {
  maneuver_ = maneuver;
  h_ = maneuver.time_step();
  limits_.take_duration(maneuver.duration);
  terms_.retarget(maneuver);
  take_start_impulse();
  take_total();
  find_idle_violation();
  if (has_motion_) measure(now_);
}

optimizer::StageSizes ShapeProgram::sizes() const {
  return {leads_ + steps_, states(), controls_, static_cast<int>(end_rows_.size())};
}

bool ShapeProgram::go_to(const NodePath& path) {
  for (int k = 0; k <= steps_; ++k) {
    const Rotations& R = path.rotation[at(k)];
    for (std::size_t i = 0; i < R.size(); ++i) now_.shape[at(k)][i] = R[0].transpose() * R[i];
    if (k == steps_) break;
    ShapeStep& step = now_.step[at(k)];
    step.root_turn = R[0].transpose() * path.rotation[at(k + 1)][0];
    step.root_shift = R[0].transpose() * (path.position[at(k + 1)] - path.position[at(k)]);
  }
  end_multiplier_.setZero();
  if (has_multipliers()) end_multiplier_ = end_start_;
  for (VectorXd& multiplier : idle_multiplier_) multiplier.setZero();
  has_motion_ = false;
  if (!limited()) return has_motion_ = roll_out(now_);
  static const LimitMultipliers none;
  const LimitMultipliers& before = limit_start_ ? *limit_start_ : none;
  limits_.take(before, 1.0);
  terms_.take(work_start_);
  if (!roll_out(now_)) return false;
  has_motion_ = true;
  if (!limits_.empty()) {
    if (!(before.weight > 0.0)) limits_.take(before, spent(now_));  // a weight fit for what the guess costs
    limits_.begin(now_.limit_value);
  }
  terms_.choose_weight(now_.terms, end_rows_.empty() || now_.end_rows.lpNorm<Eigen::Infinity>() <= goal_met);
  measure(now_);
  return true;
}

NodePath ShapeProgram::path() const {
  NodePath path;
  write_path(path);
  return path;
}

void ShapeProgram::write_path(NodePath& path) const {
  path.rotation = now_.rotation;
  path.position = now_.position;
  path.cayley.resize(now_.step.size());
  for (std::size_t k = 0; k < now_.step.size(); ++k) {
    if (four_steps_)
      cayley_between(now_.rotation[k], now_.rotation[k + 1], path.cayley[k]);
    else
      path.cayley[k] = now_.step[k].interval.cayley;
  }
  path.control.resize(now_.moment.size());
  for (std::size_t k = 0; k < now_.moment.size(); ++k) path.control[k] = now_.moment[k].head(controls_);
}

// Shapes become a motion from node to node.
bool ShapeProgram::roll_out(Motion& motion) {
  motion.rotation.front() = maneuver_.start.rotation;
  if (maneuver_.periodic)
    for (std::size_t i = 1; i < motion.shape.front().size(); ++i)
      motion.rotation.front()[i] = maneuver_.start.rotation[0] * motion.shape.front()[i];
  motion.position.front() = maneuver_.start.position;
  for (int k = 0; k < steps_; ++k) {
    if (four_steps_) {
      if (k % 4 == 0 && !solve_four(k, motion)) return false;
      follow_root(k, motion);
    } else if (!solve_step(k, motion)) {
      return false;
    }
    if (use_ == Steps::faithful && turns_too_far(motion.rotation[at(k)], motion.rotation[at(k + 1)])) return false;
  }
  measure(motion);
  return std::isfinite(motion.merit.cost);
}

bool ShapeProgram::solve_step(int k, Motion& motion) {
  ShapeStep& step = motion.step[at(k)];
  if (k > 0 && step.momentum_inverse.isZero(0.0)) step.momentum_inverse = motion.step[at(k - 1)].momentum_inverse;
  Vector6d total = Vector6d::Zero();
  if (drifts_)
    total = seen_from_root(total_, motion.rotation[at(k)][0], motion.position[at(k)] - motion.position.front());
  if (!kernel_.solve(h_ * motion.stretch, motion.rotation[at(k)], motion.shape[at(k + 1)], step, total)) return false;
  motion.rotation[at(k + 1)] = step.interval.next_rotation;
  for (Matrix3d& R : motion.rotation[at(k + 1)]) R = lie::renormalized(R);
  motion.position[at(k + 1)] = motion.position[at(k)] + step.interval.displacement;
  return true;
}

// Beyond the last step it is repeated. Where bodies turn far, ShapeKernel may find motions that are not found in fours.
bool ShapeProgram::solve_four(int first, Motion& motion) {
  const auto step = [&](int lane) { return at(std::min(first + lane, steps_ - 1)); };
  const auto each = [&](auto of) { return ForFour<decltype(of(0))>{of(0), of(1), of(2), of(3)}; };
  four_steps_->take_shapes(h_ * motion.stretch, each([&](int l) -> const Rotations* { return &motion.shape[step(l)]; }),
                           each([&](int l) -> const Rotations* { return &motion.shape[step(l) + 1]; }));
  if (four_steps_->solve(each([&](int l) { return &motion.step[step(l)]; }))) return true;
  if (use_ == Steps::faithful) return false;
  for (int k = first; k < std::min(first + 4, steps_); ++k) {
    motion.step[at(k)].momentum_inverse.setZero();
    if (!solve_step(k, motion)) return false;
  }
  return true;
}

// Where the root's motion over step k takes all bodies.
void ShapeProgram::follow_root(int k, Motion& motion) const {
  ShapeStep& step = motion.step[at(k)];
  const Rotations& R = motion.rotation[at(k)];
  Rotations& R_next = motion.rotation[at(k + 1)];
  shape::follow_root(R, motion.shape[at(k + 1)], step, R_next);
  if (wants_intervals()) mechanics::interval_between(system_, R, R_next, step.interval.displacement, step.interval);
  motion.position[at(k + 1)] = motion.position[at(k)] + step.interval.displacement;
}

// Moments by inverse dynamics, what they cost, and what is missed.
void ShapeProgram::measure(Motion& motion) {
  Merit& merit = motion.merit;
  merit = Merit();
  const bool periodic = maneuver_.periodic;
  double needed = needed_by_round_off * at_once(motion), idle_sum = 0.0;
  for (int k = 0; k <= steps_; ++k) {
    MatrixXd& impulse = motion.impulse[at(k)];
    if (!joint_by_joint() || k == steps_) impulse_by_moments(motion, k, impulse);
    VectorXd& moment = motion.moment[at(k)];
    moment.setZero();
    if (periodic && k == 0) continue;                        // the last node's
    if (k == steps_ && !maneuver_.rest && !periodic) break;  // the end is free, and cheapest without moments
    if (k == 0) moment -= start_impulse_;
    if (k > 0) moment -= motion.step[at(k - 1)].plus;
    if (k < steps_) moment += motion.step[at(k)].minus;
    if (k == steps_ && resting_) add_carried_at_end(motion, moment);
    if (periodic && k == steps_) {
      moment += motion.step.front().minus;
      impulse += motion.impulse.front();
    }
    if (joint_by_joint()) {
      moments_.solve(motion.rotation[at(k)], moment);
      moment *= 1.0 / impulse_time(motion, k);
    } else {
      equations_.topLeftCorner(shape_, shape_) = impulse;
      solve_moments(moment);
    }
    const double weight = node_weight(motion, k) + (periodic && k == steps_ ? node_weight(motion, 0) : 0.0);
    merit.cost += 0.5 * weight * moment.head(controls_).squaredNorm();
    needed = std::max(needed, moment.lpNorm<Eigen::Infinity>());
    if (k < steps_) idle_sum += moment.tail(idle()).lpNorm<1>() / steps_;
  }
  if (periodic) motion.moment.front() = motion.moment.back();
  merit.cost -= won(motion);
  if (maneuver_.free_duration) merit.cost += cost_of_time(motion);
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    motion.end_rows[static_cast<Eigen::Index>(r)] = value_of(end_rows_[r], motion);
  merit.violation = motion.end_rows.lpNorm<1>() + idle_sum / std::max(needed, 1e-300);
  motion.cost = merit.cost;
  if (!maneuver_.free_duration) motion.cost += cost_of_time(motion);  // which no step changes
  if (!terms_.empty()) add_terms(motion);
  add_limits(motion);
  weigh_idle(motion);
}

// With what idle moments are worth the cost changes along a step as the Lagrangian does, whose second derivatives are the model's.
void ShapeProgram::weigh_idle(Motion& motion) const {
  if (idle() == 0) return;
  double worth = 0.0;
  for (int k = first_idle_node(); k < steps_; ++k)
    worth += idle_multiplier_[at(k)].dot(motion.moment[at(k)].tail(idle()));
  motion.merit.cost += worth - motion.merit.gaps;
  motion.merit.gaps = worth;
}

double ShapeProgram::won(const Motion& motion) const {
  return maneuver_.cost_weights.displacement.dot(motion.position.back() - motion.position.front());
}

double ShapeProgram::cost_of_time(const Motion& motion) const {
  return maneuver_.time_weight * h_ * motion.stretch * steps_;
}

// What weights are measured against: all that a motion costs, without what it wins or what a given duration costs anyway.
double ShapeProgram::spent(const Motion& motion) const {
  return motion.cost + won(motion) - (maneuver_.free_duration ? 0.0 : cost_of_time(motion));
}

CostedMotion ShapeProgram::costed(const Motion& motion) const {
  return {motion.step, motion.moment, motion.position, h_ * motion.stretch};
}

CostParts ShapeProgram::cost_parts() const {
  CostParts parts = now_.terms.parts;
  parts.time = duration();
  for (int k = 0; k <= steps_; ++k)
    parts.effort += 0.5 * node_weight(now_, k) / maneuver_.effort * now_.moment[at(k)].head(controls_).squaredNorm();
  return parts;
}

void ShapeProgram::add_terms(Motion& motion) {
  terms_.measure(costed(motion), motion.terms);
  motion.cost += motion.terms.cost;
  motion.merit.cost += motion.terms.merit;
}

LimitedNode ShapeProgram::limited_node(const Motion& motion, int k) const {
  return {motion.rotation[at(k)], motion.rotation[at(std::max(k - 1, 0))],
          motion.position[at(k)], motion.moment[at(k)],
          h_ * motion.stretch,    h_ * motion.stretch * steps_};
}

void ShapeProgram::add_limits(Motion& motion) {
  if (limits_.empty()) return;
  for (int k = 0; k <= steps_; ++k) {
    limits_.measure(k, limited_node(motion, k), motion.limit_value.col(k));
    motion.merit.cost += limits_.cost(k, motion.limit_value.col(k), motion.merit.round_off);
  }
}

void ShapeProgram::renew_limits(bool heavier) {
  if (!limits_.empty()) limits_.renew(now_.limit_value, spent(now_));
  terms_.renew(costed(now_), now_.terms, heavier);
  measure(now_);
}

void ShapeProgram::impulse_by_moments(const Motion& motion, int node, MatrixXd& impulse) {
  moments_.virtual_work(motion.rotation[at(node)], work_);
  if (all_shapes_)
    impulse = work_;
  else
    algebra::set_product(shape_basis_.transpose(), work_, impulse);
  impulse *= impulse_time(motion, node);
}

// Coordinates of a shape become all of them.
const VectorXd& ShapeProgram::spread_shape(double factor, const Eigen::Ref<const VectorXd>& shape) {
  if (all_shapes_)
    along_ = shape;
  else
    algebra::set_product(shape_basis_, shape, along_);
  along_ *= factor;
  return along_;
}

// Coordinates of a pose become the root's world turn and position.
Vector6d ShapeProgram::spread_pose(const Eigen::Ref<const VectorXd>& pose) const {
  if (all_poses_) return pose;
  Vector6d whole = Vector6d::Zero();
  optimizer::add_image(1.0, pose_basis_, pose, whole);
  return whole;
}

// Of equations laid in the first columns; right-hand side and result in `values`.
void ShapeProgram::solve_moments(VectorXd& values) {
  equations_.col(shape_).head(shape_) = values;
  algebra::solve_columns(shape_, equations_.leftCols(shape_ + 1));
  values = equations_.col(shape_).head(shape_);
}

const Merit* ShapeProgram::try_step(const StageStep& along, double length) {
  const VectorXd& first = along.state[at(leads_)];
  trial_.stretch = now_.stretch;
  if (maneuver_.free_duration) trial_.stretch *= std::exp(length * first[tau()]);
  trial_.shape.front() = now_.shape.front();
  if (maneuver_.periodic) {
    move_shape(system_, now_.shape.front(), spread_shape(length, first.segment(copies(), shape_)), buffer_,
               trial_.shape.front());
  }
  for (int k = 0; k < steps_; ++k) {
    const VectorXd& there = along.state[at(leads_ + k + 1)];
    move_shape(system_, now_.shape[at(k + 1)], spread_shape(length, there.segment(shape_, shape_)), buffer_,
               trial_.shape[at(k + 1)]);
    // the root's motion to first order
    const Vector6d pose = spread_pose(along.state[at(leads_ + k)].segment(2 * shape_, pose_));
    const Vector6d change = spread_pose(there.segment(2 * shape_, pose_)) - pose;
    const ShapeStep& from = now_.step[at(k)];
    ShapeStep& to = trial_.step[at(k)];
    const Vector3d moved = change.tail<3>() - pose.head<3>().cross(from.interval.displacement);
    to.root_turn =
        from.root_turn * lie::cayley(0.5 * length * (from.interval.next_rotation[0].transpose() * change.head<3>()));
    to.root_shift = from.root_shift + length * (from.interval.rotation[0].transpose() * moved);
    if (!four_steps_) to.momentum_inverse = (trial_.stretch / now_.stretch) * from.momentum_inverse;
  }
  return roll_out(trial_) ? &trial_.merit : nullptr;
}

void ShapeProgram::take_multipliers(const StageStep& step, double length) {
  end_multiplier_ *= 1.0 - length;
  algebra::add_multiple(length, step.end_multiplier, end_multiplier_);
  if (!limits_.empty()) {
    foresee_limits(step);
    limits_.follow(length);
  }
  if (idle() == 0) return;
  for (int k = 0; k < steps_; ++k) {
    idle_multiplier_[at(k)] *= 1.0 - length;
    optimizer::add_transposed_image(-length, next_by_idle_[at(k)], step.costate[at(leads_ + k + 1)],
                                    idle_multiplier_[at(k)]);
  }
  weigh_idle(now_);
}

double ShapeProgram::longest(const StageStep& step, const optimizer::Promise& promise) {
  double turn = 0.0;
  for (std::size_t k = 1; k < step.state.size(); ++k)
    turn = std::max(turn, step.state[k].segment(shape_, shape_).lpNorm<Eigen::Infinity>());
  double length = turn > longest_turn ? longest_turn / turn : 1.0;
  if (maneuver_.free_duration) {
    const double stretch = std::abs(step.state[at(leads_)][tau()]);
    if (stretch * length > longest_stretch) length = longest_stretch / stretch;
  }
  if (limits_.empty()) return length;
  foresee_limits(step);
  return std::min(length, limits_.share_worth(now_.limit_value, promise));
}

}  // namespace lamprey::shape
