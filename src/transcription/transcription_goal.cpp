// The goal's rows of the transcription: where the motion ends, at rest or where it began.
#include <cmath>

#include "maneuver/step_chart.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

namespace {

using maneuver::rotation_goal_rows;
using maneuver::shape_difference;

}  // namespace

using Eigen::Vector4d;
using model::at;
using model::System;

std::vector<GoalRow> stated_goal_rows(const System& system, const Maneuver& maneuver) {
  using Kind = GoalRow::Kind;
  std::vector<GoalRow> rows;
  const auto add_bodies = [&](Kind kind) {  // the root follows from the others because total momentum is given
    for (int i = 1; i < system.body_count(); ++i)
      for (int c = 0; c < 3; ++c) rows.push_back({kind, i, c});
  };
  if (maneuver.periodic) add_bodies(Kind::closure);
  for (int i = 0; i < (maneuver.periodic ? 1 : system.body_count()); ++i)
    if (maneuver.end_rotation[at(i)])
      for (int c = 0; c < 3; ++c) rows.push_back({Kind::rotation, i, c});
  for (int i = 1; i < system.body_count(); ++i)
    if (maneuver.tells_joint(system.body(i).joint))
      for (int c = 0; c < 3; ++c) rows.push_back({Kind::joint, i, c});
  for (int c = 0; c < 3; ++c)
    if (maneuver.end_position[at(c)]) rows.push_back({Kind::position, 0, c});
  if (maneuver.periodic)
    add_bodies(Kind::recurrence);
  else if (maneuver.rest)
    add_bodies(Kind::rest);
  return rows;
}

namespace {

const Vector4d unturned = Vector4d::Unit(0);

}  // namespace

// Child → parent as asked for.
Vector4d Transcription::end_of_joint(int body) const {
  return lie::quaternion_of_rotation(*maneuver_.end_joint[at(system_.body(body).joint)]);
}

double Transcription::value_of(const GoalRow& row) const {
  const auto force_at = [&](int node) {
    const VectorXd all = mechanics::generalized_force(free_, rotations(node), moments(node));
    return force_weight(node) * all[3 * row.body + row.component];
  };
  switch (row.kind) {
    case GoalRow::Kind::rotation:
      return rotation_goal_rows(*maneuver_.end_rotation[at(row.body)])
          .row(row.component)
          .dot(quaternion(steps_, row.body));
    case GoalRow::Kind::position:
      return position(steps_)[row.component] - *maneuver_.end_position[at(row.component)];
    case GoalRow::Kind::rest:
      return momenta_.back().plus[at(row.body)][row.component] + force_at(steps_);
    case GoalRow::Kind::closure:
      return 2.0 * shape_difference(quaternion(0, row.body), quaternion(0, 0), quaternion(steps_, 0),
                                    quaternion(steps_, row.body))[1 + row.component];
    case GoalRow::Kind::joint:
      return 2.0 * shape_difference(end_of_joint(row.body), unturned, quaternion(steps_, parent_of(row.body)),
                                    quaternion(steps_, row.body))[1 + row.component];
    case GoalRow::Kind::recurrence:
      return momenta_.back().plus[at(row.body)][row.component] + force_at(steps_) -
             momenta_.front().minus[at(row.body)][row.component] + force_at(0);
  }
  return 0.0;
}

