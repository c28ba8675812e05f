#include "optimizer/placed_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "algebra/four.hpp"

namespace lamprey::optimizer {

namespace {

using algebra::Four;
using algebra::load;
using algebra::store;
using Eigen::Index;

constexpr Index in_fours(Index rows) { return (rows + 3) / 4; }

// Where entries of the matrices of a product C += A B lie: C and A column after column.
template <int of_c, int of_a, int rows_of_b, int columns_of_b>
struct Strides {
  static constexpr int c = of_c, a = of_a;
  static constexpr int b_row = rows_of_b, b_column = columns_of_b;  // from one to the next
};

// `fours` times four rows and `width` columns of C += sign A B.
template <int fours, int width, int depth, int sign, typename Stride>
inline void add_tile(const double* a, const double* b, double* c) {
  Four sum[width][fours];
#pragma GCC unroll 8
  for (int j = 0; j < width; ++j)
#pragma GCC unroll 8
    for (int f = 0; f < fours; ++f) sum[j][f] = load<Four>(c + j * Stride::c + 4 * f);
#pragma GCC unroll 16
  for (int p = 0; p < depth; ++p) {
    Four left[fours];
#pragma GCC unroll 8
    for (int f = 0; f < fours; ++f) left[f] = load<Four>(a + p * Stride::a + 4 * f);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) {
      const double entry = b[p * Stride::b_row + j * Stride::b_column];
#pragma GCC unroll 8
      for (int f = 0; f < fours; ++f)
        if constexpr (sign > 0)
          sum[j][f] += left[f] * entry;
        else
          sum[j][f] -= left[f] * entry;
    }
  }
#pragma GCC unroll 8
  for (int j = 0; j < width; ++j)
#pragma GCC unroll 8
    for (int f = 0; f < fours; ++f) store(sum[j][f], c + j * Stride::c + 4 * f);
}

template <int width, int depth, int sign, typename Stride>
inline void add_columns(Index fours, const double* a, const double* b, double* c) {
  for (; fours >= 3; fours -= 3, a += 12, c += 12) add_tile<3, width, depth, sign, Stride>(a, b, c);
  if (fours == 2) add_tile<2, width, depth, sign, Stride>(a, b, c);
  if (fours == 1) add_tile<1, width, depth, sign, Stride>(a, b, c);
}

// C += A B, of whole fours of rows.
template <int columns, int depth, typename Stride>
inline void add_product(Index fours, const double* a, const double* b, double* c) {
  constexpr int left_over = columns % 4;
  for (int j = 0; j + 4 <= columns; j += 4, b += 4 * Stride::b_column, c += 4 * Stride::c)
    add_columns<4, depth, 1, Stride>(fours, a, b, c);
  if constexpr (left_over > 0) add_columns<left_over, depth, 1, Stride>(fours, a, b, c);
}

// C −= A B, but of what is above the diagonal only parts.
template <int columns, int depth, typename Stride>
inline void subtract_lower_product(Index fours, const double* a, const double* b, double* c) {
  constexpr int left_over = columns % 4;
  int j = 0;
  for (; j + 4 <= columns; j += 4, --fours, a += 4, b += 4 * Stride::b_column, c += 4 * Stride::c + 4)
    add_columns<4, depth, -1, Stride>(fours, a, b, c);
  if constexpr (left_over > 0) add_columns<left_over, depth, -1, Stride>(fours, a, b, c);
}

// Four rows Y become Y L⁻ᵀ, L's diagonal being given by its inverse.
template <int shape, int stride, int stride_of_L>
inline void divide_by_transposed(const double* L, double* y) {
  Four row[shape];
#pragma GCC unroll 16
  for (int c = 0; c < shape; ++c) {
    row[c] = load<Four>(y + c * stride);
#pragma GCC unroll 16
    for (int k = 0; k < c; ++k) row[c] -= row[k] * L[c + k * stride_of_L];
    row[c] *= L[c + c * stride_of_L];
    store(row[c], y + c * stride);
  }
}

// And Y L⁻¹.
template <int shape, int stride, int stride_of_L>
inline void divide(const double* L, double* y) {
  Four row[shape];
#pragma GCC unroll 16
  for (int c = shape - 1; c >= 0; --c) {
    row[c] = load<Four>(y + c * stride);
#pragma GCC unroll 16
    for (int k = c + 1; k < shape; ++k) row[c] -= row[k] * L[k + c * stride_of_L];
    row[c] *= L[c + c * stride_of_L];
    store(row[c], y + c * stride);
  }
}

// to = a + factor b, of `size` numbers; or a alone.
template <int size, bool both>
inline void set_sum(const double* a, double factor, const double* b, double* to) {
  int i = 0;
  for (; i + 4 <= size; i += 4) {
    Four sum = load<Four>(a + i);
    if constexpr (both) sum += factor * load<Four>(b + i);
    store(sum, to + i);
  }
  for (; i < size; ++i) to[i] = both ? a[i] + factor * b[i] : a[i];
}

// to += a
template <int size>
inline void add(const double* a, double* to) {
  int i = 0;
  for (; i + 4 <= size; i += 4) store(load<Four>(a + i) + load<Four>(to + i), to + i);
  for (; i < size; ++i) to[i] += a[i];
}

template <int shape, int rest>
class SweepOf : public PlacedSweep {
 public:
  explicit SweepOf(const StageSizes& sizes)
      : stages_(sizes.stages),
        ends_(sizes.end_rows),
        fours_(in_fours(states + ends_)),
        end_fours_(in_fours(ends_)),
        ahead_(room(4 * in_fours(states))),
        moved_(room(seen + shape)),
        gain_(at(stages_ * gain_size)),
        carried_(at(stride)),
        gram_(at(16 * end_fours_ * end_fours_)) {}

