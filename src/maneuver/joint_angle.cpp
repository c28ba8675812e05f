#include "maneuver/joint_angle.hpp"

#include <array>
#include <cmath>

#include "lie/so3.hpp"

namespace lamprey::maneuver {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::at;
using model::Joint;

// Quaternion of a joint's turn from its zero angle, parent's frame, scalar part ≥ 0.
lie::Vector4 turn_from_zero(const Joint& joint, const Matrix3d& Q) {
  return lie::quaternion_of_rotation(Q * joint.reference_rotation.transpose());
}

lie::Vector4 pure(const Vector3d& v) { return {0.0, v.x(), v.y(), v.z()}; }

}  // namespace

Vector3d angle_axis(const Joint& joint, int freedom) {
  const bool first = joint.kind == model::JointKind::universal && freedom == 0;
  return first ? Vector3d(joint.reference_rotation.transpose() * joint.parent_axis) : joint.child_axis;
}

double twist_about(const Vector3d& axis, const Joint& joint, const Matrix3d& Q) {
  const lie::Vector4 q = turn_from_zero(joint, Q);
  return 2.0 * std::atan2(q.tail<3>().dot(joint.reference_rotation * axis), q[0]);
}

// With q the quaternion of the turn, x its scalar part and y its part along the axis: 2 atan2(y, x).
TwistDerivatives twist_derivatives(const Vector3d& axis, const Joint& joint, const Matrix3d& Q) {
  const lie::Vector4 q = turn_from_zero(joint, Q);
  const Matrix3d& zero = joint.reference_rotation;
  const Vector3d arm = zero * axis;
  const auto read = [&](const lie::Vector4& p) { return Eigen::Vector2d(p[0], p.tail<3>().dot(arm)); };
  const Eigen::Vector2d xy = read(q);
  Eigen::Matrix<double, 2, 6> rate;  // of (x, y) by the turns of parent and child
  std::array<Eigen::Matrix<double, 6, 6>, 2> second;
  second.fill(Eigen::Matrix<double, 6, 6>::Zero());
  for (int c = 0; c < 3; ++c) {
    const lie::Vector4 parent = -0.5 * lie::quaternion_product(pure(Vector3d::Unit(c)), q);
    rate.col(c) = read(parent);
    rate.col(3 + c) = read(0.5 * lie::quaternion_product(q, pure(zero.col(c))));
    for (int d = 0; d < 3; ++d) {
      const Eigen::Vector2d mixed = read(0.5 * lie::quaternion_product(parent, pure(zero.col(d))));
      for (int e = 0; e < 2; ++e) second[at(e)](c, 3 + d) = second[at(e)](3 + d, c) = mixed[e];
    }
    for (int e = 0; e < 2; ++e) second[at(e)](c, c) = second[at(e)](3 + c, 3 + c) = -0.25 * xy[e];
  }
  const double x = xy[0], y = xy[1], r2 = xy.squaredNorm();
  const Eigen::RowVector2d slope(-2.0 * y / r2, 2.0 * x / r2);
  Eigen::Matrix2d bend;
  bend << 4.0 * x * y, 2.0 * (y * y - x * x), 2.0 * (y * y - x * x), -4.0 * x * y;
  bend /= r2 * r2;
  return {(slope * rate).transpose(), rate.transpose() * bend * rate + slope[0] * second[0] + slope[1] * second[1]};
}

}  // namespace lamprey::maneuver
