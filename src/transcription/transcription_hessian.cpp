// Second derivatives of the transcription: multiplier · constraints, step by step.
#include <cmath>

#include "maneuver/step_chart.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

namespace {

using Eigen::Vector4d;
using lie::double_cross;
using lie::hat;
using maneuver::AdvancedQuaternionCurvature;
using maneuver::ChartCurvature;
using maneuver::quaternion_curvature;
using maneuver::shape_difference;
using maneuver::StepChart;
using mechanics::StepDirection;
using model::at;

// Layout of the local Hessian of a step: quaternions, turns, displacement.
struct LocalLayout {
  int bodies;
  int quaternion(int body) const { return 4 * body; }
  int turn(int body) const { return 4 * bodies + 3 * body; }
  int displacement() const { return 7 * bodies; }
  int size() const { return 7 * bodies + 3; }
};

}  // namespace

// Multiplier of the balance p⁻ − p⁺ − weight U of a non-root body at a node; at the ends other rows stand for it.
Vector3d Transcription::balance_multiplier(int node, int body, const VectorXd& multiplier) const {
  Vector3d lambda = Vector3d::Zero();
  if (body == 0) return lambda;
  for (int c = 0; c < 3; ++c)
    for (const auto& [row, sign] : end_force_rows(node, body, c)) lambda[c] -= sign * multiplier[row];
  return lambda;
}

StepDirection Transcription::direction_of(int k, const VectorXd& multiplier) const {
  StepDirection direction(bodies_);
  const Vector3d angular = multiplier.segment<3>(momentum_row(k) + 3);
  direction.displacement = multiplier.segment<3>(momentum_row(k));
  for (int i = 0; i < bodies_; ++i) {
    direction.left[at(i)] =
        -balance_multiplier(k, i, multiplier) - intervals_[at(k)].rotation[at(i)].transpose() * angular;
    direction.right[at(i)] = -balance_multiplier(k + 1, i, multiplier);
  }
  return direction;
}

void Transcription::hessian(const VectorXd& x, double factor, const VectorXd& multiplier, VectorXd& values) {
  move_to(x);
  BlockSink sink(hessian_pattern_, values);
  const auto scalar = [](double value) { return Eigen::Matrix<double, 1, 1>::Constant(value); };
  const double scale = factor * unit / std::pow(stretch(), 3);
  for (int k = 0; k <= steps_; ++k) {
    const double weight = scale * maneuver_.node_weight[k];
    for (int m = 0; m < controls_; ++m) {
      const int variable = control_variable(k) + m;
      sink.add(variable, variable, scalar(weight));
      if (stretch_variable_ >= 0) sink.add(stretch_variable_, variable, scalar(-3.0 * weight * x[variable]));
    }
    if (k < steps_) emit_step_hessian(k, multiplier, sink);
    if ((k > 0 || maneuver_.free_shape) && balance_at(k)) emit_force_hessian(k, multiplier, sink);
    if (k > 0 || maneuver_.free_shape) emit_joint_hessian(k, multiplier, sink);
    emit_axis_hessian(k, multiplier, sink);
  }
  if (maneuver_.free_shape)
    for (int i = 1; i < bodies_; ++i)
      sink.add_symmetric(quaternion_variable(0, i), quaternion_variable(0, i),
                         multiplier[length_row(i)] * Eigen::Matrix4d::Identity());
  emit_limit_hessian(multiplier, sink);
  emit_closure_hessian(multiplier, sink);
  emit_joint_hessian(multiplier, sink);
  emit_cost_hessian(factor, sink);
  emit_cost_rows_hessian(multiplier, sink);
  if (stretch_variable_ < 0) return;
  const double timed = maneuver_.time_weight * duration(x) / cost_unit();
  double bend = factor * (9.0 * (objective(x) - timed - other_costs(x).sum() + won(x)) + timed);
  if (!maneuver_.periodic)
    for (int i = 1; i < bodies_; ++i)
      bend -= stretch() * start_momentum_[at(i)].dot(multiplier.segment<3>(balance_row(0, i)));
  const Vector3d linear = stretch() / scale_ * maneuver_.total.linear,
                 angular = stretch() / scale_ * maneuver_.total.angular;
  for (int k = 0; k < steps_; ++k) {
    const Vector3d push = multiplier.segment<3>(momentum_row(k)), spin = multiplier.segment<3>(momentum_row(k) + 3);
    bend -= push.dot(linear) + spin.dot(angular - position(k).cross(linear));
    if (k > 0) sink.add(stretch_variable_, position_variable(k), linear.cross(spin).transpose());
  }
  sink.add(stretch_variable_, stretch_variable_, scalar(bend));
}

