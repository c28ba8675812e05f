#include "optimizer/small_dense.hpp"

#include <algorithm>
#include <cmath>

#include "algebra/four.hpp"

namespace lamprey::optimizer {

namespace {

using algebra::Four;
using algebra::load;
using algebra::store;
using algebra::Two;

// Entries of a matrix wherever they lie.
struct Strided {
  const double* data;
  Eigen::Index row, column;  // strides
};

Strided plain(const MatrixIn& m) { return {m.data(), 1, m.outerStride()}; }
Strided transposed(const MatrixIn& m) { return {m.data(), m.outerStride(), 1}; }

// `height` rows and `width` columns of the product, kept in registers along the sum: as fours, a pair and a single one.
template <int height, int width>
void add_tile(double factor, Eigen::Index depth, const double* a, Eigen::Index a_stride, Strided b, double* c,
              Eigen::Index c_stride) {
  constexpr int fours = height / 4, pair = height % 4 / 2, single = height % 2;
  Four four[width][fours > 0 ? fours : 1];
  Two two[width];
  double one[width];
  for (int j = 0; j < width; ++j) {
    for (int f = 0; f < fours; ++f) four[j][f] = Four{};
    two[j] = Two{};
    one[j] = 0.0;
  }
  for (Eigen::Index p = 0; p < depth; ++p) {
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
void add_columns(double factor, Eigen::Index rows, Eigen::Index depth, const double* a, Eigen::Index a_stride,
                 Strided b, double* c, Eigen::Index c_stride) {
  for (; rows >= 12; rows -= 12, a += 12, c += 12) add_tile<12, width>(factor, depth, a, a_stride, b, c, c_stride);
  using Tile = void (*)(double, Eigen::Index, const double*, Eigen::Index, Strided, double*, Eigen::Index);
  static constexpr Tile rest[] = {add_tile<1, width>, add_tile<2, width>,  add_tile<3, width>, add_tile<4, width>,
                                  add_tile<5, width>, add_tile<6, width>,  add_tile<7, width>, add_tile<8, width>,
                                  add_tile<9, width>, add_tile<10, width>, add_tile<11, width>};
  if (rows > 0) rest[rows - 1](factor, depth, a, a_stride, b, c, c_stride);
}

void add_strided(double factor, const MatrixIn& A, Strided b, MatrixOut& C, bool lower) {
  const Eigen::Index depth = A.cols(), stride = A.outerStride(), c_stride = C.outerStride(), columns = C.cols();
  using Columns =
      void (*)(double, Eigen::Index, Eigen::Index, const double*, Eigen::Index, Strided, double*, Eigen::Index);
  static constexpr Columns of_width[] = {add_columns<1>, add_columns<2>, add_columns<3>, add_columns<4>};
  for (Eigen::Index j = 0; j < columns; j += 4) {
    const Eigen::Index skipped = lower ? j : 0;
    of_width[std::min<Eigen::Index>(columns - j, 4) - 1](factor, C.rows() - skipped, depth, A.data() + skipped, stride,
                                                         {b.data + j * b.column, b.row, b.column},
                                                         C.data() + j * c_stride + skipped, c_stride);
  }
}

}  // namespace

void add_product(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, plain(B), C, false);
}

void add_product_transposed(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, transposed(B), C, false);
}

void add_lower_product(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, plain(B), C, true);
}

void add_lower_product_transposed(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, transposed(B), C, true);
}

void set_transposed(const MatrixIn& A, MatrixOut C) {
  const Eigen::Index stride = A.outerStride(), c_stride = C.outerStride(), rows = A.rows();
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const double* from = A.data() + j * stride;
    double* to = C.data() + j;
    for (Eigen::Index i = 0; i < rows; ++i) to[i * c_stride] = from[i];
  }
}

void mirror_lower(MatrixOut C) {
  double* c = C.data();
  const Eigen::Index stride = C.outerStride();
  for (Eigen::Index j = 0; j < C.cols(); ++j)
    for (Eigen::Index i = j + 1; i < C.rows(); ++i) c[i * stride + j] = c[j * stride + i];
}

void add_image(double factor, const MatrixIn& A, const VectorIn& x, VectorOut y) {
  const Strided b{x.data(), 1, A.cols()};
  add_columns<1>(factor, A.rows(), A.cols(), A.data(), A.outerStride(), b, y.data(), y.size());
}

void add_transposed_image(double factor, const MatrixIn& A, const VectorIn& x, VectorOut y) {
  const Eigen::Index rows = A.rows(), stride = A.outerStride();
  const double* v = x.data();
  double* to = y.data();
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const double* a = A.data() + j * stride;
    Four sum{};
    Eigen::Index i = 0;
    for (; i + 4 <= rows; i += 4) sum += load<Four>(a + i) * load<Four>(v + i);
    double rest = algebra::sum(sum);
    for (; i < rows; ++i) rest += a[i] * v[i];
    to[j] += factor * rest;
  }
}

void solve_equations(MatrixOut equations) {
  const Eigen::Index unknowns = equations.cols(), length = equations.rows();
  double* e = equations.data();
  const Eigen::Index stride = equations.outerStride();
  const auto column = [&](Eigen::Index i) { return e + i * stride; };
  const auto subtract = [&](double factor, const double* from, double* to, Eigen::Index first) {
    Eigen::Index i = first;
    for (; i + 4 <= length; i += 4) store(load<Four>(to + i) - factor * load<Four>(from + i), to + i);
    for (; i < length; ++i) to[i] -= factor * from[i];
  };
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k + 1; i < unknowns; ++i)
      if (std::abs(column(i)[k]) > std::abs(column(pivot)[k])) pivot = i;
    if (pivot != k) std::swap_ranges(column(k) + k, column(k) + length, column(pivot) + k);
    const double inverse = 1.0 / column(k)[k];
    for (Eigen::Index i = k + 1; i < unknowns; ++i) subtract(inverse * column(i)[k], column(k), column(i), k + 1);
  }
  for (Eigen::Index k = unknowns - 1; k >= 0; --k) {
    const double inverse = 1.0 / column(k)[k];
    for (Eigen::Index i = unknowns; i < length; ++i) column(k)[i] *= inverse;
    for (Eigen::Index i = 0; i < k; ++i) subtract(column(i)[k], column(k), column(i), unknowns);
  }
}

}  // namespace lamprey::optimizer
