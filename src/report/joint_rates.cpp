#include "report/joint_rates.hpp"

#include "lie/so3.hpp"
#include "model/system.hpp"

namespace lamprey::report {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::at;

Matrix3d child_to_parent(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint) {
  const auto& R = results.solution.rotation[node];
  return R[at(joint.parent)].transpose() * R[at(joint.child)];
}

}  // namespace

Vector3d joint_rate(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint) {
  const auto& rate = results.solution.angular_velocity[node];
  return child_to_parent(results, node, joint) * rate[at(joint.child)] - rate[at(joint.parent)];
}

Vector3d step_rate(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint) {
  const Matrix3d turn = child_to_parent(results, node + 1, joint) * child_to_parent(results, node, joint).transpose();
  return lie::log(turn) / results.problem.time_step;
}

Matrix3d axes_at(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint) {
  if (!joint.axes) return Matrix3d::Identity();
  const Vector3d first = (*joint.axes)[0].normalized();
  Vector3d second = child_to_parent(results, node, joint) * (*joint.axes)[1];
  second = (second - first.dot(second) * first).normalized();
  Matrix3d axes;
  axes << first, second, first.cross(second);
  return axes;
}

}  // namespace lamprey::report
