// One direction, a Vector3d, or four at once, a Four3: what formulas need that are linear in it and written once for both.
#pragma once

#include <Eigen/Core>

#include "lie/so3.hpp"
#include "mechanics/four3.hpp"

namespace lamprey::mechanics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <typename V>
V zero_direction();
template <>
inline Vector3d zero_direction<Vector3d>() {
  return Vector3d::Zero();
}
template <>
inline Four3 zero_direction<Four3>() {
  return Four3::zero();
}

inline double dot(const Vector3d& u, const Vector3d& v) { return u.dot(v); }
inline Vector3d cross(const Vector3d& u, const Vector3d& v) { return u.cross(v); }
/// s v.
inline Vector3d along(double s, const Vector3d& v) { return s * v; }

inline Matrix3d transposed(const Matrix3d& A) { return A.transpose(); }
inline double trace(const Matrix3d& A) { return A.trace(); }
inline Matrix3d times_hat(const Matrix3d& A, const Vector3d& v) { return lie::times_hat(A, v); }
inline Matrix3d hat_times(const Vector3d& v, const Matrix3d& A) { return lie::hat(v) * A; }
inline Matrix3d dyad(const Vector3d& u, const Vector3d& v) { return u * v.transpose(); }
inline Matrix3d minus_diagonal(const Matrix3d& A, double s) { return A - s * Matrix3d::Identity(); }

inline Four3 along(const Four& s, const Vector3d& v) { return {s * v[0], s * v[1], s * v[2]}; }

/// Three directions, the columns of A, and a zero one.
inline Four3 columns(const Matrix3d& A) {
  return {Four{A(0, 0), A(0, 1), A(0, 2), 0.0}, Four{A(1, 0), A(1, 1), A(1, 2), 0.0},
          Four{A(2, 0), A(2, 1), A(2, 2), 0.0}};
}

/// Back from `columns`.
inline void read_columns(const Four3& v, Matrix3d& A) {
  for (int c = 0; c < 3; ++c) A.col(c) = Vector3d(v.x[c], v.y[c], v.z[c]);
}

}  // namespace lamprey::mechanics
