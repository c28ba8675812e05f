#include "shape/pose_at_end.hpp"

#include "lie/so3.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Index;
using optimizer::add_product;
using optimizer::set_transposed;

}  // namespace

Vector6d seen_from_root(const mechanics::SpatialMomentum& total, const Matrix3d& root, const Vector3d& place) {
  Vector6d seen;
  seen << root.transpose() * (total.angular - place.cross(total.linear)), root.transpose() * total.linear;
  return seen;
}

Matrix6d seen_by_pose(const Matrix3d& root, const Vector3d& angular, const Vector3d& linear) {
  Matrix6d by_pose = Matrix6d::Zero();
  by_pose.topLeftCorner<3, 3>() = root.transpose() * lie::hat(angular);
  by_pose.topRightCorner<3, 3>() = by_pose.bottomLeftCorner<3, 3>() = root.transpose() * lie::hat(linear);
  return by_pose;
}

// Of exp(−ρ̂)(L − χ × P) and exp(−ρ̂) P.
Matrix6d bend_of_seen(const Vector3d& spin, const Vector3d& push, const Vector3d& angular, const Vector3d& linear) {
  Matrix6d bend = Matrix6d::Zero();
  bend.topLeftCorner<3, 3>() = lie::double_cross(spin, angular) + lie::double_cross(push, linear);
  bend.bottomLeftCorner<3, 3>() = lie::hat(linear) * lie::hat(spin);
  bend.topRightCorner<3, 3>() = bend.bottomLeftCorner<3, 3>().transpose();
  return bend;
}

Matrix6d carried_pose(const Vector3d& displacement) {
  Matrix6d carried = Matrix6d::Identity();
  carried.bottomLeftCorner<3, 3>() = -lie::hat(displacement);
  return carried;
}

void PoseAtEnd::take(const ShapeTangent& tangent, const Vector3d& displacement) {
  const Matrix6d back = (carried_pose(displacement) + tangent.pose.middleCols<6>(shapes_)).inverse();
  before_.setIdentity();
  before_.block<6, 6>(shapes_, shapes_) = back;
  const auto answer_to = [&](Index first, Index count) {
    auto by = before_.block(shapes_, first, 6, count);
    by = back.lazyProduct(tangent.pose.middleCols(first, count));
    by *= -1.0;
  };
  answer_to(0, shapes_);
  answer_to(shapes_ + 6, before_.cols() - shapes_ - 6);
}

void PoseAtEnd::turn(MatrixXd& hessian) {
  algebra::set_product(hessian, before_, half_);
  algebra::set_product(before_.transpose(), half_, hessian);
}

void PoseAtEnd::turn_rows(MatrixXd& rows) {
  auto turned = half_.topRows(rows.rows());
  algebra::set_product(rows, before_, turned);
  rows = turned;
}

void turn_at_end(const ShapeTangent& tangent, MatrixXd& hessian) {
  const Index ends = tangent.pose.cols();
  const auto added = tangent.pose.topRows<3>();
  const Matrix3d half = 0.5 * hessian.bottomRightCorner<3, 3>();
  auto by_turn = hessian.topRightCorner(ends, 3);
  auto by_ends = hessian.topLeftCorner(ends, ends);
  by_turn -= added.transpose().lazyProduct(half);
  add_product(-1.0, by_turn, added, by_ends);
  by_ends -= added.transpose().lazyProduct(by_turn.transpose());
  by_turn -= added.transpose().lazyProduct(half);
  set_transposed(by_turn, hessian.bottomLeftCorner(3, ends));
}

}  // namespace lamprey::shape
