// Inertia of a solid ellipse in the plane, in unbounded, irrotational, perfect fluid: one metre of an endless cylinder
// (docs/theory, section 1).
#pragma once

#include <Eigen/Core>

#include "fluid/ellipsoid.hpp"

namespace lamprey::fluid {

/// Inertia of one metre of a homogeneous, neutrally buoyant elliptic cylinder along e_3 with the given semi-axes (half lengths
/// along e_1 and e_2, m), per metre of depth: volume in m³ of that metre and so on. In the plane the fluid moves around it as
/// Lamb has it (equation 1.23); out of the plane, where such bodies do not move, the body's own inertia stands alone. Throws
/// std::invalid_argument as ellipsoid_inertia does. Source: Lamb, Hydrodynamics, §71.
EllipsoidInertia ellipse_inertia(const Eigen::Vector2d& semi_axes, double density);

/// Squared radii of gyration of that homogeneous metre about its axes, m².
Eigen::Vector3d ellipse_spread(const Eigen::Vector2d& semi_axes);

/// The third half length with which such a body is drawn, m: the shorter of the two.
inline double drawn_depth(const Eigen::Vector2d& semi_axes) { return semi_axes.minCoeff(); }

}  // namespace lamprey::fluid
