#include "shape/moment_basis.hpp"

#include <algorithm>

#include "algebra/row_space.hpp"

namespace lamprey::shape {

namespace {

using maneuver::is_identity;
using maneuver::shape_offset;
using maneuver::shape_size;
using mechanics::JointFrame;
using mechanics::Moments;
using mechanics::Rotations;
using model::at;
using model::Body;
using model::Joint;
using model::System;

constexpr double felt_threshold = 1e-9;  // of the longest row

// Orthonormal columns beside a joint's actuation that complete the moments it can exert.
std::vector<Vector3d> idle_directions(const model::Joint& joint, int freedoms) {
  std::vector<Vector3d> found;
  for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c) found.push_back(joint.actuation.col(c));
  const std::size_t actuated = found.size();
  for (int c = 0; c < freedoms && static_cast<int>(found.size()) < freedoms; ++c) {
    Vector3d rest = Vector3d::Unit(c);
    for (const Vector3d& known : found) rest -= known.dot(rest) * known;
    if (rest.norm() > 0.5) found.push_back(rest.normalized());  // of three unit vectors one always has more left
  }
  return {found.begin() + static_cast<std::ptrdiff_t>(actuated), found.end()};
}

}  // namespace

MomentBasis::MomentBasis(const System& system, const MatrixXd& shape_basis, const Rotations& rotation)
    : system_(system) {
  std::vector<Column> idle;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c) column_.push_back({j, joint.actuation.col(c)});
    for (const Vector3d& direction : idle_directions(joint, system.body(joint.child).freedoms))
      idle.push_back({j, direction});
  }
  column_.insert(column_.end(), idle.begin(), idle.end());
  const auto whole = [](const Joint& joint) { return joint.free() && joint.actuation.cols() == 3; };
  if (is_identity(shape_basis) && std::all_of(system.joints().begin(), system.joints().end(), whole))
    by_joint_.setZero(size());
  if (shape_basis.rows() == shape_basis.cols()) return;
  // of the idle ones as many as add to what the coordinates feel
  MatrixXd work(shape_size(system), size());
  virtual_work(rotation, work);
  const MatrixXd felt = work.transpose() * shape_basis;
  const Eigen::Index controls = system.control_count();
  column_.resize(at(system.control_count()));
  const MatrixXd beside = felt.bottomRows(felt.rows() - controls) * algebra::null_space(felt.topRows(controls));
  if (beside.cols() == 0) return;
  std::vector<int> kept = algebra::independent_rows(beside, felt_threshold);
  std::sort(kept.begin(), kept.end());
  for (int c : kept) column_.push_back(idle[at(c)]);
}

void MomentBasis::controls(const VectorXd& moment, Moments& by_joint) const {
  for (Vector3d& u : by_joint) u.setZero();
  for (int c = 0; c < system_.control_count(); ++c)
    by_joint[at(column_[at(c)].joint)] += moment[c] * column_[at(c)].direction;
}

void MomentBasis::virtual_work(const Rotations& R, MatrixXd& work) const {
  work.setZero();
  for (int c = 0; c < size(); ++c) {
    const Joint& joint = system_.joint(column_[at(c)].joint);
    const Vector3d& u = column_[at(c)].direction;
    const Body& child = system_.body(joint.child);
    auto column = work.col(c);
    if (!joint.free()) {
      column.segment(shape_offset(child), child.freedoms) = -u.head(child.freedoms);
      continue;
    }
    column.segment<3>(shape_offset(child)) = -(R[at(joint.child)].transpose() * (R[at(joint.parent)] * u));
    // on to where the parent may turn
    Vector3d moment = u;
    for (int b = joint.parent; b > 0; b = system_.body(b).parent) {
      const Body& body = system_.body(b);
      if (body.freedoms == 3) {
        column.segment<3>(shape_offset(body)) = moment;
        break;
      }
      const JointFrame frame = mechanics::joint_frame(system_.joint(body.joint), R[at(body.parent)], R[at(b)]);
      column.segment(shape_offset(body), body.freedoms) = (frame.axes.transpose() * moment).head(body.freedoms);
      moment = (frame.child_to_parent * moment).eval();
    }
  }
}

