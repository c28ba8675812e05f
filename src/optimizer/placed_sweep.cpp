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

// Entries of a matrix wherever they lie.
struct Entries {
  const double* data;
  Index row, column;  // strides
};

// `fours` times four rows and `width` columns of C += sign A B.
template <int fours, int width, int depth, int sign>
void add_tile(const double* a, Index a_stride, const Entries& b, double* c, Index c_stride) {
  Four sum[width][fours];
#pragma GCC unroll 8
  for (int j = 0; j < width; ++j)
#pragma GCC unroll 8
    for (int f = 0; f < fours; ++f) sum[j][f] = load<Four>(c + j * c_stride + 4 * f);
#pragma GCC unroll 16
  for (int p = 0; p < depth; ++p) {
    Four left[fours];
#pragma GCC unroll 8
    for (int f = 0; f < fours; ++f) left[f] = load<Four>(a + p * a_stride + 4 * f);
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) {
      const double entry = b.data[p * b.row + j * b.column];
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
    for (int f = 0; f < fours; ++f) store(sum[j][f], c + j * c_stride + 4 * f);
}

template <int width, int depth, int sign>
void add_columns(Index fours, const double* a, Index a_stride, const Entries& b, double* c, Index c_stride) {
  for (; fours >= 3; fours -= 3, a += 12, c += 12) add_tile<3, width, depth, sign>(a, a_stride, b, c, c_stride);
  if (fours == 2) add_tile<2, width, depth, sign>(a, a_stride, b, c, c_stride);
  if (fours == 1) add_tile<1, width, depth, sign>(a, a_stride, b, c, c_stride);
}

// C += sign A B, of whole fours of rows.
template <int columns, int depth, int sign = 1>
void add_product(Index fours, const double* a, Index a_stride, const Entries& b, double* c, Index c_stride) {
  constexpr int left_over = columns % 4;
  Entries part = b;
  for (int j = 0; j + 4 <= columns; j += 4, part.data += 4 * b.column, c += 4 * c_stride)
    add_columns<4, depth, sign>(fours, a, a_stride, part, c, c_stride);
  if constexpr (left_over > 0) add_columns<left_over, depth, sign>(fours, a, a_stride, part, c, c_stride);
}

// Four rows Y become Y L⁻ᵀ, L's diagonal being given by its inverse.
template <int shape>
void divide_by_transposed(const double* L, double* y, Index stride) {
  Four row[shape];
#pragma GCC unroll 16
  for (int c = 0; c < shape; ++c) {
    row[c] = load<Four>(y + c * stride);
#pragma GCC unroll 16
    for (int k = 0; k < c; ++k) row[c] -= row[k] * L[c + k * shape];
    row[c] *= L[c + c * shape];
    store(row[c], y + c * stride);
  }
}

// And Y L⁻¹.
template <int shape>
void divide(const double* L, double* y, Index stride) {
  Four row[shape];
#pragma GCC unroll 16
  for (int c = shape - 1; c >= 0; --c) {
    row[c] = load<Four>(y + c * stride);
#pragma GCC unroll 16
    for (int k = c + 1; k < shape; ++k) row[c] -= row[k] * L[k + c * shape];
    row[c] *= L[c + c * shape];
    store(row[c], y + c * stride);
  }
}

template <int shape, int rest>
class SweepOf : public PlacedSweep {
 public:
  explicit SweepOf(const StageSizes& sizes)
      : stages_(sizes.stages),
        ends_(sizes.end_rows),
        fours_(in_fours(states + ends_)),
        end_fours_(in_fours(ends_)),
        stride_(4 * fours_),
        gain_size_(4 * in_fours(shape * stride_ + shape * shape + shape)),
        ahead_(room(4 * in_fours(states))),
        moved_(room(seen + shape)),
        gain_(at(stages_ * gain_size_ + 8)),
        carried_(at(stride_ + 8)),
        gram_(at(16 * end_fours_ * end_fours_)) {}

  bool factor(const StageModel& model, double shift, const MatrixXd& P, MatrixXd& end_gram) override {
    for (int c = 0; c < states; ++c) {
      std::copy_n(P.data() + c * states, states, column(ahead_, c));
      std::copy_n(model.C.data() + c * ends_, ends_, column(ahead_, c) + states);
    }
    std::fill(gram_.begin(), gram_.end(), 0.0);
    for (Index k = stages_ - 1; k >= 0; --k) {
      const Stage& stage = model.stage[at(k)];
      double* gain = gain_of(k);
      move_columns(stage);
      move_rows(stage);
      if (shift > 0.0)
        add_own<true>(stage, shift, gain);
      else
        add_own<false>(stage, 0.0, gain);
      failed_input_ = find_factor();
      std::copy_n(factor_, shape * shape, gain + shape * stride_);
      if (failed_input_ < shape) {
        failed_stage_ = static_cast<int>(k);
        return false;
      }
      eliminate(gain);
      for (Index f = 0; f < fours_; ++f) divide<shape>(factor_, gain + 4 * f, stride_);
    }
    for (Index c = 0; c < ends_; ++c) std::copy_n(&gram_[at(c * 4 * end_fours_)], ends_, &end_gram(0, c));
    return true;
  }

  void read_factor(int stage, MatrixXd& factor) const override {
    std::copy_n(gain_of(stage) + shape * stride_, shape * shape, factor.data());
  }

  MatrixXd feedback(int stage) const override {
    MatrixXd by_state(shape, states);
    for (int c = 0; c < shape; ++c)
      for (int r = 0; r < states; ++r) by_state(c, r) = -gain_of(stage)[c * stride_ + r];
    return by_state;
  }

  void look_back(const StageModel& model, const VectorXd& gradient, VectorXd& end_rows) override {
    double* carried = carried_.data();  // gradient above end rows
    std::copy_n(gradient.data(), states, carried);
    std::copy_n(end_rows.data(), ends_, carried + states);
    for (Index k = stages_ - 1; k >= 0; --k) {
      const Stage& stage = model.stage[at(k)];
      const double *A = stage.A.data() + shape * states + kept, *B = stage.B.data() + kept;
      double* gain = gain_of(k);
      double* input = gain + shape * (stride_ + shape);
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
        for (int c = 0; c < shape; ++c) sum += load<Four>(gain + c * stride_ + 4 * f) * input[c];
        store(sum, carried + 4 * f);
      }
      solve_factored(gain + shape * stride_, input);
    }
    std::copy_n(carried + states, ends_, end_rows.data());
  }

  void follow(const StageModel& model, int first, const VectorXd& state, const VectorXd& end_multiplier,
              bool own_inputs, bool add, StageStep& step) override {
    double *here = carried_.data(), input[shape];  // state above multipliers
    std::copy_n(state.data(), states, here);
    std::copy_n(end_multiplier.data(), ends_, here + states);
    for (Index k = first; k < stages_; ++k) {
      const double* gain = gain_of(k);
      const double* own = gain + shape * (stride_ + shape);
      for (int c = 0; c < shape; ++c) {
        Four sum{};
        for (Index f = 0; f < fours_; ++f) sum += load<Four>(gain + c * stride_ + 4 * f) * load<Four>(here + 4 * f);
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
  static constexpr Index square = 4 * in_fours(seen + shape);

  static std::size_t at(Index place) { return static_cast<std::size_t>(place); }
  std::vector<double> room(Index columns) const { return std::vector<double>(at(columns * stride_ + 8)); }
  double* gain_of(Index stage) { return &gain_[at(stage * gain_size_)]; }
  const double* gain_of(Index stage) const { return &gain_[at(stage * gain_size_)]; }
  double* column(std::vector<double>& matrix, Index c) const { return matrix.data() + c * stride_; }

  // Fours of end rows, in columns of rising number: what is written beyond them is written again.
  void copy_ends(const double* from, double* to) const {
    for (Index f = 0; f < end_fours_; ++f) store(load<Four>(from + states + 4 * f), to + states + 4 * f);
  }

  // (P; end) by what is before: columns of the shape, the rest and the inputs.
  void move_columns(const Stage& stage) {
    double* moved = moved_.data();
    const auto copy = [&](const double* from, double* to) {
      for (Index i = 0; i < shape * stride_; i += 4) store(load<Four>(from + i), to + i);
    };
    copy(column(ahead_, 0), moved);
    for (Index i = shape * stride_; i < seen * stride_; i += 4) store(Four{}, moved + i);
    copy(column(ahead_, shape), column(moved_, seen));
    const double* of_rest = column(ahead_, kept);
    add_product<seen, rest>(fours_, of_rest, stride_, {stage.A.data() + shape * states + kept, 1, states}, moved,
                            stride_);
    add_product<shape, rest>(fours_, of_rest, stride_, {stage.B.data() + kept, 1, states}, column(moved_, seen),
                             stride_);
  }

  // And its rows: the Hessian by shape, rest and inputs; of the inputs' rows only what stands in their own columns.
  void move_rows(const Stage& stage) {
    const double *A = stage.A.data() + shape * states + kept, *B = stage.B.data() + kept;
    for (int p = 0; p < rest; ++p) {
      for (int c = 0; c < seen; ++c) transposed_[p * square + c] = A[c * states + p];
      for (int c = 0; c < shape; ++c) transposed_[p * square + seen + c] = B[c * states + p];
    }
    const double* rows = moved_.data();
    for (int c = 0; c < seen + shape; ++c) {
      const double* from = rows + c * stride_;
      double* to = hessian_ + c * square;
      for (int r = 0; r < shape; ++r) to[r] = from[r];
      for (int r = shape; r < seen; ++r) to[r] = 0.0;
      for (int r = 0; r < shape; ++r) to[seen + r] = from[shape + r];
    }
    add_product<seen, rest>(in_fours(seen), transposed_, square, {rows + kept, 1, stride_}, hessian_, square);
    add_product<shape, rest>(in_fours(seen + shape), transposed_, square, {rows + seen * stride_ + kept, 1, stride_},
                             hessian_ + seen * square, square);
  }

  // With the stage's own part: (P; end) and what inputs have to do with states and end rows, before they are eliminated.
  template <bool shifted>
  void add_own(const Stage& stage, double shift, double* gain) {
    const double *Q = stage.Q.data(), *S = stage.S.data(), *R = stage.R.data(), *metric = stage.metric.data();
    for (int c = 0; c < states; ++c) {
      double* to = column(ahead_, c);
      for (int r = 0; r < states; ++r)
        to[r] = shifted ? Q[c * states + r] + shift * metric[c * states + r] : Q[c * states + r];
      if (c < shape) {
        for (Index f = 0; f < end_fours_; ++f) store(Four{}, to + states + 4 * f);
        continue;
      }
      const double* more = hessian_ + (c - shape) * square;
      for (int r = 0; r < seen; ++r) to[shape + r] += more[r];
      copy_ends(column(moved_, c - shape), to);
    }
    for (int c = 0; c < shape; ++c) {
      double* to = gain + c * stride_;
      const double* more = hessian_ + (seen + c) * square;
      for (int r = 0; r < states; ++r) to[r] = S[r * shape + c];
      for (int r = 0; r < seen; ++r) to[shape + r] += more[r];
      copy_ends(column(moved_, seen + c), to);
      for (int r = 0; r < shape; ++r) factor_[c * shape + r] = R[c * shape + r] + more[seen + r];
    }
  }

  int find_factor() {
#pragma GCC unroll 16
    for (int c = 0; c < shape; ++c) {
#pragma GCC unroll 16
      for (int k = 0; k < c; ++k)
        for (int r = c; r < shape; ++r) factor_[c * shape + r] -= factor_[k * shape + r] * factor_[k * shape + c];
      const double pivot = factor_[c * shape + c];
      if (!(pivot > 0.0) || !std::isfinite(pivot)) return c;
      const double inverse = 1.0 / std::sqrt(pivot);
      factor_[c * shape + c] = inverse;
      for (int r = c + 1; r < shape; ++r) factor_[c * shape + r] *= inverse;
    }
    return shape;
  }

  void eliminate(double* inputs) {
    for (Index f = 0; f < fours_; ++f) divide_by_transposed<shape>(factor_, inputs + 4 * f, stride_);
    add_product<states, shape, -1>(fours_, inputs, stride_, {inputs, stride_, 1}, ahead_.data(), stride_);
    mirror();
    const double* ends = inputs + states;
    for (Index c = 0; c < ends_; ++c)
      for (Index f = 0; f < end_fours_; ++f) {
        double* to = &gram_[at(4 * (c * end_fours_ + f))];
        Four sum = load<Four>(to);
        for (int k = 0; k < shape; ++k) sum += load<Four>(ends + k * stride_ + 4 * f) * ends[k * stride_ + c];
        store(sum, to);
      }
  }

  // What is below the diagonal of P goes above it, four by four and a little beyond: asymmetry would grow from stage to stage.
  void mirror() {
    for (Index c = 0; c < states; c += 4) {
      double* block = column(ahead_, c) + c;
      for (Index i = 1; i < 4; ++i)
        for (Index j = 0; j < i; ++j) block[i * stride_ + j] = block[j * stride_ + i];
      for (Index r = c + 4; r < states; r += 4) {
        const double* from = column(ahead_, c) + r;
        Four one = load<Four>(from), two = load<Four>(from + stride_), three = load<Four>(from + 2 * stride_),
             four = load<Four>(from + 3 * stride_);
        algebra::transpose(one, two, three, four);
        double* to = column(ahead_, r) + c;
        store(one, to);
        store(two, to + stride_);
        store(three, to + 2 * stride_);
        store(four, to + 3 * stride_);
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

  Index stages_, ends_, fours_, end_fours_, stride_, gain_size_;
  // columns of states' rows above end rows, and spare ones
  std::vector<double> ahead_;  // [states] columns: (P; end)
  std::vector<double> moved_;  // [seen + shape] columns: (P; end) (A, B)
  // [stages]: [shape] columns, inputs by states and by end rows' multipliers with their signs reversed; the factor; the input at
  // state and multipliers 0
  std::vector<double> gain_;
  std::vector<double> carried_;                               // one such column
  std::vector<double> gram_;                                  // [end_rows] columns of whole fours
  alignas(32) double transposed_[rest * square] = {};         // [seen + shape][rest] of (A, B)
  alignas(32) double hessian_[(seen + shape) * square] = {};  // [seen + shape] squared, by columns
  alignas(32) double factor_[shape * shape] = {};             // by columns
};

}  // namespace

std::unique_ptr<PlacedSweep> PlacedSweep::of(const StageSizes& sizes) {
  const int shape = sizes.inputs, rest = sizes.states - 2 * sizes.inputs;
  if (shape == 2 && rest == 3) return std::make_unique<SweepOf<2, 3>>(sizes);  // three bodies in their plane
  if (shape == 3 && rest == 6) return std::make_unique<SweepOf<3, 6>>(sizes);  // two in space
  if (shape == 6 && rest == 6) return std::make_unique<SweepOf<6, 6>>(sizes);  // three in space
  return nullptr;
}

}  // namespace lamprey::optimizer
