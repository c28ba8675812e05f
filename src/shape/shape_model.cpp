// Linear-quadratic models of a motion of shapes: how states answer moments, and what both cost to second order.
#include <algorithm>
#include <cmath>

#include "algebra/tiles.hpp"
#include "optimizer/small_dense.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::shape {

namespace {

using maneuver::closure_row;
using maneuver::end_row;
using maneuver::write_shape;
using mechanics::Rotations;
using model::at;
using optimizer::add_product;
using optimizer::set_transposed;
using optimizer::Stage;
using optimizer::StageModel;

constexpr double free_shape_hold = 1e-3;  // metric of a free first shape against that of turns between nodes
constexpr double share_of_time = 0.1;     // of what time costs, that moments are worth at least where limits hold them

}  // namespace

void ShapeProgram::model_node(int k, NodeModel& node) {
  const VectorXd& moment = now_.moment[at(k)];
  moments_.controls(moment, node.control);
  const double weight = node_weight(now_, k);
  node.by_control = moment.head(controls_);
  node.by_control *= weight;
  node.by_control_twice.setIdentity();
  node.by_control_twice *= weight;
  if (!limits_.empty())
    limits_.add_by_moments(k, limited_node(now_, k), now_.limit_value.col(k), node.by_control, node.by_control_twice);
  if (!terms_.empty()) terms_.add_by_moments(costed(now_), now_.terms, k, node.by_control);
  if (maneuver_.periodic && k == steps_) {
    node.by_control += first_node_.by_control;
    node.by_control_twice += first_node_.by_control_twice;
  }
  VectorXd& by_moments = node.multiplier;  // derivative of cost and idle rows
  by_moments.setZero();
  if (k < steps_ || maneuver_.rest || maneuver_.periodic) by_moments.head(controls_) = node.by_control;
  if (k < steps_) by_moments.tail(idle()) = idle_multiplier_[at(k)];
  if (k == steps_)
    for (std::size_t r = 0; r < end_rows_.size(); ++r)
      if (end_rows_[r].kind == EndRow::Kind::moment)
        by_moments[end_rows_[r].index] = end_multiplier_[static_cast<Eigen::Index>(r)] / end_rows_[r].unit;
  if (maneuver_.periodic && k == 0) return;  // the last node's multiplier
  if (joint_by_joint()) {
    moments_.solve_transposed(now_.rotation[at(k)], node.multiplier);
    node.multiplier *= 1.0 / impulse_time(now_, k);
  } else {
    set_transposed(now_.impulse[at(k)], equations_.topLeftCorner(shape_, shape_));
    solve_moments(node.multiplier);
  }
  model_controls(k, node);
}

void ShapeProgram::model_controls(int k, NodeModel& node) {
  // −h_k λ·U is bilinear in the moments and the joints' attitude
  const Rotations& R = now_.rotation[at(k)];
  write_shape(system_, spread_shape(-impulse_time(now_, k), node.multiplier), spread_);
  mechanics::body_turns(system_, R, spread_, spread_turn_);
  moments_.virtual_work_by_shape(R, {spread_, spread_turn_}, by_shape_);
  if (all_shapes_)
    node.control_by_shape = by_shape_;
  else
    algebra::set_product(by_shape_, shape_basis_, node.control_by_shape);
}

// Where the curvature of step k is kept: with the state at its end.
MatrixXd& ShapeProgram::end_form(int k, StageModel& model) const {
  return k + 1 == steps_ ? model.Q_end : model.stage[at(leads_ + k + 1)].Q;
}

