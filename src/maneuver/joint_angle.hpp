// How far a joint has turned about one axis, with first and second derivatives (chapter 10, equation 10.2).
#pragma once

#include <Eigen/Core>

#include "model/system.hpp"

namespace lamprey::maneuver {

/// The axis about which an angle of a hinge or universal joint counts, child's frame at zero angle. The two axes of a universal
/// joint are orthogonal there, so that with (8.1) each angle is the twist about its axis, whichever turns first.
Eigen::Vector3d angle_axis(const model::Joint& joint, int freedom);

/// The joint's twist from its zero angle about an axis of the child there, at Q = R_pᵀR_c; rad in [−π, π].
double twist_about(const Eigen::Vector3d& axis, const model::Joint& joint, const Eigen::Matrix3d& child_to_parent);

/// Its derivatives by turns of parent and child, body frames along exponentials.
struct TwistDerivatives {
  Eigen::Matrix<double, 6, 1> gradient;
  Eigen::Matrix<double, 6, 6> hessian;
};
TwistDerivatives twist_derivatives(const Eigen::Vector3d& axis, const model::Joint& joint,
                                   const Eigen::Matrix3d& child_to_parent);

}  // namespace lamprey::maneuver
