// Vectors and 3×3 matrices of four at once, of four directions or of four bodies: entry by entry.
#pragma once

#include "algebra/four.hpp"

namespace lamprey::mechanics {

using algebra::Four;

/// Three numbers of each.
struct Four3 {
  Four x, y, z;
  static Four3 zero() { return {Four{}, Four{}, Four{}}; }
};

/// Three columns of each.
struct Four33 {
  Four3 x, y, z;
};

using lamprey::operator+;  // those of matrices, which the following would hide
using lamprey::operator-;
using lamprey::operator*;
inline Four3 operator+(const Four3& u, const Four3& v) { return {u.x + v.x, u.y + v.y, u.z + v.z}; }
inline Four3 operator-(const Four3& u, const Four3& v) { return {u.x - v.x, u.y - v.y, u.z - v.z}; }
inline Four3 operator-(const Four3& v) { return {-v.x, -v.y, -v.z}; }
inline Four3 operator*(double s, const Four3& v) { return {s * v.x, s * v.y, s * v.z}; }
inline Four3 operator*(const Four& s, const Four3& v) { return {s * v.x, s * v.y, s * v.z}; }
inline Four3& operator+=(Four3& u, const Four3& v) { return u = u + v; }
inline Four3& operator-=(Four3& u, const Four3& v) { return u = u - v; }
inline Four3& operator*=(Four3& v, double s) { return v = s * v; }
inline Four dot(const Four3& u, const Four3& v) { return u.x * v.x + u.y * v.y + u.z * v.z; }
inline Four3 cross(const Four3& u, const Four3& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
/// s v.
inline Four3 along(double s, const Four3& v) { return s * v; }
inline Four3 along(const Four& s, const Four3& v) { return s * v; }

inline Four33 operator+(const Four33& A, const Four33& B) { return {A.x + B.x, A.y + B.y, A.z + B.z}; }
inline Four33 operator-(const Four33& A, const Four33& B) { return {A.x - B.x, A.y - B.y, A.z - B.z}; }
inline Four33 operator*(double s, const Four33& A) { return {s * A.x, s * A.y, s * A.z}; }
inline Four33 operator*(const Four& s, const Four33& A) { return {s * A.x, s * A.y, s * A.z}; }
inline Four33& operator+=(Four33& A, const Four33& B) { return A = A + B; }
inline Four33& operator*=(Four33& A, double s) { return A = s * A; }
inline Four3 operator*(const Four33& A, const Four3& v) {
  return {A.x.x * v.x + A.y.x * v.y + A.z.x * v.z, A.x.y * v.x + A.y.y * v.y + A.z.y * v.z,
          A.x.z * v.x + A.y.z * v.y + A.z.z * v.z};
}
inline Four33 operator*(const Four33& A, const Four33& B) { return {A * B.x, A * B.y, A * B.z}; }
inline Four33 transposed(const Four33& A) {
  return {{A.x.x, A.y.x, A.z.x}, {A.x.y, A.y.y, A.z.y}, {A.x.z, A.y.z, A.z.z}};
}
inline Four trace(const Four33& A) { return A.x.x + A.y.y + A.z.z; }
/// A − s I.
inline Four33 minus_diagonal(const Four33& A, const Four& s) {
  return {{A.x.x - s, A.x.y, A.x.z}, {A.y.x, A.y.y - s, A.y.z}, {A.z.x, A.z.y, A.z.z - s}};
}
inline Four33 plus_identity(const Four33& A) {
  return {{A.x.x + 1.0, A.x.y, A.x.z}, {A.y.x, A.y.y + 1.0, A.y.z}, {A.z.x, A.z.y, A.z.z + 1.0}};
}
/// u vᵀ.
inline Four33 dyad(const Four3& u, const Four3& v) { return {v.x * u, v.y * u, v.z * u}; }
/// v̂ A.
inline Four33 hat_times(const Four3& v, const Four33& A) { return {cross(v, A.x), cross(v, A.y), cross(v, A.z)}; }
/// A v̂.
inline Four33 times_hat(const Four33& A, const Four3& v) {
  return {v.z * A.y - v.y * A.z, v.x * A.z - v.z * A.x, v.y * A.x - v.x * A.y};
}
/// A + v̂.
inline Four33 plus_hat(const Four33& A, const Four3& v) {
  return {{A.x.x, A.x.y + v.z, A.x.z - v.y}, {A.y.x - v.z, A.y.y, A.y.z + v.x}, {A.z.x + v.y, A.z.y - v.x, A.z.z}};
}

}  // namespace lamprey::mechanics