void ShapeProgram::model_step(int k, const NodeModel& node, const NodeModel& next, StageModel& model) {
  const int ends = 2 * shape_;
  const bool last = k + 1 == steps_;
  MatrixXd& Q = end_form(k, model);
  if (hessians_in_place()) {
    Q.block(0, ends + 3, ends + 3, 3).setZero();
    Q.block(ends + 3, 0, 3, ends + 6).setZero();
  } else {
    const MatrixXd& hessian = four_hessians_[at(k % 4)];
    const Eigen::Index by_pose = drifts_ ? 6 : 3;  // all of the root's pose, or its turn
    const auto pose_turn = pose_basis_.topRows(by_pose);
    Q.topLeftCorner(ends, ends) = hessian.topLeftCorner(ends, ends);
    Q.block(0, ends, ends, pose_) = hessian.block(0, ends, ends, by_pose).lazyProduct(pose_turn);
    Q.block(ends, 0, pose_, ends) = Q.block(0, ends, ends, pose_).transpose();
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> half =
        hessian.block(ends, ends, by_pose, by_pose).lazyProduct(pose_turn);
    Q.block(ends, ends, pose_, pose_) = pose_turn.transpose().lazyProduct(half);
  }
  if (maneuver_.free_duration) model_impulses_in_time(k, node, next, Q);

  // turns against the node before, weighed by the joints' inertia
  MatrixXd& metric = last ? model.metric_end : model.stage[at(leads_ + k + 1)].metric;
  for (int c = 0; c < shape_; ++c) {
    const double inertia = metric_scale_ * std::abs(after_.minus(c, shape_ + c));
    metric(c, c) = metric(shape_ + c, shape_ + c) = inertia;
    metric(c, shape_ + c) = metric(shape_ + c, c) = -inertia;
  }
}

// Where moments at node k lead: the next shape, by shapes and by moments, and the root with it.
void ShapeProgram::model_motion(int k, MatrixXd& A, MatrixXd& B) {
  const int n = shape_;
  equations_.topLeftCorner(n, n) = after_.minus.middleCols(n, n);
  auto solved = equations_.rightCols(n + felt()).topRows(n);
  if (k > 0)
    solved.leftCols(2 * n) = before_.plus.leftCols(2 * n);
  else
    solved.leftCols(2 * n).setZero();
  solved.middleCols(n, n) -= after_.minus.leftCols(n);
  if (drifts_) find_impulses_by_pose(k, solved.middleCols(2 * n, pose_));
  solved.rightCols(n) = now_.impulse[at(k)];
  algebra::solve_columns(n, equations_);

  A.block(0, n, n, n).setIdentity();
  A.block(n, 0, n, felt()) = solved.leftCols(felt());
  B.middleRows(n, n) = solved.middleCols(felt(), controls_);
  if (all_poses_)
    pose_step_ = after_.pose.leftCols(2 * n);
  else
    pose_step_ = pose_basis_.transpose().lazyProduct(after_.pose.leftCols(2 * n));
  auto pose_by_state = A.block(2 * n, 0, pose_, 2 * n);
  pose_by_state.setZero();
  pose_by_state.rightCols(n) = pose_step_.leftCols(n);
  add_product(1.0, pose_step_.rightCols(n), A.block(n, 0, n, 2 * n), pose_by_state);
  auto pose_by_control = B.middleRows(2 * n, pose_);
  pose_by_control.setZero();
  add_product(1.0, pose_step_.rightCols(n), B.middleRows(n, n), pose_by_control);
  carry_on(k, A);
  if (drifts_)
    add_product(1.0, pose_step_.rightCols(n), A.block(n, 2 * n, n, pose_), A.block(2 * n, 2 * n, pose_, pose_));
}

// What the momentum that node k's steps carry adds to its balance as the root's pose changes there.
void ShapeProgram::find_impulses_by_pose(int k, Eigen::Ref<MatrixXd> impulses) {
  pose_moments_ = after_.minus.middleCols<6>(2 * shape_);
  pose_moments_ *= -1.0;
  if (k > 0) pose_moments_ += before_.plus.middleCols<6>(2 * shape_);
  impulses = pose_moments_.lazyProduct(pose_basis_);
}

// And what they cost.
void ShapeProgram::model_stage(int k, const NodeModel& node, Stage& stage) {
  const int n = shape_;
  stage.shifted = n;
  model_motion(k, stage.A, stage.B);
  const auto by_moments = equations_.rightCols(n).topRows(n);
  if (idle() > 0) {
    MatrixXd& by_idle = next_by_idle_[at(k)];
    by_idle.middleRows(n, n) = by_moments.rightCols(idle());
    algebra::set_product(pose_step_.rightCols(n), by_idle.middleRows(n, n), by_idle.middleRows(2 * n, pose_));
    stage.gap.setZero();
    add_gap(k, now_.moment[at(k)].tail(idle()), stage);
  }

  stage.weight = node_weight(now_, k);
  stage.S.middleCols(n, n) = node.control_by_shape;
  stage.R = node.by_control_twice;
  stage.r = node.by_control;
  stage.gradient =
      stage.weight * std::max(now_.moment[at(k)].head(controls_).lpNorm<Eigen::Infinity>(), least_moment());
  if (maneuver_.free_duration) model_duration(k, node, stage);
}