  bool factor(const StageModel& model, double shift, const MatrixXd& P, MatrixXd& end_gram) override {
    for (int c = 0; c < states; ++c) {
      lay(P.data() + c * states, model.C.data() + c * ends_, column(ahead_, c));
    }
    std::fill(gram_.begin(), gram_.end(), 0.0);
    for (Index k = stages_ - 1; k >= 0; --k) {
      const Stage& stage = model.stage[at(k)];
      double* gain = gain_of(k);
      move_columns(stage);
      if (shift > 0.0)
        move_rows<true>(stage, shift, gain);
      else
        move_rows<false>(stage, 0.0, gain);
      failed_input_ = find_factor();
      for (int c = 0; c < shape; ++c) std::copy_n(factor_ + c * shape_stride, shape, gain + shape * stride + c * shape);
      if (failed_input_ < shape) {
        failed_stage_ = static_cast<int>(k);
        return false;
      }
      eliminate(gain);
      for (Index f = 0; f < fours_; ++f) divide<shape, stride, shape_stride>(factor_, gain + 4 * f);
    }
    for (Index c = 0; c < ends_; ++c) std::copy_n(&gram_[at(c * 4 * end_fours_)], ends_, &end_gram(0, c));
    return true;
  }

  void read_factor(int stage, MatrixXd& factor) const override {
    std::copy_n(gain_of(stage) + shape * stride, shape * shape, factor.data());
  }

  MatrixXd feedback(int stage) const override {
    MatrixXd by_state(shape, states);
    for (int c = 0; c < shape; ++c)
      for (int r = 0; r < states; ++r) by_state(c, r) = -gain_of(stage)[c * stride + r];
    return by_state;
  }

