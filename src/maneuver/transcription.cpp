#include "maneuver/transcription.hpp"

#include <cmath>

#include "maneuver/control_path.hpp"
#include "maneuver/step_chart.hpp"

namespace lamprey::maneuver {

namespace {

using Eigen::Vector4d;
using mechanics::Interval;
using mechanics::StepDirection;
using model::System;

using model::at;

bool is_ancestor(const System& system, int ancestor, int body) {
  for (int i = body; i >= 0; i = system.body(i).parent)
    if (i == ancestor) return true;
  return false;
}

}  // namespace

std::vector<GoalRow> stated_goal_rows(const System& system, const Maneuver& maneuver) {
  std::vector<GoalRow> rows;
  for (int i = 0; i < system.body_count(); ++i)
    if (maneuver.end_rotation[at(i)])
      for (int c = 0; c < 3; ++c) rows.push_back({GoalRow::Kind::rotation, i, c});
  for (int c = 0; c < 3; ++c)
    if (maneuver.end_position[at(c)]) rows.push_back({GoalRow::Kind::position, 0, c});
  if (maneuver.rest)  // the root rests with the others because total momentum is zero
    for (int i = 1; i < system.body_count(); ++i)
      for (int c = 0; c < 3; ++c) rows.push_back({GoalRow::Kind::rest, i, c});
  return rows;
}

Transcription::Transcription(const System& system, const Maneuver& maneuver, std::vector<GoalRow> goal_rows)
    : system_(system),
      maneuver_(maneuver),
      goal_rows_(std::move(goal_rows)),
      bodies_(system.body_count()),
      steps_(maneuver.steps),
      controls_(system.control_count()),
      h_(maneuver.time_step()),
      intervals_(at(maneuver.steps), Interval(system.body_count())),
      momenta_(at(maneuver.steps), mechanics::DiscreteMomenta(system.body_count())),
      work_(system.body_count()),
      lagrangian_(system.body_count()),
      directional_(system.body_count()),
      jacobian_(system.body_count()) {
  lay_out();
  lay_patterns();
}

void Transcription::lay_out() {
  stage_size_ = controls_ + 7 * bodies_ + 3;
  stage_rows_ = 4 * bodies_ + 6 + 3 * (bodies_ - 1);
  variable_count_ = spline_variable();
  constraint_count_ = spline_row();
  for (const GoalRow& row : goal_rows_) rests_ = rests_ || row.kind == GoalRow::Kind::rest;
  if (maneuver_.spline_points > 0) {
    const VectorXd times = VectorXd::LinSpaced(steps_ + 1, 0.0, maneuver_.duration);
    spline_basis_ = natural_spline_basis(maneuver_.spline_points, maneuver_.duration, times);
    variable_count_ += maneuver_.spline_points * controls_;
    constraint_count_ += (steps_ + 1) * controls_;
  }
  zero_ = VectorXd::Zero(constraint_count_);
  related_.assign(at(bodies_), std::vector<char>(at(bodies_)));
  for (int i = 0; i < bodies_; ++i)
    for (int a = 0; a < bodies_; ++a) related_[at(i)][at(a)] = is_ancestor(system_, a, i) || is_ancestor(system_, i, a);
}

// The derivative functions themselves record their pattern, at an arbitrary point: order and places never depend on it.
void Transcription::lay_patterns() {
  NodePath still;
  still.rotation.assign(at(steps_ + 1), maneuver_.start.rotation);
  still.position.assign(at(steps_ + 1), maneuver_.start.position);
  still.cayley.assign(at(steps_), std::vector<Vector3d>(at(bodies_), Vector3d::Zero()));
  still.control.assign(at(steps_ + 1), VectorXd::Zero(controls_));
  const VectorXd x = pack(still);
  VectorXd unused;
  jacobian(x, unused);
  hessian(x, 1.0, zero_, unused);
}

optimizer::StageOrder Transcription::stages() const {
  optimizer::StageOrder order;
  order.stage_of_variable.assign(at(variable_count_), -1);
  order.stage_of_constraint.assign(at(constraint_count_), -1);
  for (int i = 0; i < spline_variable(); ++i) order.stage_of_variable[at(i)] = i / stage_size_;
  for (int r = 0; r < goal_row(); ++r) order.stage_of_constraint[at(r)] = r / stage_rows_;
  for (int r = goal_row(); r < spline_row(); ++r) order.stage_of_constraint[at(r)] = steps_;
  for (int r = spline_row(); r < constraint_count_; ++r)
    order.stage_of_constraint[at(r)] = (r - spline_row()) / controls_;
  return order;
}

// ---- reading the point ----

Vector4d Transcription::quaternion(int node, int body) const {
  if (node == 0) return lie::quaternion_of_rotation(maneuver_.start.rotation[at(body)]);
  return point_.segment<4>(quaternion_variable(node, body));
}

Vector3d Transcription::position(int node) const {
  return node == 0 ? maneuver_.start.position : Vector3d(point_.segment<3>(position_variable(node)));
}

mechanics::Moments Transcription::moments(int node) const {
  mechanics::Moments u(at(system_.joint_count()));
  int column = control_variable(node);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const auto& actuation = system_.joint(j).actuation;
    u[at(j)] = control_unit * (actuation * point_.segment(column, actuation.cols()));
    column += static_cast<int>(actuation.cols());
  }
  return u;
}