// What a step only carries on.
void ShapeProgram::carry_on(int k, MatrixXd& A) const {
  const Matrix3d lever = lie::hat(now_.step[at(k)].interval.displacement);
  auto carried = A.block(2 * shape_, 2 * shape_, pose_, pose_);
  carried.setIdentity();
  if (all_poses_) {
    carried.block<3, 3>(3, 0) = -lever;
  } else {
    const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> moved = lever.lazyProduct(pose_basis_.topRows<3>());
    carried -= pose_basis_.bottomRows<3>().transpose().lazyProduct(moved);
  }
  if (drifts_) {
    const Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6> answer =
        after_.pose.middleCols<6>(2 * shape_).lazyProduct(pose_basis_);
    carried += pose_basis_.transpose().lazyProduct(answer);
  }
  const int more = states() - tau();
  A.bottomRightCorner(more, more).setIdentity();
}

// The first step of a periodic motion: its two shapes are known, its moments those of the end.
void ShapeProgram::model_first_shapes(Stage& stage) {
  const int n = shape_;
  stage.A.setZero();
  stage.A.block(0, copies(), 2 * n, 2 * n).setIdentity();
  algebra::set_product(pose_basis_.transpose(), after_.pose, stage.A.block(2 * n, copies(), pose_, 2 * n));
  carry_on(0, stage.A);
  stage.B.setZero();
  stage.gap.setZero();
  stage.S.setZero();
  stage.weight = node_weight(now_, 1);
  stage.R.setIdentity();
  stage.R *= stage.weight;
  stage.r.setZero();
  stage.Q.setZero();
  stage.q.setZero();
}

// Stages before the first step set the logarithm of the duration and the first two shapes, a few at a time.
void ShapeProgram::model_leads(StageModel& model) const {
  for (int s = 0; s < leads_; ++s) {
    Stage& stage = model.stage[at(s)];
    stage.A.setIdentity();
    stage.B.setZero();
    stage.R.setZero();
    stage.weight = metric_scale_;
    for (int c = 0; c < controls_; ++c) {
      const int place = tau() + s * controls_ + c;
      const bool held = maneuver_.periodic && !maneuver_.free_shape && place >= copies() && place < copies() + shape_;
      if (place < own_states() && !held)
        stage.B(place, c) = 1.0;
      else
        stage.R(c, c) = metric_scale_;  // nothing to set
    }
  }
  if (maneuver_.free_duration) model.metric_end(tau(), tau()) = spent(now_);
  if (maneuver_.periodic) {
    const int n = shape_;
    model.metric_end.block(copies(), copies(), 2 * n, 2 * n).setZero();
    for (int c = 0; c < n; ++c) {
      const int first = copies() + c, second = first + n;
      const double hold = free_shape_hold * metric_scale_ * std::abs(first_minus_(c, n + c));
      model.metric_end(first, first) = model.metric_end(second, second) = hold;
    }
  }
}

// At rest the last moments follow from the last two shapes; those of a periodic motion from the first two as well.
void ShapeProgram::find_end_moments_by_state() {
  const int n = shape_, s = felt();
  auto solved = equations_.block(0, n, n, s);
  const auto moments_of = [&](const MatrixXd& impulses) {
    equations_.topLeftCorner(n, n) = now_.impulse.back();
    solved = impulses;
    algebra::solve_columns(n, equations_.leftCols(n + s));
  };
  end_impulses_.leftCols(2 * n) = before_.plus.leftCols(2 * n);
  if (drifts_) algebra::set_product(before_.plus.middleCols<6>(2 * n), pose_basis_, end_impulses_.rightCols(pose_));
  if (resting_) end_impulses_.rightCols(n + pose_) -= carried_at_end_;
  moments_of(end_impulses_);
  end_by_state_.setZero();
  end_by_state_.leftCols(s) = solved;
  end_by_state_.leftCols(s) *= -1.0;
  if (maneuver_.periodic) {
    moments_of(first_minus_);
    end_by_state_.middleCols(copies(), 2 * n) = solved;
  }
  if (maneuver_.free_duration) find_end_moments_by_duration();
}