  void look_back(const StageModel& model, const VectorXd& gradient, VectorXd& end_rows) override {
    double* carried = carried_.data();  // gradient above end rows
    lay(gradient.data(), end_rows.data(), carried);
    for (Index k = stages_ - 1; k >= 0; --k) {
      const Stage& stage = model.stage[at(k)];
      const double *A = stage.A.data() + shape * states + kept, *B = stage.B.data() + kept;
      double* gain = gain_of(k);
      double* input = gain + shape * (stride + shape);
      double p[states];
      std::copy_n(carried, states, p);
      for (int c = 0; c < shape; ++c) {
        double sum = stage.r.data()[c] + p[shape + c];
        for (int i = 0; i < rest; ++i) sum += B[c * states + i] * p[kept + i];
        input[c] = -sum;
      }
      std::copy_n(stage.q.data(), states, carried);
      for (int c = 0; c < shape; ++c) carried[shape + c] += p[c];
      for (int c = 0; c < seen; ++c) {
        double sum = 0.0;
        for (int i = 0; i < rest; ++i) sum += A[c * states + i] * p[kept + i];
        carried[shape + c] += sum;
      }
      for (Index f = 0; f < fours_; ++f) {
        Four sum = load<Four>(carried + 4 * f);
        for (int c = 0; c < shape; ++c) sum += load<Four>(gain + c * stride + 4 * f) * input[c];
        store(sum, carried + 4 * f);
      }
      solve_factored(gain + shape * stride, input);
    }
    std::copy_n(carried + states, ends_, end_rows.data());
  }

  void follow(const StageModel& model, int first, const VectorXd& state, const VectorXd& end_multiplier,
              bool own_inputs, bool add, StageStep& step) override {
    double *here = carried_.data(), input[shape];  // state above multipliers
    lay(state.data(), end_multiplier.data(), here);
    for (Index k = first; k < stages_; ++k) {
      const double* gain = gain_of(k);
      const double* own = gain + shape * (stride + shape);
      for (int c = 0; c < shape; ++c) {
        Four sum{};
        for (Index f = 0; f < fours_; ++f) sum += load<Four>(gain + c * stride + 4 * f) * load<Four>(here + 4 * f);
        input[c] = (own_inputs ? own[c] : 0.0) - algebra::sum(sum);
      }
      move(model.stage[at(k)], input, here);
      double *to_input = step.input[at(k)].data(), *to_state = step.state[at(k + 1)].data();
      for (int c = 0; c < shape; ++c) to_input[c] = add ? to_input[c] + input[c] : input[c];
      for (int c = 0; c < states; ++c) to_state[c] = add ? to_state[c] + here[c] : here[c];
    }
  }

 private:
  static constexpr int seen = shape + rest;  // states that do more than move on
  static constexpr int states = shape + seen;
  static constexpr int kept = states - rest;  // where the rest begins
  static constexpr int most_ends = seen;
  static constexpr int seen_stride = 4 * in_fours(seen), shape_stride = 4 * in_fours(shape);
  static constexpr int stride = 4 * in_fours(states + 4 * in_fours(most_ends));
  static constexpr int gain_size = shape * (stride + shape + 1);

  static std::size_t at(Index place) { return static_cast<std::size_t>(place); }
  std::vector<double> room(Index columns) const { return std::vector<double>(at(columns * stride)); }
  double* gain_of(Index stage) { return &gain_[at(stage * gain_size)]; }
  const double* gain_of(Index stage) const { return &gain_[at(stage * gain_size)]; }
  double* column(std::vector<double>& matrix, Index c) const { return matrix.data() + c * stride; }

  // A column: spare rows must be 0, whatever came before.
  void lay(const double* of_states, const double* of_ends, double* to) const {
    std::copy_n(of_states, states, to);
    std::copy_n(of_ends, ends_, to + states);
    std::fill(to + states + ends_, to + stride, 0.0);
  }

  // Fours of end rows.
  void copy_ends(const double* from, double* to) const {
    for (Index f = 0; f < end_fours_; ++f) store(load<Four>(from + states + 4 * f), to + states + 4 * f);
  }

