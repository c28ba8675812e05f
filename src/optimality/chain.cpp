#include "optimality/chain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace lamprey::optimality {

namespace {

constexpr double singular_pivot = 1e-14;  // of the pivot's largest eigenvalue
constexpr double implied_row = 1e-12;     // of the largest eigenvalue of what end rows do
constexpr double driven = 1e-7;           // least that an input does to a row it can keep, of the most that any does
constexpr double looked_at = 1e-8;        // least that a state does to a row that is left, of what its row began with
constexpr int most_lanczos_steps = 120;
constexpr double settled_value = 1e-9;  // relative change of Lanczos' value from step to step
constexpr double bracket = 1e-3;        // of the eigenvalue
constexpr double least_bracket = 1e-6;
constexpr int most_halvings = 60;
constexpr int inverse_iterations = 3;
constexpr double first_shift = -0.01;
constexpr double shift_growth = 8.0;
constexpr double farthest_shift = -1e12;

// Inverse of a symmetric matrix and its negative eigenvalues; −1: singular.
int invert(const MatrixXd& pivot, MatrixXd& inverse) {
  if (!pivot.allFinite()) return -1;  // which a factorisation would take
  const Eigen::LLT<MatrixXd> positive(pivot);
  if (positive.info() == Eigen::Success) {
    inverse = positive.solve(MatrixXd::Identity(pivot.rows(), pivot.cols()));
    return 0;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> split(pivot);
  const VectorXd& values = split.eigenvalues();
  if (values.cwiseAbs().minCoeff() <= singular_pivot * values.cwiseAbs().maxCoeff()) return -1;
  inverse = split.eigenvectors() * values.cwiseInverse().asDiagonal() * split.eigenvectors().transpose();
  return static_cast<int>((values.array() < 0.0).count());
}

double metric_product(const Chain& chain, const Inputs& a, const Inputs& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += chain.stage[k].weight * a[k].dot(b[k]);
  return sum;
}

void add(double factor, const Inputs& terms, Inputs& sum) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += factor * terms[k];
}

// Takes off what lies along inputs of size 1.
void remove(const Chain& chain, const Inputs& along, Inputs& inputs) {
  add(-metric_product(chain, along, inputs), along, inputs);
}

// The gradient whose solution is the inverse's image of the metric's.
ChainGradient weighed(const Chain& chain, Inputs inputs) {
  for (std::size_t k = 0; k < inputs.size(); ++k) inputs[k] *= -chain.stage[k].weight;
  return {std::move(inputs), {}};
}

// Inputs without a pattern, the same each time.
Inputs scattered(const Chain& chain) {
  Inputs inputs;
  double phase = 0.0;
  for (const ChainStage& stage : chain.stage) {
    inputs.emplace_back(stage.B.cols());
    for (double& entry : inputs.back()) entry = std::sin(phase = std::fmod(phase * 1.7 + 2.399963229728653, 1e3));
  }
  return inputs;
}

// A stage's own rows, and those that the state after it has to keep.
KeptRows with_later_rows(const ChainStage& stage, const MatrixXd& later) {
  const Eigen::Index own = stage.kept.by_state.rows(), all = own + later.rows();
  KeptRows rows{MatrixXd(all, stage.A.cols()), MatrixXd(all, stage.B.cols())};
  if (own > 0) rows.by_state.topRows(own) = stage.kept.by_state;
  if (own > 0) rows.by_input.topRows(own) = stage.kept.by_input;
  if (later.rows() > 0) rows.by_state.bottomRows(later.rows()) = later * stage.A;
  if (later.rows() > 0) rows.by_input.bottomRows(later.rows()) = later * stage.B;
  return rows;
}

// u = feedback y + free w keeps the rows that inputs reach, w whatever it is; `left` · y = 0 is what they say beside that.
struct HeldInputs {
  MatrixXd feedback;  // [inputs][states]
  MatrixXd free;      // [inputs][free] orthonormal
  MatrixXd left;      // [rows][states]
};

// Inputs in a unit, and each row of size 1: what rows say is the same.
KeptRows measured(KeptRows rows, double unit) {
  rows.by_input *= unit;
  for (Eigen::Index r = 0; r < rows.by_state.rows(); ++r) {
    const double size = std::hypot(rows.by_state.row(r).norm(), rows.by_input.row(r).norm());
    if (size == 0.0) continue;
    rows.by_state.row(r) /= size;
    rows.by_input.row(r) /= size;
  }
  return rows;
}

HeldInputs hold(const KeptRows& rows) {
  const Eigen::JacobiSVD<MatrixXd> split(rows.by_input, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd& values = split.singularValues();
  const double most = values.size() > 0 ? values[0] : 0.0;
  Eigen::Index rank = 0;
  if (most > singular_pivot * rows.by_state.cwiseAbs().maxCoeff())
    while (rank < values.size() && values[rank] > driven * most) ++rank;
  const MatrixXd turned = split.matrixU().transpose() * rows.by_state;  // in the order of what inputs do to them
  const VectorXd inverse = values.head(rank).cwiseInverse();
  return {-split.matrixV().leftCols(rank) * (inverse.asDiagonal() * turned.topRows(rank)),
          split.matrixV().rightCols(rows.by_input.cols() - rank), turned.bottomRows(turned.rows() - rank)};
}

// Orthonormal rows with the span of these, but for what is smaller than `least`.
MatrixXd orthonormal_rows(const MatrixXd& rows, double least) {
  if (rows.rows() == 0) return rows;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.transpose());
  Eigen::Index rank = 0;
  while (rank < std::min(rows.rows(), rows.cols()) && std::abs(qr.matrixQR()(rank, rank)) > least) ++rank;
  return MatrixXd(qr.householderQ() * MatrixXd::Identity(rows.cols(), rank)).transpose();
}

}  // namespace

