#include "algebra/tiles.hpp"

#include <algorithm>

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

}  // namespace lamprey::algebra
