// Inertia of a solid ellipsoid in unbounded, irrotational, perfect fluid (docs/theory, section 1).
#pragma once

#include <Eigen/Core>

namespace lamprey::fluid {

/// Inertia of a homogeneous, neutrally buoyant ellipsoid: diagonals in the frame of its own axes, about its centre.
struct EllipsoidInertia {
  double volume;                  // m³
  double mass;                    // kg, of the displaced fluid, hence of the body itself
  Eigen::Vector3d body_inertia;   // kg m², homogeneous body without fluid
  Eigen::Vector3d added_mass;     // kg
  Eigen::Vector3d added_inertia;  // kg m², exactly 0 about an axis of revolution
};

/// Inertia of the ellipsoid with the given semi-axes (half lengths, m) in fluid of the given density (kg/m³).
/// Free of cancellation: relative error below 1e-14, tested for axis ratios up to 1e6. Throws std::invalid_argument
/// unless every semi-axis is positive and finite, their ratios at most 1e50, and the density finite and not negative
/// (0 is a vacuum). Source: Lamb, Hydrodynamics, §114–115.
EllipsoidInertia ellipsoid_inertia(const Eigen::Vector3d& semi_axes, double density);

/// std::invalid_argument for what ellipsoid_inertia refuses.
void require_valid_axes(const Eigen::Vector3d& semi_axes, double density);

}  // namespace lamprey::fluid
