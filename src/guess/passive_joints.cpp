#include "guess/passive_joints.hpp"

#include <algorithm>

#include "algebra/row_space.hpp"
#include "shape/moment_basis.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::move_shape;
using maneuver::shape_size;
using mechanics::Rotations;
using model::at;
using model::System;
using shape::MomentBasis;
using shape::seen_from_root;
using shape::ShapeKernel;
using shape::ShapeStep;

constexpr int passive_rounds = 12;
constexpr double passive_difference = 1e-6;     // rad
constexpr double longest_passive_change = 0.5;  // rad, in a round
constexpr double settled_change = 1e-9;         // rad, of the last change
constexpr double longest_way_off = 3.0;         // rad, off the path

class PassiveJoints {
 public:
  PassiveJoints(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates)
      : system_(system),
        maneuver_(maneuver),
        basis_(coordinates.shape),
        kernel_(system, maneuver.lagrangian, basis_),
        moments_(system, basis_, maneuver.start.rotation),
        work_(shape_size(system), moments_.size()),
        buffer_(system.body_count()),
        step_(system),
        tried_(system),
        arrived_impulse_(basis_.transpose() * maneuver.start.momentum.segment(3, basis_.rows())) {}

  std::optional<NodePath> follow(const NodePath& path) {
    NodePath followed = path;
    followed.rotation.front() = maneuver_.start.rotation;
    followed.position.front() = maneuver_.start.position;
    VectorXd off = VectorXd::Zero(basis_.cols() - system_.control_count()), before = off;
    for (std::size_t k = 0; k + 1 < path.rotation.size(); ++k) {
      const Rotations& R = followed.rotation[k];
      lay_moments(R);
      directions_ = basis_ * algebra::null_space(impulse_.leftCols(system_.control_count()).transpose());
      const Rotations planned = seen_from_root(path.rotation[k + 1]);
      const VectorXd guess = off + (off - before);
      before = off;
      off = guess;
      if (!find(R, planned, off)) return std::nullopt;
      followed.rotation[k + 1] = step_.interval.next_rotation;
      for (Matrix3d& rotation : followed.rotation[k + 1]) rotation = lie::renormalized(rotation);
      followed.position[k + 1] = followed.position[k] + step_.interval.displacement;
      arrived_impulse_ = step_.plus;
    }
    return followed;
  }

 private:
  static Rotations seen_from_root(const Rotations& R) {
    Rotations shape = R;
    for (Matrix3d& rotation : shape) rotation = R[0].transpose() * rotation;
    return shape;
  }

  // Impulses along the coordinates by unit moments at a node.
  void lay_moments(const Rotations& R) {
    moments_.virtual_work(R, work_);
    impulse_ = basis_.transpose() * work_;
  }

  // Moments about what nothing moves, over a step to the planned shape and `off` beside it.
  std::optional<VectorXd> idle_moments(const Rotations& R, const Rotations& planned, const VectorXd& off,
                                       ShapeStep& step) {
    Rotations next = planned;
    move_shape(system_, planned, directions_ * off, buffer_, next);
    if (!kernel_.solve(maneuver_.time_step(), R, next, step)) return std::nullopt;
    const VectorXd moments = solution(impulse_, step.minus - arrived_impulse_);
    return VectorXd(moments.tail(off.size()));
  }

  bool find(const Rotations& R, const Rotations& planned, VectorXd& off) {
    for (int round = 0; round < passive_rounds; ++round) {
      const std::optional<VectorXd> idle = idle_moments(R, planned, off, step_);
      if (!idle) return false;
      MatrixXd by_off(off.size(), off.size());
      for (Eigen::Index d = 0; d < off.size(); ++d) {
        VectorXd changed = off;
        changed[d] += passive_difference;
        tried_ = step_;
        const std::optional<VectorXd> there = idle_moments(R, planned, changed, tried_);
        if (!there) return false;
        by_off.col(d) = (*there - *idle) / passive_difference;
      }
      VectorXd change = -solution(by_off, *idle);
      const double size = change.lpNorm<Eigen::Infinity>();
      if (!(size < 1.0 / passive_difference)) return false;
      off += std::min(1.0, longest_passive_change / size) * change;
      if (!(off.lpNorm<Eigen::Infinity>() < longest_way_off)) return false;
      if (size < settled_change) return idle_moments(R, planned, off, step_).has_value();
    }
    return false;
  }

  // x with rows · x = values.
  static VectorXd solution(const MatrixXd& rows, const VectorXd& values) {
    return algebra::shortest_solution(rows, values);
  }

  const System& system_;
  const Maneuver& maneuver_;
  const MatrixXd& basis_;
  ShapeKernel kernel_;
  MomentBasis moments_;
  MatrixXd work_, impulse_, directions_;
  mechanics::Interval buffer_;
  ShapeStep step_, tried_;
  VectorXd arrived_impulse_;  // [f] momentum along the coordinates that comes to the node
};

}  // namespace

std::optional<NodePath> with_passive_joints(const System& system, const Maneuver& maneuver,
                                            const ShapeCoordinates& coordinates, const NodePath& path) {
  return PassiveJoints(system, maneuver, coordinates).follow(path);
}

}  // namespace lamprey::guess
