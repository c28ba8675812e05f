#include "maneuver/end_rows.hpp"

#include <cmath>
#include <numbers>

namespace lamprey::maneuver {

namespace {

using model::at;
using model::System;

// How a component of a body's turn, `along` in its own frame, changes with the shape's coordinates; the root turns nothing.
void read_turn(const System& system, const mechanics::Rotations& R, int i, Vector3d along,
               Eigen::Ref<Eigen::RowVectorXd> derivative) {
  for (; system.body(i).parent >= 0; i = system.body(i).parent) {
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) {
      derivative.segment<3>(shape_offset(body)) = along;
      return;
    }
    const mechanics::JointFrame frame = mechanics::joint_frame(system.joint(body.joint), R[at(body.parent)], R[at(i)]);
    for (int f = 0; f < body.freedoms; ++f) derivative[shape_offset(body) + f] = along.dot(frame.axes.col(f));
    along = frame.child_to_parent * along;
  }
}

}  // namespace

std::vector<EndRow> stated_end_rows(const System& system, const Maneuver& maneuver,
                                    const std::vector<int>& unactuated) {
  std::vector<EndRow> rows;
  const bool root = maneuver.end_rotation[0].has_value();
  if (maneuver.periodic)
    for (int i = 1; i < system.body_count(); ++i)
      for (int c = 0; c < system.body(i).freedoms; ++c) rows.push_back({EndRow::Kind::closure, i, c});
  for (int i = 0; i < (maneuver.periodic ? 1 : system.body_count()); ++i)
    if (maneuver.end_rotation[at(i)])
      for (int c = 0; c < 3; ++c)
        rows.push_back({i > 0 && root ? EndRow::Kind::shape : EndRow::Kind::orientation, i, c});
  for (int c = 0; c < 3; ++c)
    if (maneuver.end_position[at(c)]) rows.push_back({EndRow::Kind::position, 0, c});
  if (maneuver.rest || maneuver.periodic)
    for (int place : unactuated) rows.push_back({EndRow::Kind::moment, place, 0});
  return rows;
}

double end_row(const System& system, const Maneuver& maneuver, const EndRow& row, const mechanics::Rotations& R,
               const Vector3d& position, Eigen::Ref<Eigen::RowVectorXd> derivative) {
  const int shape = shape_size(system);
  derivative.setZero();
  if (row.kind == EndRow::Kind::position) {
    derivative[shape + 3 + row.component] = 1.0;
    return position[row.component] - *maneuver.end_position[at(row.component)];
  }
  const Matrix3d& asked = *maneuver.end_rotation[at(row.index)];
  const Matrix3d& now = R[at(row.index)];
  if (row.kind == EndRow::Kind::shape) {
    const Matrix3d asked_shape = maneuver.end_rotation[0]->transpose() * asked;
    const Vector3d error = lie::log(asked_shape.transpose() * (R[0].transpose() * now));
    read_turn(system, R, row.index, lie::log_tangent(error).row(row.component), derivative);
    return error[row.component];
  }
  // exp(ρ̂) R asked⁻¹ = exp(e + T ρ): the turn comes from the left
  const Vector3d error = lie::log(now * asked.transpose());
  const Eigen::RowVector3d by_turn = lie::log_tangent(-error).row(row.component);
  if (row.index > 0) read_turn(system, R, row.index, now.transpose() * by_turn.transpose(), derivative);
  derivative.segment<3>(shape) = by_turn;
  return error[row.component];
}

double closure_row(const System& system, const EndRow& row, const mechanics::Rotations& first,
                   const mechanics::Rotations& last, Eigen::Ref<Eigen::RowVectorXd> by_first,
                   Eigen::Ref<Eigen::RowVectorXd> by_last) {
  const model::Body& body = system.body(row.index);
  by_first.setZero();
  by_last.setZero();
  const int place = shape_offset(body);
  if (body.freedoms == 3) {
    const Vector3d error = lie::log(first[at(row.index)].transpose() * last[at(row.index)]);
    by_last.segment<3>(place) = lie::log_tangent(error).row(row.component);
    by_first.segment<3>(place) = -lie::log_tangent(-error).row(row.component);
    return error[row.component];
  }
  const model::Joint& joint = system.joint(body.joint);
  const auto angle = [&](const mechanics::Rotations& R) {
    return mechanics::joint_angles(joint, mechanics::child_to_parent(R, joint))[row.component];
  };
  by_last[place + row.component] = 1.0;
  by_first[place + row.component] = -1.0;
  return std::remainder(angle(last) - angle(first), 2.0 * std::numbers::pi);
}

}  // namespace lamprey::maneuver
