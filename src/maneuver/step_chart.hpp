// Coordinates of a body's step, quaternion q of R_k and turn ω̃ (ζ = h ω̃/2), to second order in body-side perturbations.
#pragma once

#include "lie/so3.hpp"

namespace lamprey::maneuver {

using lie::Matrix3;
using lie::Vector3;
using lie::Vector4;
using Matrix34 = Eigen::Matrix<double, 3, 4>;
using Matrix43 = Eigen::Matrix<double, 4, 3>;
using Matrix4 = Eigen::Matrix4d;

/// First derivatives: η of R_k and η' of R_{k+1} = R_k F by (q, ω̃) (equation 5.6).
struct StepChart {
  StepChart(const Vector4& q, const Vector3& zeta, const Matrix3& F, double h);
  Matrix34 left_by_quaternion;
  Matrix34 right_by_quaternion;
  Matrix3 right_by_turn;
};

/// What the curvature of the chart adds to a Hessian in (q, ω̃) when the gradient by (η, η') is (g, g') (equation 5.7).
struct ChartCurvature {
  ChartCurvature(const StepChart& chart, const Vector4& q, const Vector3& zeta, double h, const Vector3& g,
                 const Vector3& g_next);
  Matrix4 quaternion_quaternion;
  Matrix43 quaternion_turn;
  Matrix3 turn_turn;
};

/// Curvature of R(q) alone, for a gradient g by η.
Matrix4 quaternion_curvature(const Vector4& q, const Vector3& g);

/// The next node's quaternion q ∘ (1, ζ)/√(1 + |ζ|²).
Vector4 advanced_quaternion(const Vector4& q, const Vector3& zeta);
Matrix4 advanced_quaternion_by_quaternion(const Vector3& zeta);
Matrix43 advanced_quaternion_by_cayley(const Vector4& q, const Vector3& zeta);

/// Second derivatives of multiplier · advanced_quaternion(q, ζ) by (q, ζ) and (ζ, ζ); it is linear in q.
struct AdvancedQuaternionCurvature {
  AdvancedQuaternionCurvature(const Vector4& multiplier, const Vector4& q, const Vector3& zeta);
  Matrix43 quaternion_cayley;
  Matrix3 cayley_cayley;
};

/// (r_0* ∘ q_0)* ∘ (r* ∘ q): how a body has turned as seen from another one, whose quaternions are r_0 and r. Linear in each.
Vector4 shape_difference(const Vector4& first, const Vector4& first_root, const Vector4& root, const Vector4& last);

/// 2 vec(q_goal* ∘ q) = rows · q: zero exactly where q turns as the goal does, of either sign.
Matrix34 rotation_goal_rows(const Matrix3& goal);

}  // namespace lamprey::maneuver
