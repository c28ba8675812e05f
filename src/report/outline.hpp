// What an ellipsoid looks like from afar: the outline of its orthographic projection, which is an ellipse.
#pragma once

#include <Eigen/Core>

namespace lamprey::report {

/// Directions on paper: first row to the right, second row up; orthonormal, world frame.
using View = Eigen::Matrix<double, 2, 3>;

View top_view();   // e₁ right, e₂ up, seen against e₃
View side_view();  // e₁ right, e₃ up, seen along e₂
View back_view();  // −e₂ right, e₃ up, seen along e₁

/// An ellipse on paper: {centre + Rot(angle) (a cos s, b sin s)}, a ≥ b ≥ 0 in m, angle in rad from the right, counterclockwise.
struct Ellipse {
  Eigen::Vector2d centre;
  double major = 0.0;
  double minor = 0.0;
  double angle = 0.0;

  /// Half width and half height of the upright box around it, m.
  Eigen::Vector2d half_extent() const;
};

/// Outline of the ellipsoid with these semi-axes (m, body frame), rotation (body → world) and centre (m, world): with
/// S = P R diag(a²) Rᵀ Pᵀ it is {y : (y − P x)ᵀ S⁻¹ (y − P x) = 1}.
Ellipse projected_outline(const Eigen::Vector3d& semi_axes, const Eigen::Matrix3d& R, const Eigen::Vector3d& centre,
                          const View& view);

}  // namespace lamprey::report
