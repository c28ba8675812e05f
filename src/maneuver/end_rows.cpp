#include "maneuver/end_rows.hpp"

namespace lamprey::maneuver {

namespace {

using model::at;
using model::System;

// Turns of a body that is not the root by the shape's coordinates, body frame: [3][shape].
MatrixXd turns_by_shape(const System& system, const mechanics::Rotations& rotation, int body) {
  return mechanics::turn_by_freedoms(system, rotation, body).rightCols(shape_size(system));
}

}  // namespace

std::vector<EndRow> stated_end_rows(const System& system, const Maneuver& maneuver,
                                    const std::vector<int>& unactuated) {
  std::vector<EndRow> rows;
  const bool root = maneuver.end_rotation[0].has_value();
  for (int i = 0; i < system.body_count(); ++i)
    if (maneuver.end_rotation[at(i)])
      for (int c = 0; c < 3; ++c)
        rows.push_back({i > 0 && root ? EndRow::Kind::shape : EndRow::Kind::orientation, i, c});
  for (int c = 0; c < 3; ++c)
    if (maneuver.end_position[at(c)]) rows.push_back({EndRow::Kind::position, 0, c});
  if (maneuver.rest)
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
    derivative.head(shape) = lie::log_tangent(error).row(row.component) * turns_by_shape(system, R, row.index);
    return error[row.component];
  }
  // exp(ρ̂) R asked⁻¹ = exp(e + T ρ): the turn comes from the left
  const Vector3d error = lie::log(now * asked.transpose());
  const Eigen::RowVector3d by_turn = lie::log_tangent(-error).row(row.component);
  if (row.index > 0) derivative.head(shape) = by_turn * now * turns_by_shape(system, R, row.index);
  derivative.segment<3>(shape) = by_turn;
  return error[row.component];
}

}  // namespace lamprey::maneuver
