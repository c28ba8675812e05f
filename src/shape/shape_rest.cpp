// Joints that end at rest on a whole that drifts: the last moments leave them what a whole that moves as one carries along them
// (chapter 9, equations 9.37 to 9.39).
#include "algebra/tiles.hpp"
#include "optimizer/small_dense.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::shape {

Vector6d ShapeProgram::total_at_end(const Motion& motion) const {
  return seen_from_root(total_, motion.rotation.back()[0], motion.position.back() - motion.position.front());
}

// Total angular momentum about the root's place at the end, world.
Vector3d ShapeProgram::angular_about_end() const {
  return total_.angular - (now_.position.back() - now_.position.front()).cross(total_.linear);
}

// What the joints carry at the end, beside what they bring there.
void ShapeProgram::add_carried_at_end(const Motion& motion, VectorXd& moment) {
  resting_->take(motion.shape.back());
  along_.setZero();
  optimizer::add_image(1.0, resting_->by_total(), total_at_end(motion), along_);
  optimizer::add_transposed_image(1.0, shape_basis_, along_, moment);
}

// The same by the last state, and by its total.
void ShapeProgram::find_carried_at_end() {
  resting_->take(now_.shape.back());
  resting_->rates(total_at_end(now_), resting_rates_);
  seen_by_pose_ = seen_by_pose(now_.rotation.back()[0], angular_about_end(), total_.linear);
  algebra::set_product(resting_rates_, shape_basis_, along_shapes_);
  algebra::set_product(shape_basis_.transpose(), along_shapes_, carried_at_end_.leftCols(shape_));
  see_by_pose(resting_->by_total());
  algebra::set_product(shape_basis_.transpose(), along_poses_, carried_at_end_.rightCols(pose_));
}

// Columns of what the root sees as those of its pose, into along_poses_.
void ShapeProgram::see_by_pose(const MatrixXd& by_total) {
  algebra::set_product(seen_by_pose_, pose_basis_, seen_along_poses_);
  algebra::set_product(by_total, seen_along_poses_, along_poses_);
}

void ShapeProgram::pull_carried_at_end(const VectorXd& multiplier) {
  const VectorXd& along = spread_shape(1.0, multiplier);
  Vector6d answer = Vector6d::Zero();
  optimizer::add_transposed_image(1.0, resting_->by_total(), along, answer);
  end_pull_ = seen_by_pose_.transpose() * answer;
}

void ShapeProgram::add_carried_curvature(const VectorXd& multiplier, MatrixXd& Q) {
  const int n = shape_;
  const VectorXd& along = spread_shape(1.0, multiplier);
  resting_->curvature(along, total_at_end(now_), resting_form_, resting_by_total_);
  algebra::set_product(resting_form_, shape_basis_, along_shapes_);
  algebra::set_product(shape_basis_.transpose(), along_shapes_, carried_bend_.leftCols(n));
  see_by_pose(resting_by_total_);
  algebra::set_product(shape_basis_.transpose(), along_poses_, carried_bend_.rightCols(pose_));
  Q.block(n, n, n, n) += carried_bend_.leftCols(n);
  const auto mixed = carried_bend_.rightCols(pose_);
  Q.block(n, 2 * n, n, pose_) += mixed;
  Q.block(2 * n, n, pose_, n) += mixed.transpose();

  Vector6d answer = Vector6d::Zero();
  optimizer::add_transposed_image(1.0, resting_->by_total(), along, answer);
  const Matrix3d& R = now_.rotation.back()[0];
  const Vector3d spin = R * answer.head<3>(), push = R * answer.tail<3>();
  algebra::set_product(bend_of_seen(spin, push, angular_about_end(), total_.linear), pose_basis_, seen_along_poses_);
  algebra::set_product(pose_basis_.transpose(), seen_along_poses_, pose_bend_);
  Q.block(2 * n, 2 * n, pose_, pose_) += pose_bend_;
}

}  // namespace lamprey::shape