mechanics::Rotations Transcription::rotations(int node) const {
  mechanics::Rotations R(at(bodies_));
  for (int i = 0; i < bodies_; ++i) R[at(i)] = lie::rotation_of_quaternion(quaternion(node, i));
  return R;
}

void Transcription::move_to(const VectorXd& x) {
  if (point_.size() == x.size() && point_ == x) return;
  point_ = x;
  for (int k = 0; k < steps_; ++k) {
    Interval& step = intervals_[at(k)];
    for (int i = 0; i < bodies_; ++i) {
      step.rotation[at(i)] = lie::rotation_of_quaternion(quaternion(k, i));
      step.cayley[at(i)] = 0.5 * h_ * point_.segment<3>(turn_variable(k, i));
    }
    step.displacement = position(k + 1) - position(k);
    mechanics::update_interval(system_, step);
    mechanics::discrete_momenta(system_, maneuver_.lagrangian, h_, step, momenta_[at(k)]);
  }
}

// ---- cost ----

double Transcription::objective(const VectorXd& x) {
  double cost = 0.0;
  for (int k = 0; k <= steps_; ++k)
    cost += 0.5 * maneuver_.node_weight[k] * x.segment(control_variable(k), controls_).squaredNorm();
  return cost * control_unit;  // in units of control_unit (N m)² s, so that gradients are of order one
}

void Transcription::gradient(const VectorXd& x, VectorXd& g) {
  g.setZero();
  for (int k = 0; k <= steps_; ++k)
    g.segment(control_variable(k), controls_) =
        control_unit * maneuver_.node_weight[k] * x.segment(control_variable(k), controls_);
}

// ---- constraints ----