// The Hessian by body-side perturbations of the step, momentum rows' turning direction included (equation 5.8).
void Transcription::expand_step(int k, const VectorXd& multiplier) {
  const mechanics::Interval& step = intervals_[at(k)];
  const mechanics::StepLayout layout{bodies_};
  const Vector3d angular = multiplier.segment<3>(momentum_row(k) + 3);
  mechanics::directional_quadratic(free_, maneuver_.lagrangian, h_, step, direction_of(k, multiplier), work_,
                                   directional_);
  mechanics::lagrangian_quadratic(free_, maneuver_.lagrangian, h_, step, work_, lagrangian_);
  mechanics::momentum_jacobian(lagrangian_, jacobian_);
  for (int i = 0; i < bodies_; ++i) {
    const int left = layout.left(i);
    const Vector3d v = step.rotation[at(i)].transpose() * angular;
    const Vector3d& p = momenta_[at(k)].minus[at(i)];
    const auto dp = jacobian_.minus.middleRows<3>(3 * i);
    directional_.gradient.segment<3>(left) += p.cross(v);
    directional_.hessian.block<3, 3>(left, left) += double_cross(p, v);
    directional_.hessian.middleRows<3>(left) -= hat(v) * dp;
    directional_.hessian.middleCols<3>(left) += dp.transpose() * hat(v);
  }
}

void Transcription::emit_step_hessian(int k, const VectorXd& multiplier, BlockSink& sink) {
  expand_step(k, multiplier);
  const mechanics::Interval& step = intervals_[at(k)];
  const mechanics::StepLayout layout{bodies_};
  const LocalLayout local_at{bodies_};
  const MatrixXd& H = directional_.hessian;
  MatrixXd half(layout.size(), local_at.size());  // H · d(perturbations)/d(local coordinates)
  MatrixXd local(local_at.size(), local_at.size());
  half.rightCols<3>() = H.rightCols<3>();
  std::vector<StepChart> charts;
  for (int i = 0; i < bodies_; ++i) {
    charts.emplace_back(quaternion(k, i), step.cayley[at(i)], step.relative_rotation[at(i)], h_);
    half.middleCols<4>(local_at.quaternion(i)).noalias() =
        H.middleCols<3>(layout.left(i)) * charts.back().left_by_quaternion +
        H.middleCols<3>(layout.right(i)) * charts.back().right_by_quaternion;
    half.middleCols<3>(local_at.turn(i)).noalias() = H.middleCols<3>(layout.right(i)) * charts.back().right_by_turn;
  }
  local.bottomRows<3>() = half.bottomRows<3>();
  for (int i = 0; i < bodies_; ++i) {
    local.middleRows<4>(local_at.quaternion(i)).noalias() =
        charts[at(i)].left_by_quaternion.transpose() * half.middleRows<3>(layout.left(i)) +
        charts[at(i)].right_by_quaternion.transpose() * half.middleRows<3>(layout.right(i));
    local.middleRows<3>(local_at.turn(i)).noalias() =
        charts[at(i)].right_by_turn.transpose() * half.middleRows<3>(layout.right(i));
    const ChartCurvature curvature(charts[at(i)], quaternion(k, i), step.cayley[at(i)], h_,
                                   directional_.gradient.segment<3>(layout.left(i)),
                                   directional_.gradient.segment<3>(layout.right(i)));
    const int q = local_at.quaternion(i);
    const int w = local_at.turn(i);
    local.block<4, 4>(q, q) += curvature.quaternion_quaternion;
    local.block<4, 3>(q, w) += curvature.quaternion_turn;
    local.block<3, 4>(w, q) += curvature.quaternion_turn.transpose();
    local.block<3, 3>(w, w) += curvature.turn_turn;
  }
  add_kinematic_curvature(k, multiplier, local);
  scatter_step_hessian(k, local, sink);
}