// A body's turn feels its own joint's moment and those of its children's: −Qᵀu + Σ u.
void MomentBasis::solve(const Rotations& R, VectorXd& x) {
  const std::vector<int>& bodies = system_.root_to_leaves();
  for (auto b = bodies.rbegin(); b != bodies.rend(); ++b) {
    const Body& body = system_.body(*b);
    if (body.parent < 0) continue;
    const Vector3d u = -(R[at(body.parent)].transpose() * (R[at(*b)] * x.segment<3>(shape_offset(body))));
    if (body.parent > 0) x.segment<3>(shape_offset(system_.body(body.parent))) -= u;
    by_joint_.segment<3>(3 * body.joint) = system_.joint(body.joint).actuation.leftCols<3>().transpose() * u;
  }
  x.swap(by_joint_);
}

void MomentBasis::solve_transposed(const Rotations& R, VectorXd& x) {
  x.swap(by_joint_);
  for (int b : system_.root_to_leaves()) {
    const Body& body = system_.body(b);
    if (body.parent < 0) continue;
    Vector3d turn = -(system_.joint(body.joint).actuation.leftCols<3>() * by_joint_.segment<3>(3 * body.joint));
    if (body.parent > 0) turn += x.segment<3>(shape_offset(system_.body(body.parent)));
    x.segment<3>(shape_offset(body)) = R[at(b)].transpose() * (R[at(body.parent)] * turn);
  }
}

// A ball joint's moment u does the work −u·Qρ with ρ = η_c − Qᵀη_p; along a second direction Qρ changes by
// Q(ρ_2 × η_c + …) − …, equation 8.19 without its springs.
void MomentBasis::virtual_work_by_shape(const Rotations& R, mechanics::NodeTurns along, MatrixXd& by_shape) const {
  by_shape.setZero();
  for (int c = 0; c < system_.control_count(); ++c) {
    const Joint& joint = system_.joint(column_[at(c)].joint);
    if (!joint.free()) continue;  // along axes all rates are constant
    const Vector3d& u = column_[at(c)].direction;
    auto row = by_shape.row(c);
    const Matrix3d Q = mechanics::child_to_parent(R, joint);
    const Vector3d on_child = (Q.transpose() * u).cross(along.turns[at(joint.child)]);
    row.segment<3>(shape_offset(system_.body(joint.child))) = on_child.transpose();
    // by the parent's turn and, where it is led, by how its turn along `along` changes
    Vector3d moment = -(Q * on_child), on_change = u;
    for (int b = joint.parent; b > 0; b = system_.body(b).parent) {
      const Body& body = system_.body(b);
      if (body.freedoms == 3) {
        row.segment<3>(shape_offset(body)) += moment.transpose();
        break;
      }
      const Joint& up = system_.joint(body.joint);
      const JointFrame frame = mechanics::joint_frame(up, R[at(body.parent)], R[at(b)]);
      const Vector3d carried = frame.child_to_parent.transpose() * along.turns[at(body.parent)];
      Vector3d by_freedoms = frame.axes.transpose() * (moment + on_change.cross(carried));
      if (up.kind == model::JointKind::universal)  // its first axis moves with the second angle
        by_freedoms[1] += along.freedoms[at(b)][0] * frame.axes.col(0).cross(up.child_axis).dot(on_change);
      row.segment(shape_offset(body), body.freedoms) += by_freedoms.head(body.freedoms).transpose();
      moment = (frame.child_to_parent * moment).eval();
      on_change = (frame.child_to_parent * on_change).eval();
    }
  }
}

}  // namespace lamprey::shape