void Transcription::constraints(const VectorXd& x, VectorXd& c) {
  move_to(x);
  const Vector3d& linear = maneuver_.total.linear;
  for (int k = 0; k < steps_; ++k) {
    const mechanics::DiscreteMomenta& momenta = momenta_[at(k)];
    Vector3d angular = position(k).cross(linear) - maneuver_.total.angular;
    for (int i = 0; i < bodies_; ++i) {
      angular += intervals_[at(k)].rotation[at(i)] * momenta.minus[at(i)];
      c.segment<4>(kinematic_row(k, i)) =
          quaternion(k + 1, i) - advanced_quaternion(quaternion(k, i), intervals_[at(k)].cayley[at(i)]);
    }
    c.segment<3>(momentum_row(k)) = momenta.linear - linear;
    c.segment<3>(momentum_row(k) + 3) = angular;
    const VectorXd force =
        force_weight(k) * mechanics::generalized_force(system_, intervals_[at(k)].rotation, moments(k));
    for (int i = 1; i < bodies_; ++i) {
      const Vector3d before =
          k == 0 ? Vector3d(maneuver_.start.momentum.segment<3>(3 * i)) : momenta_[at(k - 1)].plus[at(i)];
      c.segment<3>(balance_row(k, i)) = momenta.minus[at(i)] - before - force.segment<3>(3 * i);
    }
  }
  VectorXd end_force;
  if (rests_)
    end_force = force_weight(steps_) * mechanics::generalized_force(system_, rotations(steps_), moments(steps_));
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) {
    const GoalRow& row = goal_rows_[r];
    double& value = c[goal_row() + static_cast<int>(r)];
    if (row.kind == GoalRow::Kind::rotation)
      value = rotation_goal_rows(*maneuver_.end_rotation[at(row.body)])
                  .row(row.component)
                  .dot(quaternion(steps_, row.body));
    else if (row.kind == GoalRow::Kind::position)
      value = position(steps_)[row.component] - *maneuver_.end_position[at(row.component)];
    else
      value = momenta_[at(steps_ - 1)].plus[at(row.body)][row.component] + end_force[3 * row.body + row.component];
  }
  if (maneuver_.spline_points == 0) return;
  for (int k = 0; k <= steps_; ++k)
    for (int m = 0; m < controls_; ++m)
      c[spline_row() + k * controls_ + m] =
          x[control_variable(k) + m] -
          spline_basis_.row(k).dot(x.segment(spline_variable() + m * maneuver_.spline_points, maneuver_.spline_points));
}

double Transcription::goal_error(const VectorXd& x) {
  move_to(x);
  double error = 0.0;
  for (int i = 0; i < bodies_; ++i)
    if (maneuver_.end_rotation[at(i)])
      error = std::max(error, lie::rotation_angle(maneuver_.end_rotation[at(i)]->transpose() *
                                                  lie::rotation_of_quaternion(quaternion(steps_, i))));
  for (int c = 0; c < 3; ++c)
    if (maneuver_.end_position[at(c)])
      error = std::max(error, std::abs(position(steps_)[c] - *maneuver_.end_position[at(c)]));
  return error;
}

// ---- Jacobian ----

void Transcription::jacobian(const VectorXd& x, VectorXd& values) {
  move_to(x);
  BlockSink sink(jacobian_pattern_, values);
  for (int k = 0; k < steps_; ++k) {
    emit_kinematics(k, sink);
    emit_step_jacobian(k, sink);
    emit_force_jacobian(k, sink);
  }
  emit_goal_jacobian(sink);
}

void Transcription::emit_kinematics(int k, BlockSink& sink) const {
  for (int i = 0; i < bodies_; ++i) {
    const int row = kinematic_row(k, i);
    const Vector3d& zeta = intervals_[at(k)].cayley[at(i)];
    sink.add(row, quaternion_variable(k + 1, i), Eigen::Matrix4d::Identity());
    if (k > 0) sink.add(row, quaternion_variable(k, i), -advanced_quaternion_by_quaternion(zeta));
    sink.add(row, turn_variable(k, i), -0.5 * h_ * advanced_quaternion_by_cayley(quaternion(k, i), zeta));
  }
}