void Transcription::add_kinematic_curvature(int k, const VectorXd& multiplier, MatrixXd& local) const {
  const LocalLayout local_at{bodies_};
  for (int i = 0; i < bodies_; ++i) {
    const AdvancedQuaternionCurvature curvature(-multiplier.segment<4>(kinematic_row(k, i)), quaternion(k, i),
                                                intervals_[at(k)].cayley[at(i)]);
    const int q = local_at.quaternion(i);
    const int w = local_at.turn(i);
    local.block<4, 3>(q, w) += 0.5 * h_ * curvature.quaternion_cayley;
    local.block<3, 4>(w, q) += 0.5 * h_ * curvature.quaternion_cayley.transpose();
    local.block<3, 3>(w, w) += 0.25 * h_ * h_ * curvature.cayley_cayley;
  }
}

void Transcription::scatter_step_hessian(int k, const MatrixXd& local, BlockSink& sink) const {
  const LocalLayout local_at{bodies_};
  const int shift = local_at.displacement(), here = position_variable(k), there = position_variable(k + 1);
  for (int a = 0; a < bodies_; ++a) {
    const int q = local_at.quaternion(a);
    const int w = local_at.turn(a);
    const int variable = quaternion_variable(k, a), turn = turn_variable(k, a);
    for (int b = 0; b <= a; ++b) {
      if (!related_[at(a)][at(b)]) continue;
      const int qb = local_at.quaternion(b);
      const int wb = local_at.turn(b);
      const int other = quaternion_variable(k, b);
      sink.add_symmetric(turn, turn_variable(k, b), local.block<3, 3>(w, wb));
      if (variable >= 0 && other >= 0) sink.add_symmetric(variable, other, local.block<4, 4>(q, qb));
      if (other >= 0) sink.add_symmetric(turn, other, local.block<3, 4>(w, qb));
      if (a != b && variable >= 0) sink.add_symmetric(variable, turn_variable(k, b), local.block<4, 3>(q, wb));
    }
    const auto by_shift_turn = local.block<3, 3>(w, shift);
    const auto by_shift_quaternion = local.block<4, 3>(q, shift);
    sink.add_symmetric(turn, there, by_shift_turn);
    if (here >= 0) sink.add_symmetric(turn, here, -by_shift_turn);
    if (variable >= 0) sink.add_symmetric(variable, there, by_shift_quaternion);
    if (variable >= 0 && here >= 0) sink.add_symmetric(variable, here, -by_shift_quaternion);
  }
  const auto shift_shift = local.block<3, 3>(shift, shift);
  sink.add_symmetric(there, there, shift_shift);
  if (here < 0) return;
  sink.add_symmetric(here, here, shift_shift);
  sink.add_symmetric(there, here, -shift_shift);
}

