#include "maneuver/shape_program.hpp"

#include <algorithm>
#include <cmath>

namespace lamprey::maneuver {

namespace {

using mechanics::Freedoms;
using mechanics::Moments;
using mechanics::Rotations;
using model::at;
using model::System;
using optimizer::Merit;
using optimizer::Stage;
using optimizer::StageModel;
using optimizer::StageStep;

constexpr double longest_turn = 0.6;  // rad, of one shape coordinate in one step of the search

}  // namespace

ShapeProgram::ShapeProgram(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
                           std::vector<EndRow> end_rows)
    : system_(system),
      maneuver_(maneuver),
      end_rows_(std::move(end_rows)),
      shape_basis_(coordinates.shape),
      pose_basis_(coordinates.pose),
      steps_(maneuver.steps),
      shape_(static_cast<int>(shape_basis_.cols())),
      pose_(static_cast<int>(pose_basis_.cols())),
      controls_(system.control_count()),
      h_(maneuver.time_step()),
      kernel_(system, maneuver.lagrangian, shape_basis_),
      moments_(system, shape_basis_, maneuver.start.rotation),
      end_multiplier_(VectorXd::Zero(static_cast<Eigen::Index>(end_rows_.size()))),
      idle_multiplier_(at(steps_), VectorXd::Zero(shape_ - controls_)),
      next_by_idle_(at(steps_), MatrixXd(2 * shape_ + pose_, shape_ - controls_)),
      buffer_(system.body_count()),
      hessian_(2 * shape_ + 3, 2 * shape_ + 3) {
  for (Motion* motion : {&now_, &trial_}) {
    motion->shape.assign(at(steps_ + 1), Rotations(at(system.body_count()), Matrix3d::Identity()));
    motion->rotation = motion->shape;
    motion->position.assign(at(steps_ + 1), Vector3d::Zero());
    motion->step.assign(at(steps_), ShapeStep(system));
    motion->impulse.assign(at(steps_ + 1), MatrixXd(shape_, shape_));
    motion->moment.assign(at(steps_ + 1), VectorXd::Zero(shape_));
    motion->end_rows = VectorXd::Zero(end_multiplier_.size());
  }
}

optimizer::StageSizes ShapeProgram::sizes() const {
  return {steps_, 2 * shape_ + pose_, controls_, static_cast<int>(end_rows_.size()), shape_};
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
  for (VectorXd& multiplier : idle_multiplier_) multiplier.setZero();
  return roll_out(now_);
}

NodePath ShapeProgram::path() const {
  NodePath path;
  path.rotation = now_.rotation;
  path.position = now_.position;
  for (const ShapeStep& step : now_.step) path.cayley.push_back(step.interval.cayley);
  for (const VectorXd& moment : now_.moment) path.control.push_back(moment.head(controls_));
  return path;
}

// Shapes become a motion from node to node.
bool ShapeProgram::roll_out(Motion& motion) {
  motion.rotation.front() = maneuver_.start.rotation;
  motion.position.front() = maneuver_.start.position;
  for (int k = 0; k < steps_; ++k) {
    ShapeStep& step = motion.step[at(k)];
    if (!kernel_.solve(h_, motion.rotation[at(k)], motion.shape[at(k + 1)], step)) return false;
    motion.rotation[at(k + 1)] = step.interval.next_rotation;
    for (Matrix3d& R : motion.rotation[at(k + 1)]) R = lie::renormalized(R);
    motion.position[at(k + 1)] = motion.position[at(k)] + step.interval.displacement;
  }
  measure(motion);
  return std::isfinite(motion.merit.cost);
}

// Moments by inverse dynamics, what they cost, and what is missed.
void ShapeProgram::measure(Motion& motion) {
  Merit& merit = motion.merit;
  merit = Merit();
  double needed = 0.0, idle_sum = 0.0;
  for (int k = 0; k <= steps_; ++k) {
    impulse_by_moments(motion.rotation[at(k)], k, motion.impulse[at(k)]);
    VectorXd& moment = motion.moment[at(k)];
    moment.setZero();
    if (k == steps_ && !maneuver_.rest) break;  // the end is free, and cheapest without moments
    if (k == 0) moment.noalias() -= shape_basis_.transpose() * maneuver_.start.momentum.segment(3, shape_basis_.rows());
    if (k > 0) moment -= motion.step[at(k - 1)].plus;
    if (k < steps_) moment += motion.step[at(k)].minus;
    moment = motion.impulse[at(k)].partialPivLu().solve(moment).eval();
    merit.cost += 0.5 * maneuver_.node_weight[k] * moment.head(controls_).squaredNorm();
    needed = std::max(needed, moment.lpNorm<Eigen::Infinity>());
    if (k < steps_) idle_sum += moment.tail(idle()).lpNorm<1>() / steps_;
  }
  Eigen::RowVectorXd unused(shape_size(system_) + 6);
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    motion.end_rows[static_cast<Eigen::Index>(r)] =
        end_rows_[r].kind == EndRow::Kind::moment
            ? motion.moment.back()[end_rows_[r].index]
            : end_row(system_, maneuver_, end_rows_[r], motion.rotation.back(), motion.position.back(), unused);
  merit.violation = motion.end_rows.lpNorm<1>() + idle_sum / std::max(needed, 1e-300);
}

void ShapeProgram::impulse_by_moments(const Rotations& rotation, int node, MatrixXd& impulse) {
  impulse.noalias() = shape_basis_.transpose() * moments_.virtual_work(rotation);
  impulse *= impulse_time(node);
}

void ShapeProgram::model_node(int k, NodeModel& node) {
  const VectorXd& moment = now_.moment[at(k)];
  node.control = moments_.controls(moment);
  VectorXd by_moments = VectorXd::Zero(shape_);  // derivative of cost and idle rows
  if (k < steps_ || maneuver_.rest) by_moments.head(controls_) = maneuver_.node_weight[k] * moment.head(controls_);
  if (k < steps_) by_moments.tail(idle()) = idle_multiplier_[at(k)];
  if (k == steps_)
    for (std::size_t r = 0; r < end_rows_.size(); ++r)
      if (end_rows_[r].kind == EndRow::Kind::moment)
        by_moments[end_rows_[r].index] = end_multiplier_[static_cast<Eigen::Index>(r)];
  node.multiplier = now_.impulse[at(k)].transpose().partialPivLu().solve(by_moments);

  // −h_k λ·U is bilinear in the moments and the joints' attitude
  const Rotations& R = now_.rotation[at(k)];
  const std::size_t bodies = at(system_.body_count());
  Freedoms along(bodies, Vector3d::Zero());
  mechanics::Vectors turns(bodies), unit_turns(bodies), changes(bodies);
  Moments rate(at(system_.joint_count()));
  VectorXd row(shape_);
  const VectorXd spread = -impulse_time(k) * (shape_basis_ * node.multiplier);
  for_each_coordinate(system_, [&](const Freedoms& unit, int coordinate) {
    for (std::size_t i = 1; i < bodies; ++i) along[i] += spread[coordinate] * unit[i];
  });
  mechanics::body_turns(system_, R, along, turns);
  MatrixXd by_shape(controls_, shape_size(system_));
  for_each_coordinate(system_, [&](const Freedoms& unit, int coordinate) {
    mechanics::body_turns(system_, R, unit, unit_turns);
    mechanics::body_turn_changes(system_, R, along, turns, unit, changes);
    mechanics::control_work_rate(system_, R, {along, turns}, {unit, unit_turns}, changes, rate);
    moments_.gather(rate, row);
    by_shape.col(coordinate) = row.head(controls_);
  });
  node.control_by_shape.noalias() = by_shape * shape_basis_;
}

// Curvature of step k, kept with the state at its end.
void ShapeProgram::model_step(int k, const NodeModel& node, const NodeModel& next, const Vector3d& turn,
                              const Vector3d& shift, StageModel& model) {
  ShapeStep& step = now_.step[at(k)];
  kernel_.tangent(h_, node.control, next.control, step, after_);
  kernel_.curvature(h_, node.control, next.control, step, after_, {node.multiplier, next.multiplier, turn, shift},
                    hessian_);
  const int ends = 2 * shape_;
  // the hessian takes the root's turn ρ at the beginning, which is ρ' at the end less what the step adds
  const auto added = after_.pose.topRows<3>();
  const auto pose_turn = pose_basis_.topRows<3>();
  const auto by_turn = hessian_.topRightCorner(ends, 3);
  const auto turn_turn = hessian_.bottomRightCorner<3, 3>();
  const bool last = k + 1 == steps_;
  MatrixXd& Q = last ? model.Q_end : model.stage[at(k + 1)].Q;
  const MatrixXd mixed = by_turn * added;
  const MatrixXd bent = added.transpose() * turn_turn;
  Q.topLeftCorner(ends, ends) = hessian_.topLeftCorner(ends, ends) - mixed - mixed.transpose() + bent * added;
  Q.topRightCorner(ends, pose_) = (by_turn - bent) * pose_turn;
  Q.bottomLeftCorner(pose_, ends) = Q.topRightCorner(ends, pose_).transpose();
  Q.bottomRightCorner(pose_, pose_) = pose_turn.transpose() * turn_turn * pose_turn;

  // turns against the node before, weighed by the joints' inertia
  MatrixXd& metric = last ? model.metric_end : model.stage[at(k + 1)].metric;
  const auto inertia = (metric_scale_ * after_.minus.rightCols(shape_).diagonal().cwiseAbs()).eval();
  metric.topLeftCorner(shape_, shape_) = inertia.asDiagonal();
  metric.block(shape_, shape_, shape_, shape_) = inertia.asDiagonal();
  metric.block(0, shape_, shape_, shape_) = (-inertia).asDiagonal();
  metric.block(shape_, 0, shape_, shape_) = (-inertia).asDiagonal();
}

// Where moments at node k lead, and what they cost.
void ShapeProgram::model_stage(int k, const NodeModel& node, Stage& stage) {
  const int n = shape_;
  const Eigen::PartialPivLU<MatrixXd> by_next(after_.minus.rightCols(n));
  MatrixXd by_state(n, 2 * n);  // of the shape k + 1
  by_state.rightCols(n) = -after_.minus.leftCols(n);
  by_state.leftCols(n).setZero();
  if (k > 0) by_state += before_.plus;
  by_state = by_next.solve(by_state).eval();
  const MatrixXd by_moments = by_next.solve(now_.impulse[at(k)]);

  const MatrixXd pose = pose_basis_.transpose() * after_.pose;
  Matrix6d carried = Matrix6d::Identity();
  carried.bottomLeftCorner<3, 3>() = -lie::hat(now_.step[at(k)].interval.displacement);
  stage.A.block(0, n, n, n).setIdentity();
  stage.A.block(n, 0, n, 2 * n) = by_state;
  stage.A.block(2 * n, 0, pose_, 2 * n).noalias() = pose.rightCols(n) * by_state;
  stage.A.block(2 * n, n, pose_, n) += pose.leftCols(n);
  stage.A.bottomRightCorner(pose_, pose_) = pose_basis_.transpose() * carried * pose_basis_;
  stage.B.middleRows(n, n) = by_moments.leftCols(controls_);
  stage.B.bottomRows(pose_).noalias() = pose.rightCols(n) * by_moments.leftCols(controls_);
  MatrixXd& by_idle = next_by_idle_[at(k)];
  by_idle.topRows(n).setZero();
  by_idle.middleRows(n, n) = by_moments.rightCols(idle());
  by_idle.bottomRows(pose_).noalias() = pose.rightCols(n) * by_moments.rightCols(idle());
  stage.gap.noalias() = -by_idle * now_.moment[at(k)].tail(idle());

  stage.weight = maneuver_.node_weight[k];
  stage.S.middleCols(n, n) = node.control_by_shape;
  stage.R.diagonal().setConstant(stage.weight);
  stage.r = stage.weight * now_.moment[at(k)].head(controls_);
}

// At rest the last moments follow from the last two shapes.
void ShapeProgram::model_end(const NodeModel& node, StageModel& model) const {
  model.q_end.setZero();
  if (!maneuver_.rest) return;
  const int n = shape_;
  const MatrixXd by_state = -now_.impulse.back().partialPivLu().solve(before_.plus);
  const auto controls = by_state.topRows(controls_);
  const double weight = maneuver_.node_weight[steps_];
  const MatrixXd mixed = node.control_by_shape.transpose() * controls;
  model.Q_end.topLeftCorner(2 * n, 2 * n).noalias() += weight * controls.transpose() * controls;
  model.Q_end.block(n, 0, n, 2 * n) += mixed;
  model.Q_end.block(0, n, 2 * n, n) += mixed.transpose();
  model.q_end.head(2 * n).noalias() = weight * controls.transpose() * now_.moment.back().head(controls_);
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    if (end_rows_[r].kind == EndRow::Kind::moment)
      model.C.row(static_cast<Eigen::Index>(r)).head(2 * n) = by_state.row(end_rows_[r].index);
}

// The end rows but those of moments.
void ShapeProgram::model_goal(StageModel& model) const {
  model.C.setZero();
  model.c = now_.end_rows;
  const Eigen::Index all = shape_basis_.rows();
  Eigen::RowVectorXd derivative(all + 6);
  for (std::size_t r = 0; r < end_rows_.size(); ++r) {
    if (end_rows_[r].kind == EndRow::Kind::moment) continue;
    end_row(system_, maneuver_, end_rows_[r], now_.rotation.back(), now_.position.back(), derivative);
    auto row = model.C.row(static_cast<Eigen::Index>(r));
    row.segment(shape_, shape_).noalias() = derivative.head(all) * shape_basis_;
    row.tail(pose_).noalias() = derivative.tail<6>() * pose_basis_;
  }
}

void ShapeProgram::linearize(StageModel& model) {
  metric_scale_ = 0.0;
  for (const VectorXd& moment : now_.moment) metric_scale_ += moment.squaredNorm() / (steps_ + 1);
  metric_scale_ = std::sqrt(metric_scale_);
  model_goal(model);
  // multipliers of the root's pose at the end: its position's stays, its turn's takes up the lever on the way back
  const VectorXd pose = pose_basis_ * (model.C.rightCols(pose_).transpose() * end_multiplier_);
  const Vector3d turn = pose.head<3>(), shift = pose.tail<3>();
  NodeModel node, next;
  model_node(0, node);
  for (int k = 0; k < steps_; ++k) {
    model_node(k + 1, next);
    const Vector3d lever = now_.position.back() - now_.position[at(k + 1)];
    model_step(k, node, next, turn + lever.cross(shift), shift, model);
    model_stage(k, node, model.stage[at(k)]);
    std::swap(node, next);
    std::swap(before_, after_);
  }
  model_end(node, model);
}

const Merit* ShapeProgram::try_step(const StageStep& along, double length) {
  trial_.shape.front() = now_.shape.front();
  for (int k = 0; k < steps_; ++k) {
    const VectorXd& there = along.state[at(k + 1)];
    move_shape(system_, now_.shape[at(k + 1)], length * (shape_basis_ * there.segment(shape_, shape_)), buffer_,
               trial_.shape[at(k + 1)]);
    // the root's motion to first order
    const Vector6d pose = pose_basis_ * along.state[at(k)].tail(pose_);
    const Vector6d change = pose_basis_ * there.tail(pose_) - pose;
    const ShapeStep& from = now_.step[at(k)];
    ShapeStep& to = trial_.step[at(k)];
    const Vector3d moved = change.tail<3>() - pose.head<3>().cross(from.interval.displacement);
    to.root_turn =
        from.root_turn * lie::cayley(0.5 * length * (from.interval.next_rotation[0].transpose() * change.head<3>()));
    to.root_shift = from.root_shift + length * (from.interval.rotation[0].transpose() * moved);
    to.momentum_inverse = from.momentum_inverse;
  }
  return roll_out(trial_) ? &trial_.merit : nullptr;
}

VectorXd ShapeProgram::idle_multiplier(const StageStep& step, int k) const {
  return -(next_by_idle_[at(k)].transpose() * step.costate[at(k + 1)]);
}

void ShapeProgram::take_multipliers(const StageStep& step, double length) {
  end_multiplier_ += length * (step.end_multiplier - end_multiplier_);
  if (idle() == 0) return;
  for (int k = 0; k < steps_; ++k)
    idle_multiplier_[at(k)] += length * (idle_multiplier(step, k) - idle_multiplier_[at(k)]);
}

double ShapeProgram::longest(const StageStep& step) const {
  double turn = 0.0;
  for (std::size_t k = 1; k < step.state.size(); ++k)
    turn = std::max(turn, step.state[k].segment(shape_, shape_).lpNorm<Eigen::Infinity>());
  return turn > longest_turn ? longest_turn / turn : 1.0;
}

double ShapeProgram::goal_error() const {
  double error = 0.0;
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    if (end_rows_[r].kind != EndRow::Kind::moment)
      error = std::max(error, std::abs(now_.end_rows[static_cast<Eigen::Index>(r)]));
  return error;
}

}  // namespace lamprey::maneuver
