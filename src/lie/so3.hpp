// The rotation group SO(3): kernels on fixed-size arrays. Perturbations act on the body side, δR = R η̂, everywhere.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace lamprey::lie {

using Vector3 = Eigen::Vector3d;
using Vector4 = Eigen::Vector4d;  // quaternion as (scalar, vector)
using Matrix3 = Eigen::Matrix3d;

/// rad: a turn by this angle, the shorter way round.
inline double shorter_way(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// The skew matrix v̂ with v̂ w = v × w.
inline Matrix3 hat(const Vector3& v) {
  Matrix3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// m v̂, cheaper than the product.
inline Matrix3 times_hat(const Matrix3& m, const Vector3& v) {
  Matrix3 result;
  for (int r = 0; r < 3; ++r) {
    result(r, 0) = m(r, 1) * v.z() - m(r, 2) * v.y();
    result(r, 1) = m(r, 2) * v.x() - m(r, 0) * v.z();
    result(r, 2) = m(r, 0) * v.y() - m(r, 1) * v.x();
  }
  return result;
}

/// Inverse of hat on the skew part of a matrix: vee(A) = the v with v̂ = (A − Aᵀ)/2.
inline Vector3 vee(const Matrix3& a) { return 0.5 * Vector3(a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1)); }

/// Matrix of the quadratic form η ↦ u · η̂ η̂ w, symmetric: second derivatives of rotated vectors along exponentials.
inline Matrix3 double_cross(const Vector3& u, const Vector3& w) {
  return 0.5 * (u * w.transpose() + w * u.transpose()) - u.dot(w) * Matrix3::Identity();
}

/// The x with axes · x nearest to v, for two unit columns that are not parallel, or one and a zero column.
inline Eigen::Vector2d coordinates_along(const Eigen::Matrix<double, 3, 2>& axes, const Vector3& v) {
  const double first = axes.col(0).dot(v);
  if (axes.col(1).isZero(0.0)) return {first, 0.0};
  const double lean = axes.col(0).dot(axes.col(1)), second = axes.col(1).dot(v);
  return Eigen::Vector2d(first - lean * second, second - lean * first) / (1.0 - lean * lean);
}

/// Rotation by |v| radians about v.
Matrix3 exp(const Vector3& v);

/// Rotation vector of R, |log R| ≤ π; accurate near 0 and near π. At exactly π one of the two vectors is returned.
Vector3 log(const Matrix3& R);

/// Rotation of the Cayley vector zeta = tan(angle/2) axis: (I + ζ̂)(I − ζ̂)⁻¹. Cannot represent a half turn.
Matrix3 cayley(const Vector3& zeta);

/// cayley(zeta) − I without the cancellation of a subtraction.
Matrix3 cayley_minus_identity(const Vector3& zeta);

/// Cayley vector of R; grows without bound towards the half turn.
Vector3 inverse_cayley(const Matrix3& R);

/// η = cayley_tangent(ζ) δζ with cayley(ζ + δζ) = cayley(ζ) exp(η) to first order: 2 (I − ζ̂)/(1 + |ζ|²).
Matrix3 cayley_tangent(const Vector3& zeta);

/// η = exp_tangent(v) δv with exp(v + δv) = exp(v) exp(η) to first order.
Matrix3 exp_tangent(const Vector3& v);

/// δv = log_tangent(v) η with exp(v) exp(η) = exp(v + δv) to first order: inverse of exp_tangent, |v| < 2π.
Matrix3 log_tangent(const Vector3& v);

/// Rate of log_tangent(v) when v moves at `rate`.
Matrix3 log_tangent_rate(const Vector3& v, const Vector3& rate);

/// Rotation of the quaternion q = (scalar, vector), of any non-zero length: R(q/|q|).
Matrix3 rotation_of_quaternion(const Vector4& q);

/// Unit quaternion of R with scalar part ≥ 0.
Vector4 quaternion_of_rotation(const Matrix3& R);

/// Hamilton product a ∘ b: R(a ∘ b) = R(a) R(b).
Vector4 quaternion_product(const Vector4& a, const Vector4& b);

/// η = quaternion_tangent(q) δq with R(q + δq) = R(q) exp(η) to first order, q of any non-zero length.
Eigen::Matrix<double, 3, 4> quaternion_tangent(const Vector4& q);

/// Full angle of the rotation R in [0, π], rad; accurate at both ends.
double rotation_angle(const Matrix3& R);

/// The rotation nearest to a matrix that is one up to 1e-8.
Matrix3 renormalized(const Matrix3& R);

}  // namespace lamprey::lie
