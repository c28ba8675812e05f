// Three numbers for each of many directions: the operations that run over all directions at once.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "mechanics/four3.hpp"

namespace lamprey::mechanics {

/// [rows_for(directions)][3]: one vector for each direction; spare rows hold 0 or what comes of 0.
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;
/// [bodies] along each body's freedoms, one row for each direction; columns beyond a body's freedoms are 0.
using FreedomRows = std::vector<Rows3>;

/// Rows to allocate for so many directions: the operations below work on four at a time.
constexpr Eigen::Index rows_for(Eigen::Index directions) { return (directions + 3) / 4 * 4; }

/// Rows first … end − 1, and those up to the next multiple of four; `first` is one.
struct RowRange {
  Eigen::Index first, end;
  RowRange(Eigen::Index count) : first(0), end(count) {}
  RowRange(Eigen::Index first_, Eigen::Index end_) : first(first_), end(end_) {}
};

/// Where rows may differ from zero: three that are an identity, from `unit` on (none where it is negative), and `others`.
struct Support {
  Eigen::Index unit = -1;
  RowRange others{std::numeric_limits<Eigen::Index>::max()};
};

/// Rows that are zero but on their support. `others` may begin anywhere if the matrix holds the last four that begin there.
struct SparseRows {
  Rows3 rows;
  Support support;
  RowRange others(RowRange range) const {
    return {std::max(range.first, support.others.first), std::min(range.end, support.others.end)};
  }
};

inline Four row_part(const Rows3& rows, Eigen::Index first, int column) {
  return algebra::load<Four>(rows.data() + column * rows.rows() + first);
}

/// Three numbers for the four directions from `first` on.
inline Four3 four_rows(const Rows3& rows, Eigen::Index first) {
  return {row_part(rows, first, 0), row_part(rows, first, 1), row_part(rows, first, 2)};
}

/// y = A x; x and y the same or not.
inline void set_product(const Eigen::Matrix3d& A, const Rows3& x, RowRange range, Rows3& y) {
  const Eigen::Matrix3d a = A;  // NOLINT(performance-unnecessary-copy-initialization): y may lie where A does
  double* to = y.data();
  const Eigen::Index rows = y.rows();
  for (Eigen::Index r = range.first; r < range.end; r += 4) {
    const Four3 v = four_rows(x, r);
    for (int c = 0; c < 3; ++c) algebra::store(a(c, 0) * v.x + a(c, 1) * v.y + a(c, 2) * v.z, to + c * rows + r);
  }
}

/// y += A x, likewise.
inline void add_product(const Eigen::Matrix3d& A, const Rows3& x, RowRange range, Rows3& y) {
  const Eigen::Matrix3d a = A;  // NOLINT(performance-unnecessary-copy-initialization): y may lie where A does
  double* to = y.data();
  const Eigen::Index rows = y.rows();
  for (Eigen::Index r = range.first; r < range.end; r += 4) {
    const Four3 v = four_rows(x, r);
    for (int c = 0; c < 3; ++c) {
      double* sum = to + c * rows + r;
      algebra::store(algebra::load<Four>(sum) + (a(c, 0) * v.x + a(c, 1) * v.y + a(c, 2) * v.z), sum);
    }
  }
}

inline void add_product(const Eigen::Matrix3d& A, const SparseRows& x, RowRange range, Rows3& y) {
  if (const Eigen::Index unit = x.support.unit; unit >= 0)
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) y(unit + r, c) += A(c, r);
  add_product(A, x.rows, x.others(range), y);
}

/// y += factor x, likewise.
inline void add_rows(double factor, const Rows3& x, RowRange range, Rows3& y) {
  for (int c = 0; c < 3; ++c)
    for (Eigen::Index r = range.first; r < range.end; r += 4)
      algebra::store(row_part(y, r, c) + factor * row_part(x, r, c), y.data() + c * y.rows() + r);
}

/// y = x, likewise.
inline void copy_rows(const Rows3& x, RowRange range, Rows3& y) {
  for (int c = 0; c < 3; ++c)
    for (Eigen::Index r = range.first; r < range.end; r += 4)
      algebra::store(row_part(x, r, c), y.data() + c * y.rows() + r);
}

/// y = 0, likewise.
inline void clear_rows(RowRange range, Rows3& y) {
  for (int c = 0; c < 3; ++c)
    for (Eigen::Index r = range.first; r < range.end; r += 4) algebra::store(Four{}, y.data() + c * y.rows() + r);
}

}  // namespace lamprey::mechanics