void Transcription::emit_step_jacobian(int k, BlockSink& sink) {
  const Interval& step = intervals_[at(k)];
  mechanics::lagrangian_quadratic(system_, maneuver_.lagrangian, h_, step, work_, lagrangian_);
  mechanics::momentum_jacobian(lagrangian_, jacobian_);
  const mechanics::StepLayout layout{bodies_};
  MatrixXd angular = MatrixXd::Zero(3, layout.size());
  for (int i = 0; i < bodies_; ++i) {
    angular += step.rotation[at(i)] * jacobian_.minus.middleRows<3>(3 * i);
    angular.middleCols<3>(layout.left(i)) -= step.rotation[at(i)] * lie::hat(momenta_[at(k)].minus[at(i)]);
  }
  const auto emit = [&](int row, const auto& by_step, int body) {  // body < 0: couples to all
    for (int a = 0; a < bodies_; ++a) {
      if (body >= 0 && !related_[at(body)][at(a)]) continue;
      const StepChart chart(quaternion(k, a), step.cayley[at(a)], step.relative_rotation[at(a)], h_);
      if (k > 0)
        sink.add(row, quaternion_variable(k, a),
                 by_step.template middleCols<3>(layout.left(a)) * chart.left_by_quaternion +
                     by_step.template middleCols<3>(layout.right(a)) * chart.right_by_quaternion);
      sink.add(row, turn_variable(k, a), by_step.template middleCols<3>(layout.right(a)) * chart.right_by_turn);
    }
    const auto by_shift = by_step.template rightCols<3>();
    if (k > 0) sink.add(row, position_variable(k), -by_shift);
    sink.add(row, position_variable(k + 1), by_shift);
  };
  emit(momentum_row(k), jacobian_.linear, -1);
  emit(momentum_row(k) + 3, angular, -1);
  if (k > 0) sink.add(momentum_row(k) + 3, position_variable(k), -lie::hat(maneuver_.total.linear));
  for (int i = 1; i < bodies_; ++i) {
    emit(balance_row(k, i), jacobian_.minus.middleRows<3>(3 * i), i);
    if (k + 1 < steps_) emit(balance_row(k + 1, i), (-jacobian_.plus.middleRows<3>(3 * i)).eval(), i);
  }
  if (k + 1 < steps_) return;
  for (std::size_t r = 0; r < goal_rows_.size(); ++r)
    if (goal_rows_[r].kind == GoalRow::Kind::rest)
      emit(goal_row() + static_cast<int>(r),
           jacobian_.plus.row(3 * goal_rows_[r].body + goal_rows_[r].component).eval(), goal_rows_[r].body);
}

// Rows of −weight · U at a node; for the rest rows at the end +weight · U.
void Transcription::emit_force_jacobian(int node, BlockSink& sink) const {
  const mechanics::Moments u = moments(node);
  const auto emit = [&](int body, const Matrix3d& by_control, const model::Axes& actuation, int column, int turned,
                        const Matrix3d& by_turn) {
    const double sign = node == steps_ ? 1.0 : -1.0;
    const MatrixXd control_block = sign * force_weight(node) * control_unit * (by_control * actuation);
    Eigen::Matrix<double, 3, 4> turn_block = Eigen::Matrix<double, 3, 4>::Zero();
    if (node > 0 && turned >= 0)
      turn_block = sign * force_weight(node) * by_turn * lie::quaternion_tangent(quaternion(node, turned));
    const auto put = [&](int row, int first, int count) {
      if (actuation.cols() > 0) sink.add(row, column, control_block.middleRows(first, count));
      if (node > 0 && turned >= 0)
        sink.add(row, quaternion_variable(node, turned), turn_block.middleRows(first, count));
    };
    if (node < steps_) return put(balance_row(node, body), 0, 3);
    for (std::size_t r = 0; r < goal_rows_.size(); ++r)
      if (goal_rows_[r].kind == GoalRow::Kind::rest && goal_rows_[r].body == body)
        put(goal_row() + static_cast<int>(r), goal_rows_[r].component, 1);
  };
  int column = control_variable(node);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const model::Joint& joint = system_.joint(j);
    const Eigen::Matrix<double, 3, -1> none(3, 0);
    const Matrix3d Q = (lie::rotation_of_quaternion(quaternion(node, joint.child)).transpose() *
                        lie::rotation_of_quaternion(quaternion(node, joint.parent)));
    const Vector3d y = Q * u[at(j)];
    if (joint.parent > 0) emit(joint.parent, Matrix3d::Identity(), joint.actuation, column, -1, Matrix3d::Zero());
    // −R_cᵀR_p u: by η_c it is −ŷ, by η_p it is +Q û
    emit(joint.child, -Q, joint.actuation, column, joint.child, -lie::hat(y));
    emit(joint.child, -Q, none, column, joint.parent, Q * lie::hat(u[at(j)]));
    column += static_cast<int>(joint.actuation.cols());
  }
}

