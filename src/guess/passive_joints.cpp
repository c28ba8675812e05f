#include "guess/passive_joints.hpp"

#include <Eigen/SparseLU>
#include <algorithm>
#include <vector>

#include "algebra/row_space.hpp"
#include "guess/guess.hpp"
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
using shape::ShapeKernel;
using shape::ShapeStep;

constexpr int passive_rounds = 12;
constexpr double passive_difference = 1e-6;     // rad
constexpr double longest_passive_change = 0.5;  // rad, in a round
constexpr double settled_change = 1e-9;         // rad, of the last change
constexpr double longest_way_off = 3.0;         // rad, off the path
constexpr int cycle_rounds = 40;
constexpr int beside_each_other = 3;     // nodes that an idle moment knows
constexpr double shortest_share = 1e-3;  // of Newton's step
constexpr double rough_change = 1e-6;    // rad, below which round-off keeps it from going on
constexpr int tried_cycles = 4;
constexpr double calmer = 0.5;  // of the swings before

Rotations from_root(const Rotations& R) {
  Rotations shape = R;
  for (Matrix3d& rotation : shape) rotation = R[0].transpose() * rotation;
  return shape;
}

// x with rows · x = values.
VectorXd solution(const MatrixXd& rows, const VectorXd& values) { return algebra::shortest_solution(rows, values); }

// Goes on from node k by a step.
void step_on(const ShapeStep& step, std::size_t k, NodePath& path) {
  path.rotation[k + 1] = step.interval.next_rotation;
  for (Matrix3d& rotation : path.rotation[k + 1]) rotation = lie::renormalized(rotation);
  path.position[k + 1] = path.position[k] + step.interval.displacement;
}

// What moments a motion would take about that which nothing moves.
class IdleMoments {
 public:
  IdleMoments(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates)
      : system_(system),
        time_step_(maneuver.time_step()),
        basis_(coordinates.shape),
        kernel_(system, maneuver.lagrangian, basis_),
        moments_(system, basis_, maneuver.start.rotation),
        work_(shape_size(system), moments_.size()),
        buffer_(system.body_count()) {}

  // How many there are at a node.
  Eigen::Index count() const { return basis_.cols() - system_.control_count(); }

  // At a node with these rotations.
  void go_to(const Rotations& R) {
    moments_.virtual_work(R, work_);
    impulse_ = basis_.transpose() * work_;
  }

  // Of a node that was gone to: ways to move the shape along which no actuated moment does work.
  MatrixXd directions() const {
    return basis_ * algebra::null_space(impulse_.leftCols(system_.control_count()).transpose());
  }

  // Of a node that was gone to, under this impulse along the coordinates.
  VectorXd idle(const VectorXd& impulse) const { return solution(impulse_, impulse).tail(count()); }

  // A shape that moves by `off` along directions.
  Rotations moved(const Rotations& shape, const MatrixXd& directions, const VectorXd& off) {
    Rotations next = shape;
    move_shape(system_, shape, directions * off, buffer_, next);
    return next;
  }

  // The step from rotations to a shape at zero total momentum.
  bool step_to(const Rotations& R, const Rotations& shape, ShapeStep& step) {
    return kernel_.solve(time_step_, R, shape, step);
  }

 private:
  const System& system_;
  double time_step_;
  const MatrixXd& basis_;
  ShapeKernel kernel_;
  MomentBasis moments_;
  MatrixXd work_, impulse_;
  mechanics::Interval buffer_;
};

// From the start on, node by node.
class PassiveJoints {
 public:
  PassiveJoints(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates)
      : maneuver_(maneuver),
        idle_(system, maneuver, coordinates),
        step_(system),
        tried_(system),
        arrived_impulse_(coordinates.shape.transpose() * maneuver.start.momentum.segment(3, coordinates.shape.rows())) {
  }

  std::optional<NodePath> follow(const NodePath& path) {
    NodePath followed = path;
    followed.rotation.front() = maneuver_.start.rotation;
    followed.position.front() = maneuver_.start.position;
    VectorXd off = VectorXd::Zero(idle_.count()), before = off;
    for (std::size_t k = 0; k + 1 < path.rotation.size(); ++k) {
      const Rotations& R = followed.rotation[k];
      idle_.go_to(R);
      directions_ = idle_.directions();
      const Rotations planned = from_root(path.rotation[k + 1]);
      const VectorXd guess = off + (off - before);
      before = off;
      off = guess;
      if (!find(R, planned, off)) return std::nullopt;
      step_on(step_, k, followed);
      arrived_impulse_ = step_.plus;
    }
    return followed;
  }

 private:
  // Moments about what nothing moves, over a step to the planned shape and `off` beside it.
  std::optional<VectorXd> idle_moments(const Rotations& R, const Rotations& planned, const VectorXd& off,
                                       ShapeStep& step) {
    if (!idle_.step_to(R, idle_.moved(planned, directions_, off), step)) return std::nullopt;
    return idle_.idle(step.minus - arrived_impulse_);
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

  const Maneuver& maneuver_;
  IdleMoments idle_;
  MatrixXd directions_;
  ShapeStep step_, tried_;
  VectorXd arrived_impulse_;  // [f] momentum along the coordinates that comes to the node
};

// Of a closed path of shapes, all nodes at once.
class PassiveCycle {
 public:
  PassiveCycle(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
               const NodePath& path)
      : idle_(system, maneuver, coordinates),
        nodes_(static_cast<int>(path.rotation.size()) - 1),
        count_(idle_.count()),
        step_(at(nodes_), ShapeStep(system)),
        shape_(at(nodes_)) {
    for (int k = 0; k < nodes_; ++k) {
      planned_.push_back(from_root(path.rotation[at(k)]));
      idle_.go_to(planned_.back());
      directions_.push_back(idle_.directions());
    }
  }

