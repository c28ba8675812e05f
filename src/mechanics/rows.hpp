// Three numbers for each of many directions: the operations that run over all directions at once.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

namespace lamprey::mechanics {

/// [directions][3]: one vector for each direction.
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;
/// [bodies] along each body's freedoms, one row for each direction; columns beyond a body's freedoms are 0.
using FreedomRows = std::vector<Rows3>;

/// y += A x for the first `count` rows x and y, which must not be the same.
inline void add_product(const Eigen::Matrix3d& A, const Rows3& x, Eigen::Index count, Rows3& y) {
  const double* __restrict x0 = x.col(0).data();
  const double* __restrict x1 = x.col(1).data();
  const double* __restrict x2 = x.col(2).data();
  double* __restrict y0 = y.col(0).data();
  double* __restrict y1 = y.col(1).data();
  double* __restrict y2 = y.col(2).data();
  const double a00 = A(0, 0), a01 = A(0, 1), a02 = A(0, 2);
  const double a10 = A(1, 0), a11 = A(1, 1), a12 = A(1, 2);
  const double a20 = A(2, 0), a21 = A(2, 1), a22 = A(2, 2);
  for (Eigen::Index r = 0; r < count; ++r) {
    y0[r] += a00 * x0[r] + a01 * x1[r] + a02 * x2[r];
    y1[r] += a10 * x0[r] + a11 * x1[r] + a12 * x2[r];
    y2[r] += a20 * x0[r] + a21 * x1[r] + a22 * x2[r];
  }
}

/// y = A x, x and y the same or not.
inline void set_product(const Eigen::Matrix3d& A, const Rows3& x, Eigen::Index count, Rows3& y) {
  const double* x0 = x.col(0).data();
  const double* x1 = x.col(1).data();
  const double* x2 = x.col(2).data();
  double* y0 = y.col(0).data();
  double* y1 = y.col(1).data();
  double* y2 = y.col(2).data();
  const double a00 = A(0, 0), a01 = A(0, 1), a02 = A(0, 2);
  const double a10 = A(1, 0), a11 = A(1, 1), a12 = A(1, 2);
  const double a20 = A(2, 0), a21 = A(2, 1), a22 = A(2, 2);
  for (Eigen::Index r = 0; r < count; ++r) {
    const double u0 = x0[r], u1 = x1[r], u2 = x2[r];
    y0[r] = a00 * u0 + a01 * u1 + a02 * u2;
    y1[r] = a10 * u0 + a11 * u1 + a12 * u2;
    y2[r] = a20 * u0 + a21 * u1 + a22 * u2;
  }
}

/// y += factor x.
inline void add_rows(double factor, const Rows3& x, Eigen::Index count, Rows3& y) {
  for (int c = 0; c < 3; ++c) {
    const double* __restrict from = x.col(c).data();
    double* __restrict to = y.col(c).data();
    for (Eigen::Index r = 0; r < count; ++r) to[r] += factor * from[r];
  }
}

/// y = x.
inline void copy_rows(const Rows3& x, Eigen::Index count, Rows3& y) {
  for (int c = 0; c < 3; ++c) std::copy_n(x.col(c).data(), count, y.col(c).data());
}

/// y = 0.
inline void clear_rows(Eigen::Index count, Rows3& y) {
  for (int c = 0; c < 3; ++c) std::fill_n(y.col(c).data(), count, 0.0);
}

}  // namespace lamprey::mechanics
