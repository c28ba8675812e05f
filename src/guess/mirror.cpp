#include "guess/mirror.hpp"

#include <cmath>

#include "lie/so3.hpp"
#include "maneuver/step_chart.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::advanced_quaternion;
using model::at;
using model::System;

constexpr double same = 1e-12;  // relative

Matrix3d reflection(int axis) {
  Matrix3d P = Matrix3d::Identity();
  P(axis, axis) = -1.0;
  return P;
}

bool unchanged(const Matrix3d& matrix, const Matrix3d& P) {
  return (P * matrix * P - matrix).norm() <= same * matrix.norm();
}

bool swimmer_unchanged(const System& system, const Matrix3d& P) {
  for (const model::Body& body : system.bodies())
    if (!unchanged(body.mass_matrix, P) || !unchanged(body.inertia_matrix, P)) return false;
  for (const model::Body& body : system.bodies())
    if (body.coupled) return false;  // not looked into
  for (const model::Joint& joint : system.joints()) {
    if (!joint.free() || joint.stiffness > 0.0) return false;   // nor are axes and zero angles
    if (!unchanged(joint.reference_rotation, P)) return false;  // from which twist counts
    if (joint.parent_offset != P * joint.parent_offset || joint.child_offset != P * joint.child_offset) return false;
    const MatrixXd signs = joint.actuation.transpose() * P * joint.actuation;  // of the moments, for limits of each
    if (!signs.cwiseAbs().isIdentity(same)) return false;
  }
  return true;
}

bool question_unchanged(const Maneuver& maneuver, const Matrix3d& P, int axis) {
  if (maneuver.start.momentum.squaredNorm() > 0.0 || maneuver.cost_weights.displacement[axis] != 0.0) return false;
  for (const Matrix3d& R : maneuver.start.rotation)
    if (!unchanged(R, P)) return false;
  for (const auto& R : maneuver.end_rotation)
    if (R && !unchanged(*R, P)) return false;
  for (const auto& Q : maneuver.end_joint)
    if (Q && !unchanged(*Q, P)) return false;
  const auto& end = maneuver.end_position[at(axis)];
  return !end || *end == maneuver.start.position[axis];
}

}  // namespace

std::optional<int> mirror_axis(const System& system, const Maneuver& maneuver, const Vector3d& turn) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(turn[axis]) > same * turn.norm()) continue;  // which the image would keep
    const Matrix3d P = reflection(axis);
    if (swimmer_unchanged(system, P) && question_unchanged(maneuver, P, axis)) return axis;
  }
  return std::nullopt;
}

NodePath mirrored(const System& system, const NodePath& path, int axis) {
  const Matrix3d P = reflection(axis);
  NodePath image = path;
  for (mechanics::Rotations& rotations : image.rotation)
    for (Matrix3d& R : rotations) R = P * R * P;
  for (Vector3d& x : image.position) x = path.position.front() + P * (x - path.position.front());
  for (auto& step : image.cayley)
    for (Vector3d& zeta : step) zeta = -P * zeta;
  for (std::vector<VectorXd>* moments : {&image.control, &image.polynomial})
    for (VectorXd& values : *moments)
      for (Eigen::Index first = 0; first < values.size();)  // all joints, and once more for each term
        for (const model::Joint& joint : system.joints()) {
          auto own = values.segment(first, joint.actuation.cols());
          own = (-joint.actuation.transpose() * P * joint.actuation * own).eval();
          first += joint.actuation.cols();
        }
  return image;
}

bool turns_against(const Vector3d& turn, const NodePath& path) {
  Eigen::Vector4d q(1.0, 0.0, 0.0,
                    0.0);  // followed along the way: of both signs of a rotation the one that this way leads to
  for (const auto& step : path.cayley) q = advanced_quaternion(q, step[0]);
  const double half = 0.5 * turn.norm();
  const Vector3d axis = path.rotation.front()[0].transpose() * turn.normalized();
  return std::cos(half) * q[0] + std::sin(half) * axis.dot(q.tail<3>()) < 0.0;
}

}  // namespace lamprey::guess
