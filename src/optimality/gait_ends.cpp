#include "optimality/gait_ends.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>

#include "integrator/step_derivatives.hpp"

namespace lamprey::optimality {

namespace {

using integrator::StateLayout;
using model::at;
using model::System;

constexpr double within_reach = 1e-7;  // of a direction's length, what moments do not reach
constexpr double out_of_reach = 1e-3;  // a direction with more than this is out of reach; between them nothing is told
constexpr double open_motion = 1e-8;   // of the largest pivot: motions out of reach that do not close
constexpr int most_ranges = 20;        // a growth of 1e20 over the whole is 10 over each

// Body i as the root sees it.
Matrix3d seen_by_root(const mechanics::Rotations& R, int i) { return R[0].transpose() * R[at(i)]; }

bool turns_alone(const System& system, int i) { return system.body(i).freedoms == 3; }

}  // namespace

Eigen::Index shape_freedoms(const StoredMotion& motion) { return motion.system.velocity_count() - 6; }

MatrixXd periodic_start(const StoredMotion& motion, const integrator::State& first, const VectorXd& momentum_unit) {
  const System& system = motion.system;
  const StateLayout layout{system};
  const Eigen::Index freedoms = shape_freedoms(motion);
  const bool shape = motion.problem.start.free_shape;
  MatrixXd directions = MatrixXd::Zero(layout.size(), (shape ? 2 : 1) * freedoms);
  Eigen::Index column = 0;
  for (const bool turns : {true, false}) {
    if (turns && !shape) continue;
    for (int i = 1; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms; ++f, ++column) {
        auto direction = directions.col(column);
        const Matrix3d seen = seen_by_root(first.rotation, i);
        const bool alone = turns_alone(system, i);
        const Vector3d momentum = alone ? Vector3d(first.momentum.segment<3>(layout.freedom(i))) : Vector3d::Zero();
        if (turns) {
          direction[layout.freedom(i) + f] = 1.0;
          if (alone) direction.segment<3>(layout.momentum(0)) = -seen * Vector3d::Unit(f).cross(momentum);
        } else {
          const double unit = momentum_unit[column - (shape ? freedoms : 0)];
          direction[layout.momentum(i) + f] = unit;
          if (alone) direction.segment<3>(layout.momentum(0)) = -unit * seen.col(f);
        }
      }
  }
  return directions;
}

MatrixXd closure_rows(const StoredMotion& motion, const integrator::State& last, const VectorXd& momentum_unit) {
  const System& system = motion.system;
  const StateLayout layout{system};
  const Eigen::Index freedoms = shape_freedoms(motion);
  MatrixXd rows = MatrixXd::Zero(2 * freedoms, layout.size());
  Eigen::Index row = 0;
  for (int i = 1; i < system.body_count(); ++i) {
    const int own = system.body(i).freedoms;
    rows.block(row, layout.freedom(i), own, own).setIdentity();
    if (turns_alone(system, i)) rows.block<3, 3>(row, layout.freedom(0)) = -seen_by_root(last.rotation, i).transpose();
    rows.block(freedoms + row, layout.momentum(i), own, own) =
        momentum_unit.segment(row, own).cwiseInverse().asDiagonal();
    row += own;
  }
  return rows;
}

std::optional<MatrixXd> start_within_reach(const StepTangents& tangents, const std::vector<MatrixXd>& basis,
                                           const MatrixXd& directions, const MatrixXd& closure) {
  const Eigen::Index free = directions.cols();
  std::vector<MatrixXd> rest;  // what is not reached, node after node
  for (const MatrixXd& reached : basis) rest.push_back(complement(reached));
  const Eigen::Index size = rest.front().cols();
  const MatrixXd outside = rest.front().transpose() * directions;  // [rest][free]
  const Eigen::JacobiSVD<MatrixXd> split(outside, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const VectorXd& values = split.singularValues();
  const double length = directions.colwise().norm().maxCoeff();
  const auto out = (values.array() > within_reach * length).count();
  if (out == 0) return MatrixXd(MatrixXd::Identity(free, free));
  if (values[out - 1] < out_of_reach * length) return std::nullopt;
  const MatrixXd kept = split.matrixV().rightCols(free - out);
  // the closure must lead what is reached back to what is reached
  const MatrixXd ends = outside * closure.bottomRows(free);
  if ((ends * basis.back()).norm() > within_reach * ends.norm()) return std::nullopt;

  // unknowns: how far the start is out of reach, and where that leads at the ends of short ranges
  const int steps = static_cast<int>(tangents.A.size()), ranges = std::min(most_ranges, steps);
  MatrixXd ties = MatrixXd::Zero(size * (ranges + 1), out + size * ranges);
  const MatrixXd begin = split.matrixU().leftCols(out);
  for (int r = 0; r < ranges; ++r) {
    MatrixXd carried = MatrixXd::Identity(size, size);
    for (int k = steps * r / ranges; k < steps * (r + 1) / ranges; ++k)
      carried = (rest[at(k + 1)].transpose() * (tangents.A[at(k)] * (rest[at(k)] * carried))).eval();
    if (r == 0)
      ties.topLeftCorner(size, out) = -carried * begin;
    else
      ties.block(size * r, out + size * (r - 1), size, size) = -carried;
    ties.block(size * r, out + size * r, size, size).setIdentity();
  }
  ties.bottomLeftCorner(size, out) = -begin;
  ties.bottomRightCorner(size, size) = ends * rest.back();
  const Eigen::ColPivHouseholderQR<MatrixXd> ranked(ties);
  const VectorXd pivots = ranked.matrixQR().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > open_motion * pivots.maxCoeff())) return std::nullopt;
  return kept;
}

MatrixXd start_curvature(const StoredMotion& motion, const integrator::State& first, const MatrixXd& directions,
                         const VectorXd& costate) {
  const System& system = motion.system;
  const StateLayout layout{system};
  const Eigen::Index free = directions.cols();
  const Vector3d of_root = costate.segment<3>(layout.momentum(0));
  MatrixXd form = MatrixXd::Zero(free, free);
  for (int i = 1; i < system.body_count(); ++i) {
    if (!turns_alone(system, i)) continue;
    const Vector3d pull = -seen_by_root(first.rotation, i).transpose() * of_root;
    const Vector3d momentum = first.momentum.segment<3>(layout.freedom(i));
    const auto turn = directions.middleRows<3>(layout.freedom(i));
    const auto change = directions.middleRows<3>(layout.momentum(i));
    const Matrix3d mixed = lie::hat(pull);  // pull · (turn × change) = −turn · (pull × change)
    const Matrix3d twice = momentum * pull.transpose() - momentum.dot(pull) * Matrix3d::Identity();
    form -= turn.transpose() * mixed * change;
    form += 0.5 * turn.transpose() * twice * turn;
  }
  return form + form.transpose();
}

MatrixXd closure_curvature(const StoredMotion& motion, const VectorXd& multipliers) {
  const System& system = motion.system;
  const StateLayout layout{system};
  MatrixXd form = MatrixXd::Zero(layout.position(), layout.position());
  Eigen::Index row = 0;
  for (int i = 1; i < system.body_count(); ++i) {
    if (turns_alone(system, i))  // ½ multiplier · (turn of the body × turn of the root)
      form.block<3, 3>(layout.freedom(i), layout.freedom(0)) -=
          0.5 * lie::hat(multipliers.segment<3>(row)) * seen_by_root(motion.solution.rotation.back(), i).transpose();
    row += system.body(i).freedoms;
  }
  return form + form.transpose();
}

}  // namespace lamprey::optimality
