#include "maneuver/moment_basis.hpp"

#include <algorithm>

#include "maneuver/row_space.hpp"

namespace lamprey::maneuver {

namespace {

using mechanics::Freedoms;
using mechanics::Moments;
using mechanics::Rotations;
using model::at;
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
  if (shape_basis.rows() == shape_basis.cols()) return;
  // of the idle ones as many as add to what the coordinates feel
  const MatrixXd felt = virtual_work(rotation).transpose() * shape_basis;
  const Eigen::Index controls = system.control_count();
  column_.resize(at(system.control_count()));
  const MatrixXd beside = felt.bottomRows(felt.rows() - controls) * null_space(felt.topRows(controls));
  if (beside.cols() == 0) return;
  std::vector<int> kept = independent_rows(beside, felt_threshold);
  std::sort(kept.begin(), kept.end());
  for (int c : kept) column_.push_back(idle[at(c)]);
}

Moments MomentBasis::controls(const VectorXd& moment) const {
  Moments u(at(system_.joint_count()), Vector3d::Zero());
  for (int c = 0; c < system_.control_count(); ++c) u[at(column_[at(c)].joint)] += moment[c] * column_[at(c)].direction;
  return u;
}

void MomentBasis::gather(const Moments& by_joint, Eigen::Ref<VectorXd> result) const {
  for (int c = 0; c < size(); ++c) result[c] = column_[at(c)].direction.dot(by_joint[at(column_[at(c)].joint)]);
}

MatrixXd MomentBasis::virtual_work(const Rotations& rotation) const {
  MatrixXd work(shape_size(system_), size());
  mechanics::Vectors turns(at(system_.body_count()));
  Moments by_joint(at(system_.joint_count()));
  VectorXd row(size());
  for_each_coordinate(system_, [&](const Freedoms& unit, int coordinate) {
    mechanics::body_turns(system_, rotation, unit, turns);
    mechanics::control_work(system_, rotation, {unit, turns}, by_joint);
    gather(by_joint, row);
    work.row(coordinate) = row.transpose();
  });
  return work;
}

}  // namespace lamprey::maneuver