double input_unit(const ChainStage& stage) {
  const double most = stage.B.size() > 0 ? stage.B.cwiseAbs().maxCoeff() : 0.0;
  return most > 0.0 ? 1.0 / most : 1.0;
}

void widen(Chain& chain, Eigen::Index states) {
  const auto widened = [](MatrixXd& matrix, Eigen::Index rows, Eigen::Index columns) {
    MatrixXd wide = MatrixXd::Zero(rows, columns);
    wide.topLeftCorner(matrix.rows(), matrix.cols()) = matrix;
    matrix.swap(wide);
  };
  for (ChainStage& stage : chain.stage) {
    widened(stage.A, states, states);
    widened(stage.B, states, stage.B.cols());
    widened(stage.Q, states, states);
    widened(stage.S, stage.S.rows(), states);
  }
  for (ChainStage& stage : chain.stage)
    if (stage.kept.by_state.rows() > 0) widened(stage.kept.by_state, stage.kept.by_state.rows(), states);
  widened(chain.end_form, states, states);
  widened(chain.end_rows, chain.end_rows.rows(), states);
}

void keep_rows(const MatrixXd& rows, ChainStage& stage) {
  KeptRows& kept = stage.kept;
  const Eigen::Index before = kept.by_state.rows(), states = stage.A.cols(), inputs = stage.B.cols();
  kept.by_state.conservativeResize(before + rows.rows(), states);
  kept.by_input.conservativeResize(before + rows.rows(), inputs);
  kept.by_state.bottomRows(rows.rows()) = rows.leftCols(states);
  kept.by_input.bottomRows(rows.rows()) = rows.rightCols(inputs);
}

bool keeps_rows(const Chain& chain) {
  return std::any_of(chain.stage.begin(), chain.stage.end(),
                     [](const ChainStage& stage) { return stage.kept.by_state.rows() > 0; });
}