// −weight · λ·U at a node: bilinear in the moments and the relative rotation of the joint (equation 5.9).
void Transcription::emit_force_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const {
  const mechanics::Moments u = moments(node);
  const double weight = force_weight(node);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const model::Joint& joint = free_.joint(j);
    const Vector4d q_child = quaternion(node, joint.child);
    const Vector4d q_parent = quaternion(node, joint.parent);
    const Matrix3d Q = lie::rotation_of_quaternion(q_child).transpose() * lie::rotation_of_quaternion(q_parent);
    const Vector3d lambda = weight * balance_multiplier(node, joint.child, multiplier);  // of +λ · Q u
    const Vector3d y = Q * u[at(j)];
    const Vector3d z = Q.transpose() * lambda;
    const auto T_child = lie::quaternion_tangent(q_child);
    const auto T_parent = lie::quaternion_tangent(q_parent);
    const int child = quaternion_variable(node, joint.child);
    const int parent = quaternion_variable(node, joint.parent);
    const int column = moment_variable(node, j);
    if (child >= 0)
      sink.add_symmetric(
          child, child,
          T_child.transpose() * double_cross(lambda, y) * T_child + quaternion_curvature(q_child, lambda.cross(y)));
    if (parent >= 0)
      sink.add_symmetric(parent, parent,
                         T_parent.transpose() * double_cross(z, u[at(j)]) * T_parent +
                             quaternion_curvature(q_parent, u[at(j)].cross(z)));
    if (child >= 0 && parent >= 0)
      sink.add_symmetric(child, parent, -T_child.transpose() * hat(lambda) * Q * hat(u[at(j)]) * T_parent);
    if (joint.actuation.cols() == 0) continue;
    if (child >= 0) sink.add_symmetric(child, column, unit * T_child.transpose() * hat(lambda) * Q * joint.actuation);
    if (parent >= 0) sink.add_symmetric(parent, column, -unit * T_parent.transpose() * hat(z) * joint.actuation);
  }
}

// What the rows of a kind pull at twice a body's quaternion; nothing where it has none.
std::optional<Vector4d> Transcription::pull_of_goal(GoalRow::Kind kind, int body, const VectorXd& multiplier) const {
  std::optional<Vector4d> pull;
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) {
    const GoalRow& row = goal_rows_[r];
    if (row.kind != kind || row.body != body) continue;
    if (!pull) pull = Vector4d::Zero();
    (*pull)[1 + row.component] = 2.0 * multiplier[goal_row() + static_cast<int>(r)];
  }
  return pull;
}

// Pairs of the three quaternions of a closure row; in each it is linear.
void Transcription::emit_closure_hessian(const VectorXd& multiplier, BlockSink& sink) const {
  for (int i = 1; i < bodies_; ++i) {
    const std::optional<Vector4d> pulled = pull_of_goal(GoalRow::Kind::closure, i, multiplier);
    if (!pulled) continue;
    const Vector4d& pull = *pulled;
    const Vector4d first = quaternion(0, i), root = quaternion(0, 0), root_end = quaternion(steps_, 0),
                   last = quaternion(steps_, i);
    Eigen::Matrix4d root_last, first_root, first_last;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const Vector4d one = Vector4d::Unit(a), other = Vector4d::Unit(b);
        root_last(a, b) = pull.dot(shape_difference(first, root, one, other));
        first_root(a, b) = pull.dot(shape_difference(one, root, other, last));
        first_last(a, b) = pull.dot(shape_difference(one, root, root_end, other));
      }
    const int start = quaternion_variable(0, i), root_variable = quaternion_variable(steps_, 0),
              last_variable = quaternion_variable(steps_, i);
    sink.add_symmetric(root_variable, last_variable, root_last);
    if (start < 0) continue;
    sink.add_symmetric(start, root_variable, first_root);
    sink.add_symmetric(start, last_variable, first_last);
  }
}

// The two quaternions of a joint's end; in each the row is linear.
void Transcription::emit_joint_hessian(const VectorXd& multiplier, BlockSink& sink) const {
  for (int i = 1; i < bodies_; ++i) {
    const std::optional<Vector4d> pull = pull_of_goal(GoalRow::Kind::joint, i, multiplier);
    if (!pull) continue;
    const Vector4d asked = end_of_joint(i);
    Eigen::Matrix4d parent_child;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        parent_child(a, b) =
            pull->dot(shape_difference(asked, Vector4d::Unit(0), Vector4d::Unit(a), Vector4d::Unit(b)));
    sink.add_symmetric(quaternion_variable(steps_, parent_of(i)), quaternion_variable(steps_, i), parent_child);
  }
}

}  // namespace lamprey::transcription