void Transcription::emit_goal_jacobian(BlockSink& sink) const {
  if (rests_) emit_force_jacobian(steps_, sink);
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) {
    const GoalRow& row = goal_rows_[r];
    const int constraint = goal_row() + static_cast<int>(r);
    if (row.kind == GoalRow::Kind::rotation)
      sink.add(constraint, quaternion_variable(steps_, row.body),
               rotation_goal_rows(*maneuver_.end_rotation[at(row.body)]).row(row.component));
    if (row.kind == GoalRow::Kind::position)
      sink.add(constraint, position_variable(steps_) + row.component, Eigen::Matrix<double, 1, 1>::Identity());
  }
  if (maneuver_.spline_points == 0) return;
  for (int k = 0; k <= steps_; ++k)
    for (int m = 0; m < controls_; ++m) {
      const int row = spline_row() + k * controls_ + m;
      sink.add(row, control_variable(k) + m, Eigen::Matrix<double, 1, 1>::Identity());
      sink.add(row, spline_variable() + m * maneuver_.spline_points, -spline_basis_.row(k));
    }
}

// ---- points and motions ----

VectorXd Transcription::pack(const NodePath& path) const {
  VectorXd x = VectorXd::Zero(variable_count_);
  for (int i = 0; i < bodies_; ++i) {
    Vector4d before = lie::quaternion_of_rotation(maneuver_.start.rotation[at(i)]);
    for (int k = 0; k < steps_; ++k) {
      Vector4d q = lie::quaternion_of_rotation(path.rotation[at(k + 1)][at(i)]);
      if (q.dot(advanced_quaternion(before, path.cayley[at(k)][at(i)])) < 0.0) q = -q;
      x.segment<4>(quaternion_variable(k + 1, i)) = q;
      x.segment<3>(turn_variable(k, i)) = 2.0 / h_ * path.cayley[at(k)][at(i)];
      before = q;
    }
  }
  for (int k = 0; k < steps_; ++k) x.segment<3>(position_variable(k + 1)) = path.position[at(k + 1)];
  for (int k = 0; k <= steps_; ++k) x.segment(control_variable(k), controls_) = path.control[at(k)] / control_unit;
  if (maneuver_.spline_points == 0) return x;
  MatrixXd samples(steps_ + 1, controls_);
  for (int k = 0; k <= steps_; ++k) samples.row(k) = x.segment(control_variable(k), controls_).transpose();
  const MatrixXd coefficients = maneuver::spline_points(spline_basis_, samples);
  for (int m = 0; m < controls_; ++m)
    x.segment(spline_variable() + m * maneuver_.spline_points, maneuver_.spline_points) = coefficients.col(m);
  return x;
}

NodePath Transcription::unpack(const VectorXd& x) const {
  NodePath path;
  path.rotation.push_back(maneuver_.start.rotation);
  path.position.push_back(maneuver_.start.position);
  for (int k = 0; k < steps_; ++k) {
    mechanics::Rotations R(at(bodies_));
    std::vector<Vector3d> cayley(at(bodies_));
    for (int i = 0; i < bodies_; ++i) {
      R[at(i)] = lie::rotation_of_quaternion(x.segment<4>(quaternion_variable(k + 1, i)));
      cayley[at(i)] = 0.5 * h_ * x.segment<3>(turn_variable(k, i));
    }
    path.rotation.push_back(R);
    path.cayley.push_back(cayley);
    path.position.push_back(x.segment<3>(position_variable(k + 1)));
  }
  for (int k = 0; k <= steps_; ++k) path.control.push_back(control_unit * x.segment(control_variable(k), controls_));
  return path;
}

}  // namespace lamprey::maneuver
