#include "algebra/tiles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "algebra/four.hpp"

namespace lamprey::algebra {

namespace {

// `height` rows and `width` columns of the product, kept in registers along the sum: as fours, a pair and a single one.
template <int height, int width>
void add_tile(double factor, Index depth, const double* a, Index a_stride, Strided b, double* c, Index c_stride) {
  constexpr int fours = height / 4, pair = height % 4 / 2, single = height % 2;
  Four four[width][fours > 0 ? fours : 1];
  Two two[width];
  double one[width];
  for (int j = 0; j < width; ++j) {
    for (int f = 0; f < fours; ++f) four[j][f] = Four{};
    two[j] = Two{};
    one[j] = 0.0;
  }
  for (Index p = 0; p < depth; ++p) {
    const double* left = a + p * a_stride;
    const double* right = b.data + p * b.row;
    Four left_four[fours > 0 ? fours : 1];
    for (int f = 0; f < fours; ++f) left_four[f] = load<Four>(left + 4 * f);
    Two left_two{};
    if constexpr (pair == 1) left_two = load<Two>(left + 4 * fours);
    for (int j = 0; j < width; ++j) {
      const double entry = right[j * b.column];
      for (int f = 0; f < fours; ++f) four[j][f] += left_four[f] * entry;
      if constexpr (pair == 1) two[j] += left_two * entry;
      if constexpr (single == 1) one[j] += left[height - 1] * entry;
    }
  }
  for (int j = 0; j < width; ++j) {
    double* to = c + j * c_stride;
    for (int f = 0; f < fours; ++f) store(load<Four>(to + 4 * f) + factor * four[j][f], to + 4 * f);
    if constexpr (pair == 1) store(load<Two>(to + 4 * fours) + factor * two[j], to + 4 * fours);
    if constexpr (single == 1) to[height - 1] += factor * one[j];
  }
}

template <int width>
void add_columns(double factor, Index rows, Index depth, const double* a, Index a_stride, Strided b, double* c,
                 Index c_stride) {
  for (; rows >= 12; rows -= 12, a += 12, c += 12) add_tile<12, width>(factor, depth, a, a_stride, b, c, c_stride);
  using Tile = void (*)(double, Index, const double*, Index, Strided, double*, Index);
  static constexpr Tile rest[] = {add_tile<1, width>, add_tile<2, width>,  add_tile<3, width>, add_tile<4, width>,
                                  add_tile<5, width>, add_tile<6, width>,  add_tile<7, width>, add_tile<8, width>,
                                  add_tile<9, width>, add_tile<10, width>, add_tile<11, width>};
  if (rows > 0) rest[rows - 1](factor, depth, a, a_stride, b, c, c_stride);
}

// From each of `columns` its entry k times `factors` goes, and that entry is scaled.
template <int fours>
void eliminate_fours(const double* factors, double inverse, Index k, Index columns, double* to, Index stride) {
  Four share[fours];
  for (int f = 0; f < fours; ++f) share[f] = load<Four>(factors + 4 * f);
  for (Index c = 0; c < columns; ++c, to += stride) {
    const double entry = to[k] * inverse;
    for (int f = 0; f < fours; ++f) store(load<Four>(to + 4 * f) - entry * share[f], to + 4 * f);
    to[k] = entry;
  }
}

// Four rows of it after the other.
void eliminate_many(const double* factors, double inverse, Index k, Index columns, double* to, Index stride,
                    Index fours) {
  for (Index c = 0; c < columns; ++c, to += stride) {
    const double entry = to[k] * inverse;
    for (Index f = 0; f < fours; ++f) store(load<Four>(to + 4 * f) - entry * load<Four>(factors + 4 * f), to + 4 * f);
    to[k] = entry;
  }
}

}  // namespace

void add_tiled(double factor, const Tiled& A, const Strided& B, Index columns, double* C, Index stride, bool lower) {
  using Columns = void (*)(double, Index, Index, const double*, Index, Strided, double*, Index);
  static constexpr Columns of_width[] = {add_columns<1>, add_columns<2>, add_columns<3>, add_columns<4>};
  for (Index j = 0; j < columns; j += 4) {
    const Index skipped = lower ? j : 0;
    of_width[std::min<Index>(columns - j, 4) - 1](factor, A.rows - skipped, A.columns, A.data + skipped, A.stride,
                                                  {B.data + j * B.column, B.row, B.column}, C + j * stride + skipped,
                                                  stride);
  }
}

void solve_columns(Index unknowns, Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>> equations) {
  using Eliminate = void (*)(const double*, double, Index, Index, double*, Index);
  static constexpr Eliminate of_fours[] = {eliminate_fours<1>, eliminate_fours<2>, eliminate_fours<3>,
                                           eliminate_fours<4>, eliminate_fours<5>, eliminate_fours<6>};
  const Index fours = (unknowns + 3) / 4, stride = equations.outerStride();
  eigen_assert(equations.rows() >= 4 * fours);
  for (Index k = 0; k < unknowns; ++k) {
    double* column = equations.data() + k * stride;
    Index pivot = k;
    double largest = std::abs(column[k]);
    for (Index i = k + 1; i < unknowns; ++i)
      if (const double size = std::abs(column[i]); size > largest) pivot = i, largest = size;
    if (pivot != k)
      for (Index c = k; c < equations.cols(); ++c) std::swap(equations(k, c), equations(pivot, c));
    const double inverse = 1.0 / column[k];
    column[k] = 0.0;  // what is left of the column: how much of row k each other row has
    const Index rest = equations.cols() - k - 1;
    if (fours <= 6)
      of_fours[fours - 1](column, inverse, k, rest, column + stride, stride);
    else
      eliminate_many(column, inverse, k, rest, column + stride, stride, fours);
  }
}

}  // namespace lamprey::algebra
