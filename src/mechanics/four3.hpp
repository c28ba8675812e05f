// Vectors and 3×3 matrices of four at once, of four directions, bodies or steps: entry by entry. S: Four, or Four with
// their rates (algebra/dual_four.hpp).
#pragma once

#include <Eigen/Core>

#include "algebra/dual_four.hpp"

namespace lamprey::mechanics {

using algebra::DualFour;
using algebra::Four;

/// Three numbers of each.
template <typename S>
struct Three {
  S x, y, z;
  static Three zero() { return {S{}, S{}, S{}}; }
};

/// Three columns of each.
template <typename S>
struct ThreeByThree {
  Three<S> x, y, z;
  static ThreeByThree zero() { return {Three<S>::zero(), Three<S>::zero(), Three<S>::zero()}; }
};

using Four3 = Three<Four>;
using Four33 = ThreeByThree<Four>;

using lamprey::operator+;  // those of matrices, which the following would hide
using lamprey::operator-;
using lamprey::operator*;
template <typename S>
inline Three<S> operator+(const Three<S>& u, const Three<S>& v) {
  return {u.x + v.x, u.y + v.y, u.z + v.z};
}
template <typename S>
inline Three<S> operator-(const Three<S>& u, const Three<S>& v) {
  return {u.x - v.x, u.y - v.y, u.z - v.z};
}
template <typename S>
inline Three<S> operator-(const Three<S>& v) {
  return {-v.x, -v.y, -v.z};
}
template <typename S>
inline Three<S> operator*(double s, const Three<S>& v) {
  return {s * v.x, s * v.y, s * v.z};
}
template <typename S>
inline Three<S> operator*(const S& s, const Three<S>& v) {
  return {s * v.x, s * v.y, s * v.z};
}
template <typename S>
inline Three<S>& operator+=(Three<S>& u, const Three<S>& v) {
  return u = u + v;
}
template <typename S>
inline Three<S>& operator-=(Three<S>& u, const Three<S>& v) {
  return u = u - v;
}
template <typename S>
inline Three<S>& operator*=(Three<S>& v, double s) {
  return v = s * v;
}
template <typename S>
inline S dot(const Three<S>& u, const Three<S>& v) {
  return u.x * v.x + u.y * v.y + u.z * v.z;
}
template <typename S>
inline Three<S> cross(const Three<S>& u, const Three<S>& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
/// s v.
template <typename S>
inline Three<S> along(double s, const Three<S>& v) {
  return s * v;
}
template <typename S>
inline Three<S> along(const S& s, const Three<S>& v) {
  return s * v;
}

template <typename S>
inline ThreeByThree<S> operator+(const ThreeByThree<S>& A, const ThreeByThree<S>& B) {
  return {A.x + B.x, A.y + B.y, A.z + B.z};
}
template <typename S>
inline ThreeByThree<S> operator-(const ThreeByThree<S>& A, const ThreeByThree<S>& B) {
  return {A.x - B.x, A.y - B.y, A.z - B.z};
}
template <typename S>
inline ThreeByThree<S> operator*(double s, const ThreeByThree<S>& A) {
  return {s * A.x, s * A.y, s * A.z};
}
template <typename S>
inline ThreeByThree<S> operator*(const S& s, const ThreeByThree<S>& A) {
  return {s * A.x, s * A.y, s * A.z};
}
template <typename S>
inline ThreeByThree<S>& operator+=(ThreeByThree<S>& A, const ThreeByThree<S>& B) {
  return A = A + B;
}
template <typename S>
inline ThreeByThree<S>& operator*=(ThreeByThree<S>& A, double s) {
  return A = s * A;
}
template <typename S>
inline Three<S> operator*(const ThreeByThree<S>& A, const Three<S>& v) {
  return {A.x.x * v.x + A.y.x * v.y + A.z.x * v.z, A.x.y * v.x + A.y.y * v.y + A.z.y * v.z,
          A.x.z * v.x + A.y.z * v.y + A.z.z * v.z};
}
template <typename S>
inline ThreeByThree<S> operator*(const ThreeByThree<S>& A, const ThreeByThree<S>& B) {
  return {A * B.x, A * B.y, A * B.z};
}
template <typename S>
inline ThreeByThree<S> transposed(const ThreeByThree<S>& A) {
  return {{A.x.x, A.y.x, A.z.x}, {A.x.y, A.y.y, A.z.y}, {A.x.z, A.y.z, A.z.z}};
}
template <typename S>
inline S trace(const ThreeByThree<S>& A) {
  return A.x.x + A.y.y + A.z.z;
}
/// A − s I.
template <typename S>
inline ThreeByThree<S> minus_diagonal(const ThreeByThree<S>& A, const S& s) {
  return {{A.x.x - s, A.x.y, A.x.z}, {A.y.x, A.y.y - s, A.y.z}, {A.z.x, A.z.y, A.z.z - s}};
}
template <typename S>
inline ThreeByThree<S> plus_identity(const ThreeByThree<S>& A) {
  return {{A.x.x + 1.0, A.x.y, A.x.z}, {A.y.x, A.y.y + 1.0, A.y.z}, {A.z.x, A.z.y, A.z.z + 1.0}};
}
/// u vᵀ.
template <typename S>
inline ThreeByThree<S> dyad(const Three<S>& u, const Three<S>& v) {
  return {v.x * u, v.y * u, v.z * u};
}
/// v̂ A.
template <typename S>
inline ThreeByThree<S> hat_times(const Three<S>& v, const ThreeByThree<S>& A) {
  return {cross(v, A.x), cross(v, A.y), cross(v, A.z)};
}
/// A v̂.
template <typename S>
inline ThreeByThree<S> times_hat(const ThreeByThree<S>& A, const Three<S>& v) {
  return {v.z * A.y - v.y * A.z, v.x * A.z - v.z * A.x, v.y * A.x - v.x * A.y};
}
/// A + v̂.
template <typename S>
inline ThreeByThree<S> plus_hat(const ThreeByThree<S>& A, const Three<S>& v) {
  return {{A.x.x, A.x.y + v.z, A.x.z - v.y}, {A.y.x - v.z, A.y.y, A.y.z + v.x}, {A.z.x + v.y, A.z.y - v.x, A.z.z}};
}

/// With a constant matrix or vector of all.
template <typename S>
inline Three<S> operator*(const Eigen::Matrix3d& A, const Three<S>& v) {
  return {A(0, 0) * v.x + A(0, 1) * v.y + A(0, 2) * v.z, A(1, 0) * v.x + A(1, 1) * v.y + A(1, 2) * v.z,
          A(2, 0) * v.x + A(2, 1) * v.y + A(2, 2) * v.z};
}
template <typename S>
inline ThreeByThree<S> operator*(const Eigen::Matrix3d& A, const ThreeByThree<S>& B) {
  return {A * B.x, A * B.y, A * B.z};
}
template <typename S>
inline Three<S> operator*(const ThreeByThree<S>& A, const Eigen::Vector3d& v) {
  return {v[0] * A.x.x + v[1] * A.y.x + v[2] * A.z.x, v[0] * A.x.y + v[1] * A.y.y + v[2] * A.z.y,
          v[0] * A.x.z + v[1] * A.y.z + v[2] * A.z.z};
}
template <typename S>
inline S dot(const Eigen::Vector3d& u, const Three<S>& v) {
  return u[0] * v.x + u[1] * v.y + u[2] * v.z;
}
template <typename S>
inline Three<S> cross(const Eigen::Vector3d& u, const Three<S>& v) {
  return {u[1] * v.z - u[2] * v.y, u[2] * v.x - u[0] * v.z, u[0] * v.y - u[1] * v.x};
}
template <typename S>
inline Three<S> cross(const Three<S>& u, const Eigen::Vector3d& v) {
  return {u.y * v[2] - u.z * v[1], u.z * v[0] - u.x * v[2], u.x * v[1] - u.y * v[0]};
}
template <typename S>
inline ThreeByThree<S> hat_times(const Eigen::Vector3d& v, const ThreeByThree<S>& A) {
  return {cross(v, A.x), cross(v, A.y), cross(v, A.z)};
}
template <typename S>
inline ThreeByThree<S> times_hat(const ThreeByThree<S>& A, const Eigen::Vector3d& v) {
  return {v[2] * A.y - v[1] * A.z, v[0] * A.z - v[2] * A.x, v[1] * A.x - v[0] * A.y};
}
template <typename S>
inline ThreeByThree<S> operator*(const ThreeByThree<S>& A, const Eigen::Matrix3d& B) {
  return {A * Eigen::Vector3d(B.col(0)), A * Eigen::Vector3d(B.col(1)), A * Eigen::Vector3d(B.col(2))};
}
template <typename S>
inline ThreeByThree<S> times_hat(const Eigen::Matrix3d& A, const Three<S>& v) {
  const auto column = [&](int p, const S& a, int q, const S& b) {
    return Three<S>{A(0, p) * a - A(0, q) * b, A(1, p) * a - A(1, q) * b, A(2, p) * a - A(2, q) * b};
  };
  return {column(1, v.z, 2, v.y), column(2, v.x, 0, v.z), column(0, v.y, 1, v.x)};
}
/// Twice the vector of the skew part.
template <typename S>
inline Three<S> vee_twice(const ThreeByThree<S>& A) {
  return {A.y.z - A.z.y, A.z.x - A.x.z, A.x.y - A.y.x};
}
inline Four33 symmetric_part(const Four33& A) { return 0.5 * (A + transposed(A)); }
inline Four33 inverse(const Four33& A) {
  const Four3 yz = cross(A.y, A.z), zx = cross(A.z, A.x), xy = cross(A.x, A.y);
  return (1.0 / dot(A.x, yz)) * transposed(Four33{yz, zx, xy});
}
/// ½ (u vᵀ + v uᵀ) − (u·v) I: second derivative of u·exp(θ̂)v.
inline Four33 second_turn(const Four3& u, const Four3& v) {
  return minus_diagonal(symmetric_part(dyad(u, v)), dot(u, v));
}
/// u vᵀ − (u·v) I.
template <typename S>
inline ThreeByThree<S> dyad_less_dot(const Three<S>& u, const Eigen::Vector3d& v) {
  return minus_diagonal(ThreeByThree<S>{v[0] * u, v[1] * u, v[2] * u}, dot(v, u));
}

}  // namespace lamprey::mechanics