Chain with_rows_weighed(const Chain& chain, double weight) {
  Chain weighed = chain;
  for (ChainStage& stage : weighed.stage) {
    const double unit = input_unit(stage);
    const KeptRows rows = measured(std::exchange(stage.kept, {}), unit);
    if (rows.by_state.rows() == 0) continue;
    const double by_unit = weight * stage.weight * unit;
    stage.Q += by_unit * unit * rows.by_state.transpose() * rows.by_state;
    stage.S += by_unit * rows.by_input.transpose() * rows.by_state;
    stage.R += weight * stage.weight * rows.by_input.transpose() * rows.by_input;
  }
  return weighed;
}

ChainSolver::ChainSolver(const Chain& chain, double penalty) : chain_(chain), penalty_(penalty) { keep(); }

// From the end: a stage's inputs keep what rows they can at the least |u| and stay free beside that. What rows say of the states
// alone is for the stage before.
void ChainSolver::keep() {
  gain_.resize(chain_.stage.size());
  MatrixXd left;  // [rows][states] that the state after the stage has to keep
  for (std::size_t k = chain_.stage.size(); k-- > 0;) {
    const ChainStage& stage = chain_.stage[k];
    const double unit = input_unit(stage);
    Gain& gain = gain_[k];
    const KeptRows rows = measured(with_later_rows(stage, left), unit);
    if (rows.by_state.rows() == 0) {
      gain.held_feedback = MatrixXd::Zero(stage.B.cols(), stage.A.cols());
      gain.free = MatrixXd::Identity(stage.B.cols(), stage.B.cols());
      left.resize(0, stage.A.cols());
      continue;
    }
    const HeldInputs held = hold(rows);
    gain.held_feedback = unit * held.feedback;
    gain.free = held.free;
    left = orthonormal_rows(held.left, looked_at * rows.by_state.cwiseAbs().maxCoeff());
  }
}

// As `invert`, of the inputs that are free.
int ChainSolver::invert_where_free(const MatrixXd& pivot, Gain& gain) {
  if (!gain.keeps()) return invert(pivot, gain.pivot_inverse);
  gain.pivot_inverse = MatrixXd::Zero(pivot.rows(), pivot.cols());
  if (gain.free.cols() == 0) return 0;
  MatrixXd inverse;
  const int negative = invert(gain.free.transpose() * pivot * gain.free, inverse);
  if (negative >= 0) gain.pivot_inverse = gain.free * inverse * gain.free.transpose();
  return negative;
}

std::optional<int> ChainSolver::factor(double shift) {
  shift_ = shift;
  int negative = 0;
  MatrixXd P = chain_.end_form;
  P.noalias() += penalty_ * chain_.end_rows.transpose() * chain_.end_rows;
  MatrixXd rows = chain_.end_rows.transpose();  // their sensitivity to y, multipliers free
  end_gram_.setZero(rows.cols(), rows.cols());
  MatrixXd PA, PB, pivot, mixed, driven, held, pulled;
  for (std::size_t k = chain_.stage.size(); k-- > 0;) {
    const ChainStage& stage = chain_.stage[k];
    Gain& gain = gain_[k];
    PB.noalias() = P * stage.B;
    pivot = stage.R;
    pivot.diagonal().array() -= shift * stage.weight;
    pivot.noalias() += stage.B.transpose() * PB;
    const int negative_here = invert_where_free(pivot, gain);
    if (negative_here < 0) return std::nullopt;
    negative += negative_here;
    mixed = stage.S;
    mixed.noalias() += PB.transpose() * stage.A;
    pulled = mixed;  // of the inputs by the states, what is held followed
    if (gain.keeps()) pulled.noalias() += pivot * gain.held_feedback;
    gain.feedback.noalias() = gain.held_feedback - gain.pivot_inverse * pulled;
    driven.noalias() = stage.B.transpose() * rows;
    gain.by_multiplier.noalias() = gain.pivot_inverse * driven;
    end_gram_.noalias() += driven.transpose() * gain.by_multiplier;
    if (k == 0) break;
    PA.noalias() = P * stage.A;
    P = stage.Q;
    P.noalias() += stage.A.transpose() * PA;
    if (gain.keeps()) {
      held.noalias() = gain.held_feedback.transpose() * mixed;
      P += held + held.transpose();
      held.noalias() = pivot * gain.held_feedback;
      P.noalias() += gain.held_feedback.transpose() * held;
    }
    held.noalias() = gain.pivot_inverse * pulled;
    P.noalias() -= pulled.transpose() * held;
    P.triangularView<Eigen::StrictlyUpper>() = P.transpose();  // asymmetry would grow from stage to stage
    rows = (stage.A.transpose() * rows).eval();
    rows.noalias() += gain.feedback.transpose() * driven;
  }
  if (end_gram_.rows() == 0) return negative;
  if (!end_gram_.allFinite()) return std::nullopt;  // no number is not above zero
  // a row that is kept takes away an eigenvalue: a positive one where its part of the inverse is positive. One that the stages' rows
  // imply takes none
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(end_gram_);
  const VectorXd& values = gram.eigenvalues();
  const bool any_kept = std::any_of(gain_.begin(), gain_.end(), [](const Gain& gain) { return gain.keeps(); });
  const double least = any_kept ? implied_row * values.cwiseAbs().maxCoeff() : 0.0;
  VectorXd inverse = VectorXd::Zero(values.size());
  for (Eigen::Index n = 0; n < values.size(); ++n) {
    if (any_kept && std::abs(values[n]) <= least) continue;
    negative -= values[n] <= 0.0 ? 1 : 0;
    inverse[n] = 1.0 / values[n];
  }
  gram_inverse_ = gram.eigenvectors() * inverse.asDiagonal() * gram.eigenvectors().transpose();
  return negative;
}

