// Derivatives of an ellipsoid's inertia by its semi-axes and by the fluid's density, by formula (equations 1.12 to
// 1.18).
#pragma once

#include <Eigen/Core>

#include "fluid/ellipsoid.hpp"

namespace lamprey::fluid {

/// Change of EllipsoidInertia by the semi-axes, fluid's density fixed: entries along rows, semi-axes along columns.
struct EllipsoidInertiaBySemiAxes {
  Eigen::Vector3d volume;         // [3] m²
  Eigen::Vector3d mass;           // [3] kg/m, neutrally buoyant
  Eigen::Matrix3d body_inertia;   // [3][3] kg m, neutrally buoyant: the mass grows with the volume
  Eigen::Matrix3d added_mass;     // [3][3] kg/m
  Eigen::Matrix3d added_inertia;  // [3][3] kg m, row exactly 0 about an axis of revolution
};

/// Change of EllipsoidInertia by the fluid's density, semi-axes fixed; the volume does not change.
struct EllipsoidInertiaByDensity {
  double mass;                    // m³, neutrally buoyant
  Eigen::Vector3d body_inertia;   // [3] m⁵, neutrally buoyant
  Eigen::Vector3d added_mass;     // [3] m³
  Eigen::Vector3d added_inertia;  // [3] m⁵
};

struct EllipsoidInertiaDerivatives {
  EllipsoidInertiaBySemiAxes by_semi_axes;
  EllipsoidInertiaByDensity by_density;
};

/// Derivatives of ellipsoid_inertia at the given semi-axes (m) and density (kg/m³); refuses what it refuses.
/// Equal or nearly equal axes are no special case: nothing is divided by their difference. Error below 1e-14 of the
/// largest entry of each row, tested for axis ratios up to 1e6. A single entry can be far smaller than that (the change
/// of a needle's added mass along it by its own length fades with the square of the aspect) and is then less accurate
/// by itself: 1e-11 at aspect 1,000.
EllipsoidInertiaDerivatives ellipsoid_inertia_derivatives(const Eigen::Vector3d& semi_axes, double density);

/// Change of the inertia (m/5)(b² + c²), … of a homogeneous ellipsoid whose mass is given rather than displaced.
struct HomogeneousInertiaDerivatives {
  Eigen::Matrix3d by_semi_axes;  // [3][3] kg m, mass fixed: entries along rows, semi-axes along columns
  Eigen::Vector3d by_mass;       // [3] m², semi-axes fixed
};

/// Derivatives of body inertia at the given semi-axes (m) and mass (kg) (equation 1.17). Not checked: positive numbers.
HomogeneousInertiaDerivatives homogeneous_inertia_derivatives(const Eigen::Vector3d& semi_axes, double mass);

}  // namespace lamprey::fluid