void ShapeProgram::model_end(const NodeModel& node, StageModel& model) {
  model.q_end.setZero();
  add_displacement(model.q_end);
  if (maneuver_.free_duration) {
    const double cost = cost_of_time(now_);
    model.q_end[tau()] += cost;
    model.Q_end(tau(), tau()) += cost;
  }
  if (!maneuver_.rest && !maneuver_.periodic) return;
  const int n = shape_;
  const VectorXd& moment = now_.moment.back();
  find_end_moments_by_state();
  const auto controls = end_by_state_.topRows(controls_);
  end_weighed_.setZero();
  add_product(1.0, node.by_control_twice, controls, end_weighed_);
  set_transposed(controls, end_transposed_);
  add_product(1.0, end_transposed_, end_weighed_, model.Q_end);
  optimizer::add_transposed_image(1.0, controls, node.by_control, model.q_end);
  // second derivatives by moments and some states
  const auto add_mixed = [&](const Eigen::Ref<const MatrixXd>& by_controls, int place) {
    const Eigen::Index count = by_controls.cols();
    auto columns = end_mixed_.leftCols(count);
    columns.setZero();
    add_product(1.0, end_transposed_, by_controls, columns);
    model.Q_end.middleCols(place, count) += columns;
    for (Eigen::Index c = 0; c < count; ++c) model.Q_end.row(place + c) += columns.col(c).transpose();
  };
  add_mixed(node.control_by_shape, n);
  if (resting_) add_carried_curvature(node.multiplier, model.Q_end);
  if (maneuver_.periodic) add_mixed(first_node_.control_by_shape, copies());
  if (maneuver_.free_duration) {
    const double weight = node_weight(now_, steps_) + (maneuver_.periodic ? node_weight(now_, 0) : 0.0);
    by_moments_ = moment.head(controls_);
    by_moments_ *= weight;
    by_moments_ -= node.by_control;
    add_mixed(by_moments_, tau());
    add_duration(node, moment, weight, model.Q_end, model.q_end);
    if (resting_) {
      timed_.setZero();
      add_carried_at_end(now_, timed_);
      model.Q_end(tau(), tau()) -= node.multiplier.dot(timed_);
    }
    if (maneuver_.periodic) add_effort_mixed(first_node_, moment, copies(), model.Q_end);
  }
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    if (end_rows_[r].kind == EndRow::Kind::moment)
      model.C.row(static_cast<Eigen::Index>(r)) = end_by_state_.row(end_rows_[r].index) / end_rows_[r].unit;
}

// The end rows but those of moments.
void ShapeProgram::model_goal(MatrixXd& C, VectorXd& c) {
  C.setZero();
  c = now_.end_rows;
  const Eigen::Index all = shape_basis_.rows();
  // along some basis, from a row's own place on
  const auto along = [&](const auto& derivative, const MatrixXd& basis, auto row) {
    for (Eigen::Index j = 0; j < basis.cols(); ++j) row[j] = derivative.dot(basis.col(j).transpose());
  };
  for (std::size_t r = 0; r < end_rows_.size(); ++r) {
    if (end_rows_[r].kind == EndRow::Kind::moment) continue;
    auto row = C.row(static_cast<Eigen::Index>(r));
    if (end_rows_[r].kind == EndRow::Kind::closure) {
      closure_row(system_, end_rows_[r], now_.shape.front(), now_.shape.back(), by_first_, by_last_);
      along(by_first_.head(all), shape_basis_, row.segment(copies(), shape_));
      along(by_last_.head(all), shape_basis_, row.segment(shape_, shape_));
      continue;
    }
    end_row(system_, maneuver_, end_rows_[r], now_.rotation.back(), now_.position.back(), by_last_);
    along(by_last_.head(all), shape_basis_, row.segment(shape_, shape_));
    along(by_last_.tail<6>(), pose_basis_, row.segment(2 * shape_, pose_));
  }
}