Inputs ChainSolver::solve(const ChainGradient& gradient) {
  const std::size_t stages = chain_.stage.size();
  Inputs solution(stages);
  VectorXd p = VectorXd::Zero(chain_.end_form.rows()), y = p;  // gradient of what is still to come, without multiplier
  for (std::size_t k = stages; k-- > 0;) {
    const ChainStage& stage = chain_.stage[k];
    const VectorXd force = gradient.by_input[k] + stage.B.transpose() * p;
    solution[k] = -gain_[k].pivot_inverse * force;
    p = (stage.A.transpose() * p + gain_[k].feedback.transpose() * force).eval();
    if (!gradient.by_state.empty()) p += gradient.by_state[k];
  }
  VectorXd reached = VectorXd::Zero(chain_.end_rows.rows());
  const auto follow = [&](bool with_multiplier) {
    y.setZero();
    for (std::size_t k = 0; k < stages; ++k) {
      const ChainStage& stage = chain_.stage[k];
      VectorXd input = solution[k] + gain_[k].feedback * y;
      if (with_multiplier) input -= gain_[k].by_multiplier * multiplier_;
      y = (stage.A * y + stage.B * input).eval();
      if (with_multiplier) solution[k] = input;
    }
    reached = chain_.end_rows * y;
  };
  follow(false);
  multiplier_.resize(reached.size());
  if (reached.size() > 0) multiplier_ = gram_inverse_ * reached;
  follow(true);
  return solution;
}

std::vector<VectorXd> ChainSolver::costates(const ChainGradient& gradient, const Inputs& solution) const {
  const std::size_t stages = chain_.stage.size();
  std::vector<VectorXd> y(stages + 1, VectorXd::Zero(chain_.end_form.rows())), costate(stages + 1);
  for (std::size_t k = 0; k < stages; ++k) {
    const ChainStage& stage = chain_.stage[k];
    y[k + 1] = stage.A * y[k] + stage.B * solution[k];
  }
  costate[stages] = chain_.end_form * y[stages] + chain_.end_rows.transpose() * multiplier_;
  for (std::size_t k = stages; k-- > 0;) {
    const ChainStage& stage = chain_.stage[k];
    const MatrixXd& feedback = gain_[k].feedback;
    // Bᵀ costate is what stationarity in the input says
    const VectorXd force =
        stage.R * solution[k] - shift_ * stage.weight * solution[k] + stage.S * y[k] + gradient.by_input[k];
    costate[k] = stage.A.transpose() * costate[k + 1] + stage.Q * y[k] + stage.S.transpose() * solution[k] +
                 feedback.transpose() * (stage.B.transpose() * costate[k + 1] + force);
    if (!gradient.by_state.empty()) costate[k] += gradient.by_state[k];
  }
  return costate;
}

