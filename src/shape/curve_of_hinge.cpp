#include "shape/curve_of_hinge.hpp"

#include "lie/so3.hpp"
#include "mechanics/connection.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using maneuver::EndRow;
using model::at;

}  // namespace

CurveOfHinge::CurveOfHinge(const model::System& system, const maneuver::Maneuver& maneuver, int joint)
    : system_(system),
      maneuver_(maneuver),
      joint_(joint),
      rows_(stated_end_rows(system, maneuver, {})),
      derivative_(maneuver::shape_size(system) + 6),
      rate_(at(system.joint_count()), Vector3d::Zero()) {
  std::erase_if(rows_, [](const EndRow& row) { return row.kind == EndRow::Kind::closure; });  // whole turns close
  rate_[at(joint)] = Vector3d::UnitX();
  now_.rotation = maneuver_.start.rotation;
  now_.position = maneuver_.start.position;
  now_.angle = mechanics::joint_angles(system_.joint(joint_),
                                       mechanics::child_to_parent(now_.rotation, system_.joint(joint_)))[0];
}

void CurveOfHinge::bend(double by) {
  const Matrix3d root = now_.rotation[0];
  place(root, now_.angle + 0.5 * by);
  const mechanics::Twist moved = by * mechanics::moved_root(system_, now_.rotation, rate_);
  now_.position += root * lie::exp(Vector3d(0.5 * moved.head<3>())) * moved.tail<3>();
  now_.angle += by;
  place(root * lie::exp(Vector3d(moved.head<3>())), now_.angle);
}

void CurveOfHinge::move_as(const Place& from, const Place& to, int times) {
  const mechanics::Rotations& start = maneuver_.start.rotation;
  const Vector3d turn = lie::log(from.rotation[0].transpose() * to.rotation[0]);
  now_.position += now_.rotation[0] * from.rotation[0].transpose() * (to.position - from.position);
  const Matrix3d whole = start[0] * lie::exp(times * turn) * start[0].transpose();
  for (std::size_t i = 0; i < start.size(); ++i) now_.rotation[i] = whole * start[i];
}

VectorXd CurveOfHinge::missed() {
  VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t r = 0; r < rows_.size(); ++r)
    values[static_cast<Eigen::Index>(r)] =
        end_row(system_, maneuver_, rows_[r], now_.rotation, now_.position, derivative_);
  return values;
}

void CurveOfHinge::place(const Matrix3d& root, double angle) {
  const mechanics::Rotations before = now_.rotation;
  for (int i : system_.root_to_leaves()) {
    const model::Body& body = system_.body(i);
    if (body.parent < 0) {
      now_.rotation[0] = root;
      continue;
    }
    const model::Joint& joint = system_.joint(body.joint);
    now_.rotation[at(i)] = now_.rotation[at(body.parent)] *
                           (body.joint == joint_ ? mechanics::rotation_at_turn(joint, Vector3d(angle, 0.0, 0.0))
                                                 : mechanics::child_to_parent(before, joint));
  }
}

}  // namespace lamprey::shape
