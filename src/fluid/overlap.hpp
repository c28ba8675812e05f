// Do two ellipsoids touch? The contact function of Perram and Wertheim (J. Comput. Phys. 58, 1985).
#pragma once

#include <Eigen/Core>

namespace lamprey::fluid {

/// A solid ellipsoid somewhere in space.
struct PlacedEllipsoid {
  Eigen::Vector3d semi_axes;  // m, positive
  Eigen::Matrix3d rotation;   // its own axes → world
  Eigen::Vector3d centre;     // m, world
};

struct Contact {
  /// Contact function: the square of the factor by which both bodies must grow about their centres until they touch.
  /// Above 1 they are apart, at 1 they touch, below 1 they overlap; 0 for equal centres.
  double value;
  /// λ in (0, 1) at the maximum of λ(1−λ) rᵀ((1−λ)A + λB)⁻¹r with A = R_a diag(a²) R_aᵀ, B likewise, r from a to b.
  double fraction;
  /// ((1−λ)A + λB)⁻¹r, 1/m, world: normal to both grown bodies where they touch, from a to b. The derivative of
  /// `value` with respect to r is 2λ(1−λ) times this.
  Eigen::Vector3d normal;
  /// Where the grown bodies touch, m, world.
  Eigen::Vector3d point;
  /// How far b can move along the line of centres towards a before they touch, m; negative when they overlap (then how
  /// far it must move away). Not smaller than the least distance between the two surfaces. For equal centres: minus the
  /// sum of the shortest semi-axes.
  double centre_line_gap;
};

/// Contact of two ellipsoids. Not checked: positive semi-axes, orthogonal rotations. Relative error of the value
/// below 1e-12 for axis ratios up to 10, growing with the square of the ratio.
Contact contact(const PlacedEllipsoid& a, const PlacedEllipsoid& b);

}  // namespace lamprey::fluid