std::optional<Eigenvector> eigenvector_near(const Chain& chain, ChainSolver& solver, double shift, const Inputs& from) {
  if (solver.factor(shift) != 0) return std::nullopt;
  const double length = std::sqrt(metric_product(chain, from, from));
  if (!(length > 0.0)) return std::nullopt;
  Eigenvector found{from, 0.0};
  for (int n = 0; n < inverse_iterations; ++n) {
    found.inputs = solver.solve(weighed(chain, std::move(found.inputs)));
    const double size = std::sqrt(metric_product(chain, found.inputs, found.inputs));
    if (!(size > 0.0)) return std::nullopt;
    for (VectorXd& input : found.inputs) input /= size;
  }
  found.cosine = metric_product(chain, found.inputs, from) / length;
  return found;
}

SmallestEigenvalue smallest_eigenvalue(const Chain& chain, ChainSolver& solver, const Inputs* set_aside) {
  const int count_aside = set_aside ? 1 : 0;
  const auto definite = [&](double shift) {
    const std::optional<int> below = solver.factor(shift);
    return below && *below <= count_aside;
  };
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double bound = 0.0;
  for (double next = first_shift; !definite(bound); next *= shift_growth) {
    bound = next;
    if (bound < farthest_shift) return {unknown, unknown};
  }

  // Lanczos: the largest eigenvalue of (form − bound · metric)⁻¹ metric
  std::vector<Inputs> basis;
  std::vector<double> diagonal, beside;
  Inputs next = solver.solve(weighed(chain, scattered(chain)));
  double value = std::numeric_limits<double>::infinity();
  for (int n = 0; n < most_lanczos_steps; ++n) {
    if (set_aside) remove(chain, *set_aside, next);
    const double size = std::sqrt(metric_product(chain, next, next));
    if (n > 0) {
      if (!(size > 1e-13 * diagonal.front())) break;  // the whole space is spanned
      beside.push_back(size);
    } else if (!(size > 0.0)) {
      return {unknown, bound};  // no input keeps the end rows
    }
    for (VectorXd& input : next) input /= size;
    basis.push_back(next);
    next = solver.solve(weighed(chain, basis.back()));
    diagonal.push_back(metric_product(chain, basis.back(), next));
    for (int pass = 0; pass < 2; ++pass)
      for (const Inputs& before : basis) add(-metric_product(chain, before, next), before, next);
    const auto count = static_cast<Eigen::Index>(diagonal.size());
    const VectorXd main = Eigen::Map<const VectorXd>(diagonal.data(), count);
    const VectorXd side = Eigen::Map<const VectorXd>(beside.data(), count - 1);
    Eigen::SelfAdjointEigenSolver<MatrixXd> tridiagonal;
    tridiagonal.computeFromTridiagonal(main, side, Eigen::EigenvaluesOnly);
    const double before = value;
    value = bound + 1.0 / tridiagonal.eigenvalues()[count - 1];
    if (n > 8 && std::abs(before - value) <= settled_value * std::max(std::abs(value - bound), std::abs(value))) break;
  }

  // from below: by definiteness
  double width = std::max(bracket * std::abs(value), least_bracket);
  double trial = value - width;
  for (int n = 0; n < most_halvings && value - bound > width; ++n) {
    if (trial > bound) (definite(trial) ? bound : value) = trial;
    trial = 0.5 * (bound + value);
    width = std::max(bracket * std::abs(value), least_bracket);
  }
  return {value, bound};
}

}  // namespace lamprey::optimality
