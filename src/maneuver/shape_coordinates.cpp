#include "maneuver/shape_coordinates.hpp"

#include "lie/so3.hpp"

namespace lamprey::maneuver {

namespace {

using mechanics::Freedoms;
using mechanics::Rotations;
using model::at;
using model::System;

}  // namespace

void read_shape(const System& system, const Freedoms& freedoms, Eigen::Ref<VectorXd> shape) {
  for (int i = 1; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) shape[shape_offset(system.body(i)) + f] = freedoms[at(i)][f];
}

void write_shape(const System& system, const VectorXd& shape, Freedoms& freedoms) {
  for (int i = 1; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) freedoms[at(i)][f] = shape[shape_offset(system.body(i)) + f];
}

ShapeCoordinates::ShapeCoordinates(const System& system)
    : shape(MatrixXd::Identity(shape_size(system), shape_size(system))), pose(MatrixXd::Identity(6, 6)) {}

void move_shape(const System& system, const Rotations& shape, const VectorXd& along, mechanics::Interval& buffer,
                Rotations& moved) {
  const auto half_turn = [&](int i) -> Vector3d { return 0.5 * along.segment<3>(shape_offset(system.body(i))); };
  if (system.only_free_joints()) {
    moved[0] = shape[0];
    for (int i = 1; i < system.body_count(); ++i)
      moved[at(i)] = lie::renormalized(shape[at(i)].lazyProduct(lie::cayley(half_turn(i))));
    return;
  }
  buffer.rotation = shape;
  for (Vector3d& v : buffer.cayley) v.setZero();
  for (Vector3d& v : buffer.joint_turn) v.setZero();
  for (int i = 1; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) {
      buffer.cayley[at(i)] = half_turn(i);
      continue;
    }
    for (int f = 0; f < body.freedoms; ++f) buffer.joint_turn[at(i)][f] = along[shape_offset(body) + f];
  }
  buffer.displacement.setZero();
  mechanics::update_interval(system, buffer);
  moved = buffer.next_rotation;
  for (Matrix3d& R : moved) R = lie::renormalized(R);
}

}  // namespace lamprey::maneuver