// What moments cost, with other costs in proportion, or a share of a free duration's cost where they are limited.
double ShapeProgram::worth_of_moments() const {
  double square = 0.0, largest = 0.0;
  for (const VectorXd& moment : now_.moment) square += moment.squaredNorm() / (steps_ + 1);
  double effort = maneuver_.effort * std::sqrt(square);
  if (!terms_.empty()) {
    const double time = maneuver_.time_weight * h_ * now_.stretch * steps_, others = now_.terms.cost;
    const double spent = now_.cost + won(now_);
    effort *= 1.0 + others / std::max(spent - time - others, 1e-6 * spent);
  }
  if (!maneuver_.free_duration) return effort;
  for (const LimitRow& row : limits_.rows())
    if (row.of_moments()) largest += row.bound * row.bound;
  return largest > 0.0 ? std::max(effort, share_of_time * maneuver_.time_weight / std::sqrt(largest)) : effort;
}

void ShapeProgram::linearize(StageModel& model) {
  metric_scale_ = worth_of_moments();
  if (!terms_.empty()) prepare_terms(model);
  model_goal(model.C, model.c);
  model_limits();
  if (resting_) find_carried_at_end();
  for (int first = 0; drifts_ && first < steps_; first += 4) learn_pulls_of_carried(first);
  lay_pose_multipliers(model);
  if (leads_ > 0 || !terms_.empty()) {
    for (Stage& stage : model.stage) {
      stage.Q.setZero();
      stage.q.setZero();
    }
    model.Q_end.setZero();
  }
  if (maneuver_.periodic) {
    model_node(0, first_node_);
    model_node(steps_, node_[0]);
    first_node_.control = node_[0].control;
    first_node_.multiplier = node_[0].multiplier;
    model_controls(0, first_node_);
    node_[0] = first_node_;
  } else {
    model_node(0, node_[0]);
  }
  for (int k = 0; k < steps_; ++k) {
    const int lane = k % 4;
    if (lane == 0) {
      if (k > 0) std::swap(node_[0], node_[4]);
      for (int l = 0; l < std::min(4, steps_ - k); ++l) model_node(k + l + 1, node_[at(l + 1)]);
      differentiate_four(k, &model);
    }
    std::swap(after_, four_tangents_[at(lane)]);
    const NodeModel &node = node_[at(lane)], &next = node_[at(lane + 1)];
    model_step(k, node, next, model);
    Stage& stage = model.stage[at(leads_ + k)];
    if (k > 0) stage.q.setZero();
    if (k == 0) first_minus_ = after_.minus;
    if (k == 0 && maneuver_.periodic)
      model_first_shapes(stage);
    else if (by_shapes())
      model_stage_by_shapes(k, node, stage);
    else
      model_stage(k, node, stage);
    std::swap(before_, after_);
    if (effort_in_fours() && (lane == 3 || k + 1 == steps_)) add_effort(k - lane, model.stage);
  }
  const NodeModel& node = node_[at((steps_ - 1) % 4 + 1)];
  model_end(node, model);
  end_curvature_.add(end_rows_, now_.rotation.back(), end_multiplier_, shape_, 2 * shape_, model.Q_end);
  if (leads_ > 0) model_leads(model);
  add_limit_models(model);
  if (!terms_.empty()) add_term_models(model);
}

// What the end's place wins.
void ShapeProgram::add_displacement(VectorXd& gradient) const {
  const Vector3d& worth = maneuver_.cost_weights.displacement;
  if (!worth.isZero(0.0))
    optimizer::add_transposed_image(-1.0, pose_basis_.bottomRows<3>(), worth, gradient.segment(2 * shape_, pose_));
}

