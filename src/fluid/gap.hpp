// How far apart two ellipsoids are, or how deep one is in the other, with first and second derivatives.
#pragma once

#include <Eigen/Core>

namespace lamprey::fluid {

/// Two solid ellipsoids.
struct EllipsoidPair {
  Eigen::Vector3d semi_axes_1;  // m, positive
  Eigen::Vector3d semi_axes_2;
  Eigen::Matrix3d rotation_1;  // its own axes → world
  Eigen::Matrix3d rotation_2;
  Eigen::Vector3d offset;  // centre 2 − centre 1, m, world
};

struct Gap {
  /// Least distance of the surfaces where they are apart; where they overlap, minus the least distance that one body
  /// must be moved until they only touch. m.
  double value;
  /// Unit, from 1 to 2, world: along the least distance, or the way on which 2 leaves 1 soonest.
  Eigen::Vector3d direction;
  /// Points of the surfaces, from centre 1 and from centre 2, m, world:
  /// offset + point_2 − point_1 = value · direction.
  Eigen::Vector3d point_1;
  Eigen::Vector3d point_2;
  /// False when the search ran out of steps; then `value` is only a lower bound.
  bool converged;
};

/// Gap of two ellipsoids (equation 1.19), to round-off of the largest length. Where they overlap there can be several
/// ways out of nearly equal length; the shortest of those found from 13 starts is returned, and of ways equally long
/// (such as with a common centre) one of them. Tested for axis ratios up to 100. Not checked: positive semi-axes,
/// orthogonal rotations, finite numbers.
Gap gap(const EllipsoidPair& pair);

/// The same, searched from a direction (any length but zero) near the one sought, such as that of a moment before:
/// several times faster. Bodies apart have one answer from anywhere. Where they overlap it is the way out that `near`
/// leads to, not necessarily the shortest: a smooth function of the pair, and never above the gap.
Gap gap(const EllipsoidPair& pair, const Eigen::Vector3d& near);

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// First and second derivatives of the gap by (turn of 1, turn of 2, offset), rad and m: R_i exp(η̂_i), each turn in its
/// body's own frame, offset in the world. Second derivatives are those along exponentials, at η = 0 (equations 1.20
/// to 1.22). `result` is what `gap` returned for this pair. Overlapping bodies with two shortest ways out have a kink:
/// then of the way in `result`. Directions in which that way can be changed at no cost to first and second order are
/// left out of the second derivatives, which do not exist there (two balls with a common centre).
void gap_derivatives(const EllipsoidPair& pair, const Gap& result, Vector9d& gradient, Matrix9d& hessian);

}  // namespace lamprey::fluid