double Transcription::goal_error(const VectorXd& x) {
  move_to(x);
  double error = 0.0;
  for (int i = 0; i < (maneuver_.periodic ? 1 : bodies_); ++i)
    if (maneuver_.end_rotation[at(i)])
      error = std::max(error, lie::rotation_angle(maneuver_.end_rotation[at(i)]->transpose() *
                                                  lie::rotation_of_quaternion(quaternion(steps_, i))));
  for (int j = 0; j < system_.joint_count(); ++j)
    if (maneuver_.tells_joint(j)) {
      const Matrix3d now = mechanics::child_to_parent(rotations(steps_), system_.joint(j));
      error = std::max(error, lie::rotation_angle(maneuver_.end_joint[at(j)]->transpose() * now));
    }
  for (int c = 0; c < 3; ++c)
    if (maneuver_.end_position[at(c)])
      error = std::max(error, std::abs(position(steps_)[c] - *maneuver_.end_position[at(c)]));
  if (!maneuver_.periodic) return error;
  const mechanics::Rotations first = rotations(0), last = rotations(steps_);
  for (std::size_t i = 1; i < first.size(); ++i)
    error = std::max(
        error, lie::rotation_angle((first[0].transpose() * first[i]).transpose() * (last[0].transpose() * last[i])));
  return error;
}

void Transcription::emit_goal_jacobian(BlockSink& sink) const {
  emit_force_jacobian(steps_, sink);
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) {
    const GoalRow& row = goal_rows_[r];
    const int constraint = goal_row() + static_cast<int>(r);
    if (row.kind == GoalRow::Kind::rotation)
      sink.add(constraint, quaternion_variable(steps_, row.body),
               rotation_goal_rows(*maneuver_.end_rotation[at(row.body)]).row(row.component));
    if (row.kind == GoalRow::Kind::position)
      sink.add(constraint, position_variable(steps_) + row.component, Eigen::Matrix<double, 1, 1>::Identity());
    if (row.kind == GoalRow::Kind::closure) emit_closure_jacobian(constraint, row, sink);
    if (row.kind == GoalRow::Kind::joint) emit_joint_jacobian(constraint, row, sink);
  }
  if (maneuver_.spline_points == 0) return;
  for (int k = 0; k <= steps_; ++k)
    for (int m = 0; m < controls_; ++m) {
      const int row = spline_row() + k * controls_ + m;
      sink.add(row, control_variable(k) + m, Eigen::Matrix<double, 1, 1>::Identity());
      sink.add(row, spline_variable_ + m * maneuver_.spline_points, -spline_basis_.row(k));
    }
}

// It is linear in each of the quaternions.
void Transcription::emit_closure_jacobian(int constraint, const GoalRow& row, BlockSink& sink) const {
  const Vector4d first = quaternion(0, row.body), root = quaternion(0, 0), root_end = quaternion(steps_, 0),
                 last = quaternion(steps_, row.body);
  Eigen::RowVector4d by_first, by_root, by_last;
  for (int e = 0; e < 4; ++e) {
    const Vector4d one = Vector4d::Unit(e);
    by_first[e] = 2.0 * shape_difference(one, root, root_end, last)[1 + row.component];
    by_root[e] = 2.0 * shape_difference(first, root, one, last)[1 + row.component];
    by_last[e] = 2.0 * shape_difference(first, root, root_end, one)[1 + row.component];
  }
  if (const int q = quaternion_variable(0, row.body); q >= 0) sink.add(constraint, q, by_first);
  sink.add(constraint, quaternion_variable(steps_, 0), by_root);
  sink.add(constraint, quaternion_variable(steps_, row.body), by_last);
}

// It is linear in both.
void Transcription::emit_joint_jacobian(int constraint, const GoalRow& row, BlockSink& sink) const {
  const int above = parent_of(row.body);
  const Vector4d asked = end_of_joint(row.body), parent = quaternion(steps_, above),
                 child = quaternion(steps_, row.body);
  Eigen::RowVector4d by_parent, by_child;
  for (int e = 0; e < 4; ++e) {
    const Vector4d one = Vector4d::Unit(e);
    by_parent[e] = 2.0 * shape_difference(asked, unturned, one, child)[1 + row.component];
    by_child[e] = 2.0 * shape_difference(asked, unturned, parent, one)[1 + row.component];
  }
  sink.add(constraint, quaternion_variable(steps_, above), by_parent);
  sink.add(constraint, quaternion_variable(steps_, row.body), by_child);
}

}  // namespace lamprey::transcription
