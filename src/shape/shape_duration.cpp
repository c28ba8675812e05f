// What a free duration does to a motion of shapes (equations 10.8, 10.9, 10.11, 10.12; with momentum 10.13 to 10.15).
#include "algebra/tiles.hpp"
#include "optimizer/small_dense.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::shape {

namespace {

using maneuver::read_shape;
using maneuver::write_shape;

}  // namespace

using model::at;
using optimizer::Stage;

// Equation 10.9 where a step's impulses are, with springs and dampers 10.12.
void ShapeProgram::model_impulses_in_time(int k, const NodeModel& node, const NodeModel& next, MatrixXd& Q) {
  const int n = shape_;
  if (drifts_) {
    const auto by_time = four_hessians_[at(k % 4)].col(2 * n + 6);
    ends_rate_ = by_time.head(2 * n);
    const auto by_pose = Q.col(tau()).segment(2 * n, pose_);
    optimizer::add_transposed_image(1.0, pose_basis_, by_time.segment<6>(2 * n), Q.col(tau()).segment(2 * n, pose_));
    Q.row(tau()).segment(2 * n, pose_) = by_pose.transpose();
    Q(tau(), tau()) += by_time[2 * n + 6];
  } else {
    ends_rate_.setZero();
    optimizer::add_transposed_image(1.0, after_.plus, next.multiplier, ends_rate_);
    optimizer::add_transposed_image(-1.0, after_.minus, node.multiplier, ends_rate_);
  }
  if (compliant_time_) {
    std::swap(timed_before_, timed_plus_);
    if (k == 0) timed_before_.setZero();
    const mechanics::Interval& interval = now_.step[at(k)].interval;
    const double time_step = h_ * now_.stretch;
    compliant_time_->evaluate(time_step, interval);
    along_shape(compliant_time_->minus(), timed_minus_);
    along_shape(compliant_time_->plus(), timed_plus_);
    if (k == 0) timed_first_ = timed_minus_;
    write_shape(system_, spread_shape(1.0, node.multiplier), spread_);
    write_shape(system_, spread_shape(1.0, next.multiplier), spread_next_);
    compliant_time_->differentiate(time_step, interval, spread_, spread_next_);
    along_shape(compliant_time_->by_left(), rate_);
    ends_rate_.head(n) -= rate_;
    along_shape(compliant_time_->by_right(), rate_);
    ends_rate_.tail(n) -= rate_;
    along_shape(compliant_time_->damped_minus(), rate_);
    Q(tau(), tau()) -= rate_.dot(node.multiplier);
    along_shape(compliant_time_->damped_plus(), rate_);
    Q(tau(), tau()) += rate_.dot(next.multiplier);
  }
  Q.row(tau()).head(2 * n) = ends_rate_.transpose();
  Q.col(tau()).head(2 * n) = ends_rate_;
}

// Impulses of a step that carries momentum fall with e^−τ between given motions of the root, and the root's motion answers to
// what is carried: equation 10.15 but for the curvature by that, which the Hessian holds already.
void ShapeProgram::add_carried_in_time(const ShapeMultipliers& multipliers, const ShapeTangent& tangent,
                                       MatrixXd& hessian) {
  const Eigen::Index time = 2 * Eigen::Index{shape_} + 6;
  step_rate_.setZero();
  optimizer::add_transposed_image(1.0, tangent.plus, multipliers.plus, step_rate_);
  optimizer::add_transposed_image(-1.0, tangent.minus, multipliers.minus, step_rate_);
  hessian.col(time) += step_rate_;
  hessian.row(time) += step_rate_.transpose();
}

// Freedoms of the bodies become coordinates of the shape.
void ShapeProgram::along_shape(const mechanics::Freedoms& freedoms, VectorXd& shape) {
  read_shape(system_, freedoms, along_);
  if (all_shapes_)
    shape = along_;
  else
    algebra::set_product(shape_basis_.transpose(), along_, shape);
}

// The last moments by the logarithm of the duration.
void ShapeProgram::find_end_moments_by_duration() {
  auto column = end_by_state_.col(tau());
  column = now_.moment.back();
  column *= -2.0;
  if (!compliant_time_ && !drifts_) return;
  timed_.setZero();
  if (compliant_time_) timed_ -= timed_plus_;
  if (compliant_time_ && maneuver_.periodic) timed_ += timed_first_;
  if (drifts_) timed_ -= before_.plus.col(2 * shape_ + 6);
  if (resting_) add_carried_at_end(now_, timed_);
  equations_.topLeftCorner(shape_, shape_) = now_.impulse.back();
  solve_moments(timed_);
  column += timed_;
}

// Equations 10.8 and 10.9, after model_motion.
void ShapeProgram::model_duration(int k, const NodeModel& node, Stage& stage) {
  const int n = shape_;
  const VectorXd& moment = now_.moment[at(k)];
  rate_.setZero();
  optimizer::add_image(2.0, equations_.topRightCorner(n, n), moment, rate_);
  timed_ = timed_before_;
  timed_ -= timed_minus_;
  if (k == 0) timed_ += start_impulse_;
  if (drifts_) timed_ -= after_.minus.col(2 * n + 6);
  if (drifts_ && k > 0) timed_ += before_.plus.col(2 * n + 6);
  if (!timed_.isZero(0.0)) {
    timed_equations_.topLeftCorner(n, n) = after_.minus.middleCols(n, n);
    timed_equations_.col(n).head(n) = timed_;
    algebra::solve_columns(n, timed_equations_);
    rate_ += timed_equations_.col(n).head(n);
  }
  stage.A.block(n, tau(), n, 1) = rate_;
  algebra::set_product(pose_step_.rightCols(n), rate_, stage.A.block(2 * n, tau(), pose_, 1));
  if (drifts_)
    optimizer::add_transposed_image(1.0, pose_basis_, after_.pose.col(2 * n + 6),
                                    stage.A.col(tau()).segment(2 * n, pose_));
  add_duration(node, moment, stage.weight, stage.Q, stage.q);
  stage.S.col(tau()) = moment.head(controls_);
  stage.S.col(tau()) *= stage.weight;
  stage.S.col(tau()) -= node.by_control;
  if (k == 0) stage.Q(tau(), tau()) += node.multiplier.dot(start_impulse_);
}

// What the logarithm of the duration does at a node: the effort lasts longer, moments fall with its square.
void ShapeProgram::add_duration(const NodeModel& node, const VectorXd& moment, double weight, MatrixXd& Q,
                                VectorXd& q) {
  const double effort = 0.5 * weight * moment.head(controls_).squaredNorm();
  q[tau()] += effort;
  Q(tau(), tau()) += effort;
  add_effort_mixed(node, moment, shape_, Q);
}

// And with the shape that lies at `place` of a state.
void ShapeProgram::add_effort_mixed(const NodeModel& node, const VectorXd& moment, int place, MatrixXd& Q) {
  mixed_.setZero();
  optimizer::add_transposed_image(2.0, node.control_by_shape, moment.head(controls_), mixed_);
  Q.row(tau()).segment(place, shape_) += mixed_.transpose();
  Q.col(tau()).segment(place, shape_) += mixed_;
}

}  // namespace lamprey::shape