  // (P; end) by what is before: columns of the shape, the rest and the inputs.
  void move_columns(const Stage& stage) {
    double* moved = moved_.data();
    for (int c = 0; c < shape; ++c)
      for (Index f = 0; f < fours_; ++f) {
        store(load<Four>(column(ahead_, c) + 4 * f), column(moved_, c) + 4 * f);
        store(load<Four>(column(ahead_, shape + c) + 4 * f), column(moved_, seen + c) + 4 * f);
      }
    for (int c = shape; c < seen; ++c)
      for (Index f = 0; f < fours_; ++f) store(Four{}, column(moved_, c) + 4 * f);
    const double* of_rest = column(ahead_, kept);
    using Stride = Strides<stride, stride, 1, states>;
    add_product<seen, rest, Stride>(fours_, of_rest, stage.A.data() + shape * states + kept, moved);
    add_product<shape, rest, Stride>(fours_, of_rest, stage.B.data() + kept, column(moved_, seen));
  }

  // What the rows of that add to the stage's own part: (P; end), and what inputs have to do with states, end rows and each
  // other before they are eliminated.
  template <bool shifted>
  void move_rows(const Stage& stage, double shift, double* gain) {
    const double *A = stage.A.data() + shape * states + kept, *B = stage.B.data() + kept;
    for (int p = 0; p < rest; ++p) {
      for (int c = 0; c < seen; ++c) by_state_[p * seen_stride + c] = A[c * states + p];
      for (int c = 0; c < shape; ++c) by_input_[p * shape_stride + c] = B[c * states + p];
    }
    const double *moved = moved_.data(), *moved_inputs = column(moved_, seen);
    for (int c = 0; c < states; ++c) {
      double* to = column(ahead_, c);
      set_sum<states, shifted>(stage.Q.data() + c * states, shift, stage.metric.data() + c * states, to);
      if (c >= shape) add<shape>(moved + (c - shape) * stride, to + shape);
    }
    add_product<seen, rest, Strides<stride, seen_stride, 1, stride>>(in_fours(seen), by_state_, moved + kept,
                                                                     column(ahead_, shape) + shape);
    for (int c = 0; c < shape; ++c) {
      double* to = gain + c * stride;
      for (int r = 0; r < states; ++r) to[r] = stage.S.data()[r * shape + c];
      add<shape>(moved_inputs + c * stride, to + shape);
      set_sum<shape, false>(stage.R.data() + c * shape, 0.0, nullptr, factor_ + c * shape_stride);
      add<shape>(moved_inputs + c * stride + shape, factor_ + c * shape_stride);
    }
    add_product<shape, rest, Strides<stride, seen_stride, 1, stride>>(in_fours(seen), by_state_, moved_inputs + kept,
                                                                      gain + shape);
    add_product<shape, rest, Strides<shape_stride, shape_stride, 1, stride>>(in_fours(shape), by_input_,
                                                                             moved_inputs + kept, factor_);
    for (int c = 0; c < shape; ++c)
      for (Index f = 0; f < end_fours_; ++f) store(Four{}, column(ahead_, c) + states + 4 * f);
    for (int c = 0; c < seen; ++c) copy_ends(moved + c * stride, column(ahead_, shape + c));
    for (int c = 0; c < shape; ++c) copy_ends(moved_inputs + c * stride, gain + c * stride);
  }

  // Returns the number of pivots before one that is not positive.
  int find_factor() {
    double* L = factor_;
#pragma GCC unroll 16
    for (int c = 0; c < shape; ++c, L += shape_stride) {
#pragma GCC unroll 16
      for (int k = 0; k < c; ++k) {
        const double* before = factor_ + k * shape_stride;
        for (int r = c; r < shape; ++r) L[r] -= before[r] * before[c];
      }
      const double pivot = L[c];
      if (!(pivot > 0.0) || !std::isfinite(pivot)) return c;
      const double inverse = 1.0 / std::sqrt(pivot);
      L[c] = inverse;
      for (int r = c + 1; r < shape; ++r) L[r] *= inverse;
    }
    return shape;
  }