  // Newton's method from the planned shapes on, by shorter steps where whole ones lead away.
  bool settle() {
    VectorXd off = VectorXd::Zero(nodes_ * count_), idle(off.size()), tried(off.size());
    if (!idle_moments(off, idle)) return false;
    for (int round = 0; round < cycle_rounds; ++round) {
      std::optional<VectorXd> change = newton_step(off, idle);
      if (!change) return false;
      const double size = change->lpNorm<Eigen::Infinity>();
      double share = std::min(1.0, longest_passive_change / size);
      while (!idle_moments(off + share * *change, tried) || !(tried.norm() < idle.norm())) {
        share *= 0.5;
        if (share < shortest_share) return size < rough_change && idle_moments(off, idle);
      }
      off += share * *change;
      idle = tried;
      if (!(off.lpNorm<Eigen::Infinity>() < longest_way_off)) return false;
      if (size < settled_change) return true;
    }
    return false;
  }

  // The motion of the shapes that were settled last, from this attitude and place of the root on.
  std::optional<NodePath> motion(const Matrix3d& root, const NodePath& path) {
    NodePath settled = path;
    settled.rotation[0] = shape_[0];
    for (Matrix3d& rotation : settled.rotation[0]) rotation = root * rotation;
    for (int k = 0; k < nodes_; ++k) {
      if (!idle_.step_to(settled.rotation[at(k)], shape_[at((k + 1) % nodes_)], step_[at(k)])) return std::nullopt;
      step_on(step_[at(k)], at(k), settled);
    }
    return settled;
  }

 private:
  auto of_node(VectorXd& all, int k) const { return all.segment(k * count_, count_); }
  auto of_node(const VectorXd& all, int k) const { return all.segment(k * count_, count_); }

  // [nodes] moments about what nothing moves, with shapes `off` beside the planned ones.
  bool idle_moments(const VectorXd& off, VectorXd& idle) {
    for (int k = 0; k < nodes_; ++k) shape_[at(k)] = idle_.moved(planned_[at(k)], directions_[at(k)], of_node(off, k));
    for (int k = 0; k < nodes_; ++k)
      if (!idle_.step_to(shape_[at(k)], shape_[at((k + 1) % nodes_)], step_[at(k)])) return false;
    for (int k = 0; k < nodes_; ++k) {
      idle_.go_to(shape_[at(k)]);
      of_node(idle, k) = idle_.idle(step_[at(k)].minus - step_[at((k + nodes_ - 1) % nodes_)].plus);
    }
    return idle.allFinite();
  }

  // Differences, by shapes at every third node at once: a node's moments know its own shape and those beside it.
  std::optional<VectorXd> newton_step(const VectorXd& off, const VectorXd& idle) {
    std::vector<Eigen::Triplet<double>> entries;
    VectorXd there(off.size());
    for (const std::vector<int>& apart : nodes_apart())
      for (Eigen::Index d = 0; d < count_; ++d) {
        VectorXd changed = off;
        for (int k : apart) of_node(changed, k)[d] += passive_difference;
        if (!idle_moments(changed, there)) return std::nullopt;
        const VectorXd by_off = (there - idle) / passive_difference;
        for (int k : apart)
          for (const int beside : {-1, 0, 1}) {
            const int row = (k + beside + nodes_) % nodes_;
            for (Eigen::Index r = 0; r < count_; ++r)
              entries.emplace_back(row * count_ + r, k * count_ + d, of_node(by_off, row)[r]);
          }
      }
    Eigen::SparseMatrix<double> rows(off.size(), off.size());
    rows.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseLU<Eigen::SparseMatrix<double>> factors(rows);
    if (factors.info() != Eigen::Success) return std::nullopt;
    const VectorXd change = factors.solve(-idle);
    return change.allFinite() ? std::optional(change) : std::nullopt;
  }

  // Every node once, those of one list at least three apart around the cycle.
  std::vector<std::vector<int>> nodes_apart() const {
    const int thirds = nodes_ - nodes_ % beside_each_other;
    std::vector<std::vector<int>> lists(beside_each_other);
    for (int k = 0; k < thirds; ++k) lists[at(k % beside_each_other)].push_back(k);
    for (int k = thirds; k < nodes_; ++k) lists.push_back({k});
    return lists;
  }

  IdleMoments idle_;
  int nodes_;
  Eigen::Index count_;
  std::vector<ShapeStep> step_;
  std::vector<Rotations> planned_, shape_;
  std::vector<MatrixXd> directions_;
};

}  // namespace

std::optional<NodePath> with_passive_joints(const System& system, const Maneuver& maneuver,
                                            const ShapeCoordinates& coordinates, const NodePath& path) {
  return PassiveJoints(system, maneuver, coordinates).follow(path);
}

std::optional<NodePath> cycle_of_passive_joints(const System& system, const Maneuver& maneuver,
                                                const ShapeCoordinates& coordinates, const NodePath& path,
                                                double share) {
  if (maneuver.steps < beside_each_other) return std::nullopt;
  for (int tried = 0; tried < tried_cycles; ++tried, share *= calmer) {
    const NodePath swings = calmed(system, path, share);
    PassiveCycle cycle(system, maneuver, coordinates, swings);
    if (cycle.settle()) return cycle.motion(maneuver.start.rotation[0], swings);
  }
  return std::nullopt;
}

}  // namespace lamprey::guess