bool ShapeProgram::differentiate(optimizer::StageSlopes& slopes) {
  if (idle() > 0 || !limits_.empty() || !terms_.empty() || maneuver_.free_duration || maneuver_.periodic || drifts_)
    return false;
  model_goal(slopes.C, slopes.c);
  moments_.controls(now_.moment.front(), node_[0].control);
  for (int k = 0; k < steps_; ++k) {
    const int lane = k % 4;
    if (lane == 0) {
      if (k > 0) std::swap(node_[0], node_[4]);
      for (int l = 0; l < std::min(4, steps_ - k); ++l)
        moments_.controls(now_.moment[at(k + l + 1)], node_[at(l + 1)].control);
      differentiate_four(k, nullptr);
    }
    std::swap(after_, four_tangents_[at(lane)]);
    optimizer::StageSlopes::Slope& stage = slopes.stage[at(k)];
    model_pose_by_shapes(k, stage.A, stage.B);
    stage.q.setZero();
    if (!effort_in_fours()) {
      find_moments_by_shapes(k);
      stage.r.setZero();
      optimizer::add_image(node_weight(now_, k), transposed_.bottomRows(shape_), now_.moment[at(k)], stage.r);
      if (k > 0)
        optimizer::add_image(node_weight(now_, k), transposed_.topRows(2 * shape_), now_.moment[at(k)],
                             stage.q.head(2 * shape_));
    } else if (lane == 3 || k + 1 == steps_) {
      add_effort(k - lane, slopes.stage);
    }
    std::swap(before_, after_);
  }
  slopes.q_end.setZero(states());
  add_displacement(slopes.q_end);
  if (!maneuver_.rest) return true;
  find_end_moments_by_state();
  optimizer::add_transposed_image(node_weight(now_, steps_), end_by_state_, now_.moment.back(), slopes.q_end);
  return true;
}

// Of up to four steps that carry momentum: how they answer to the root's pose, moments at their nodes held.
void ShapeProgram::learn_pulls_of_carried(int first) {
  if (first == 0) model_node(0, node_[0]);
  if (first > 0) std::swap(node_[0], node_[4]);
  const int count = std::min(4, steps_ - first);
  for (int l = 0; l < count; ++l) model_node(first + l + 1, node_[at(l + 1)]);
  differentiate_four(first, nullptr);
  for (int l = 0; l < count; ++l) {
    const ShapeTangent& tangent = four_tangents_[at(l)];
    PoseStep& pull = pose_pull_[at(first + l)];
    const Eigen::Index pose = 2 * shape_;
    pull.pose = carried_pose(now_.step[at(first + l)].interval.displacement) + tangent.pose.middleCols<6>(pose);
    pull.moment.setZero();
    optimizer::add_transposed_image(1.0, tangent.minus.middleCols<6>(pose), node_[at(l)].multiplier, pull.moment);
    optimizer::add_transposed_image(-1.0, tangent.plus.middleCols<6>(pose), node_[at(l + 1)].multiplier, pull.moment);
  }
  if (first + count == steps_ && resting_) pull_carried_at_end(node_[at(count)].multiplier);
}

// Multipliers of the root's pose at the nodes, from the end: a position's stays on the way back, a turn's takes up its lever.
void ShapeProgram::lay_pose_multipliers(const StageModel& model) {
  pull_.setZero();
  optimizer::add_transposed_image(1.0, model.C.middleCols(2 * shape_, pose_), end_multiplier_, pull_);
  const Vector6d pose = spread_pose(pull_);
  Vector3d turn = pose.head<3>(), shift = pose.tail<3>();
  shift -= maneuver_.cost_weights.displacement;
  if (!terms_.empty()) shift += terms_.pull_at_end(costed(now_), now_.terms);
  turn += end_pull_.head<3>();
  shift += end_pull_.tail<3>();
  for (int k = steps_; k > 0; --k) {
    if (k < steps_ && drifts_) {
      Vector6d there;
      there << turn, shift;
      const Vector6d here = pose_pull_[at(k)].pose.transpose() * there + pose_pull_[at(k)].moment;
      turn = here.head<3>();
      shift = here.tail<3>();
    } else if (k < steps_) {
      turn += (now_.position[at(k + 1)] - now_.position[at(k)]).cross(shift);
    }
    if (limit_model_[at(k)].any) {
      turn += limit_model_[at(k)].turn;
      shift += limit_model_[at(k)].shift;
    }
    pose_turn_[at(k)] = turn;
    pose_shift_[at(k)] = shift;
  }
}

}  // namespace lamprey::shape