  void eliminate(double* inputs) {
    for (Index f = 0; f < fours_; ++f) divide_by_transposed<shape, stride, shape_stride>(factor_, inputs + 4 * f);
    subtract_lower_product<states, shape, Strides<stride, stride, stride, 1>>(fours_, inputs, inputs, ahead_.data());
    mirror();
    const double* ends = inputs + states;
    for (Index c = 0; c < ends_; ++c)
      for (Index f = 0; f < end_fours_; ++f) {
        double* to = &gram_[at(4 * (c * end_fours_ + f))];
        Four sum = load<Four>(to);
        for (int k = 0; k < shape; ++k) sum += load<Four>(ends + k * stride + 4 * f) * ends[k * stride + c];
        store(sum, to);
      }
  }

  // What is below the diagonal of P goes above it, four by four and a little beyond: asymmetry would grow from stage to stage.
  void mirror() {
    for (Index c = 0; c < states; c += 4) {
      double* block = column(ahead_, c) + c;
      for (Index i = 1; i < 4; ++i)
        for (Index j = 0; j < i; ++j) block[i * stride + j] = block[j * stride + i];
      for (Index r = c + 4; r < states; r += 4) {
        const double* from = column(ahead_, c) + r;
        Four one = load<Four>(from), two = load<Four>(from + stride), three = load<Four>(from + 2 * stride),
             four = load<Four>(from + 3 * stride);
        algebra::transpose(one, two, three, four);
        double* to = column(ahead_, r) + c;
        store(one, to);
        store(two, to + stride);
        store(three, to + 2 * stride);
        store(four, to + 3 * stride);
      }
    }
  }

  // (L Lᵀ)⁻¹
  static void solve_factored(const double* L, double* input) {
    for (int c = 0; c < shape; ++c) {
      input[c] *= L[c + c * shape];
      for (int i = c + 1; i < shape; ++i) input[i] -= L[i + c * shape] * input[c];
    }
    for (int c = shape - 1; c >= 0; --c) {
      for (int i = c + 1; i < shape; ++i) input[c] -= L[i + c * shape] * input[i];
      input[c] *= L[c + c * shape];
    }
  }

  // The state becomes the next.
  static void move(const Stage& stage, const double* input, double* state) {
    const double *A = stage.A.data() + shape * states + kept, *B = stage.B.data() + kept;
    double next[rest] = {};
    for (int c = 0; c < seen; ++c)
      for (int i = 0; i < rest; ++i) next[i] += A[c * states + i] * state[shape + c];
    for (int c = 0; c < shape; ++c)
      for (int i = 0; i < rest; ++i) next[i] += B[c * states + i] * input[c];
    std::copy_n(state + shape, shape, state);
    std::copy_n(input, shape, state + shape);
    std::copy_n(next, rest, state + kept);
  }

  Index stages_, ends_, fours_, end_fours_;
  // columns of rows of states, above end rows, above spare ones that stay 0
  std::vector<double> ahead_;  // [states] columns: (P; end)
  std::vector<double> moved_;  // [seen + shape] columns: (P; end) (A, B)
  // [stages]: [shape] columns, inputs by states and by end rows' multipliers with their signs reversed; the factor; the input at
  // state and multipliers 0
  std::vector<double> gain_;
  std::vector<double> carried_;                           // one such column
  std::vector<double> gram_;                              // [end_rows] columns of whole fours
  alignas(32) double by_state_[rest * seen_stride] = {};  // [rest] columns: (A, B) transposed
  alignas(32) double by_input_[rest * shape_stride] = {};
  alignas(32) double factor_[shape * shape_stride] = {};  // [shape] columns
};

}  // namespace

std::unique_ptr<PlacedSweep> PlacedSweep::of(const StageSizes& sizes) {
  const int shape = sizes.inputs, rest = sizes.states - 2 * sizes.inputs;
  if (sizes.end_rows > shape + rest) return nullptr;
  if (shape == 2 && rest == 3) return std::make_unique<SweepOf<2, 3>>(sizes);  // three bodies in their plane
  if (shape == 3 && rest == 6) return std::make_unique<SweepOf<3, 6>>(sizes);  // two in space
  if (shape == 6 && rest == 6) return std::make_unique<SweepOf<6, 6>>(sizes);  // three in space
  return nullptr;
}

}  // namespace lamprey::optimizer
