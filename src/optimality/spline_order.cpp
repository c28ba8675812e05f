#include "optimality/spline_order.hpp"

#include <cstdint>

#include <Eigen/Eigenvalues>

#include "algebra/row_space.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/second_order.hpp"

namespace lamprey::optimality {

namespace {

using model::at;

constexpr int most_spans = 20;                 // a growth of 1e20 over the whole is 10 over each
constexpr double dependent_condition = 1e-10;  // of the longest row: what few points cannot tell apart
constexpr double singular_metric = 1e-14;      // of its largest eigenvalue

// The chain in the splines' coefficients and the states at the beginnings of its spans, which have to fit the spans
// before them. Coefficients come first, in units of the moments' mean size.
class SpannedChain {
 public:
  SpannedChain(const StoredMotion& motion, const EffortChain& effort)
      : controls_(effort.input.rows()),
        reached_(effort.basis.back().cols()),
        stages_(static_cast<int>(effort.input.cols())),
        spans_(std::min(most_spans, stages_)),
        weights_(node_weights(motion)),
        basis_(evidence::control_space(motion).basis) {
    basis_ *= std::sqrt(effort.input.squaredNorm() / static_cast<double>(effort.input.cols()));
  }

  Eigen::Index coefficients() const { return controls_ * basis_.cols(); }
  Eigen::Index unknowns() const { return coefficients() + reached_ * (spans_ - 1); }
  int spans() const { return spans_; }
  int first_stage(int span) const { return static_cast<int>(std::int64_t{stages_} * span / spans_); }

  // Moments of a stage by the coefficients, [controls][coefficients].
  MatrixXd moments(int stage) const {
    MatrixXd result = MatrixXd::Zero(controls_, coefficients());
    for (Eigen::Index p = 0; p < basis_.cols(); ++p)
      result.middleCols(controls_ * p, controls_).diagonal().setConstant(basis_(stage, p));
    return result;
  }

  // What the unknowns that act in a span, coefficients and then the state at its beginning, make of the state at each
  // stage's beginning; `visit` sees it, the end is returned. [reached][own unknowns]
  template <class Visit>
  MatrixXd follow(const Chain& chain, int span, Visit visit) const {
    MatrixXd state = MatrixXd::Zero(reached_, own_unknowns(span));
    if (span > 0) state.rightCols(reached_).setIdentity();
    for (int k = first_stage(span); k < first_stage(span + 1); ++k) {
      visit(k, state);
      const ChainStage& stage = chain.stage[at(k)];
      state = (stage.A * state).eval();
      state.leftCols(coefficients()) += stage.B * moments(k);
    }
    return state;
  }

  // Entries of a span's own unknowns in rows by all of them.
  void add_columns(int span, const MatrixXd& own, Eigen::Ref<MatrixXd> all) const {
    all.leftCols(coefficients()) += own.leftCols(coefficients());
    if (span > 0) all.middleCols(place(span), reached_) += own.rightCols(reached_);
  }

  // Likewise of a form.
  void add_form(int span, const MatrixXd& own, MatrixXd& all) const {
    const Eigen::Index few = coefficients();
    all.topLeftCorner(few, few) += own.topLeftCorner(few, few);
    if (span == 0) return;
    all.block(0, place(span), few, reached_) += own.topRightCorner(few, reached_);
    all.block(place(span), 0, reached_, few) += own.bottomLeftCorner(reached_, few);
    all.block(place(span), place(span), reached_, reached_) += own.bottomRightCorner(reached_, reached_);
  }

  // What the unknowns have to keep: spans that fit together, and the goal.
  MatrixXd conditions(const Chain& chain) const {
    MatrixXd rows = MatrixXd::Zero(reached_ * (spans_ - 1) + chain.end_rows.rows(), unknowns());
    for (int span = 0; span < spans_; ++span) {
      const MatrixXd end = follow(chain, span, [](int, const MatrixXd&) {});
      if (span + 1 == spans_) {
        add_columns(span, chain.end_rows * end, rows.bottomRows(chain.end_rows.rows()));
        continue;
      }
      auto tie = rows.middleRows(reached_ * span, reached_);
      add_columns(span, end, tie);
      tie.middleCols(place(span + 1), reached_) -= MatrixXd::Identity(reached_, reached_);
    }
    return rows;
  }

  // Costates at the stages' beginnings and the end, along the bases, from the multipliers of the conditions.
  std::vector<VectorXd> costates(const Chain& chain, const VectorXd& multipliers) const {
    std::vector<VectorXd> result(at(stages_ + 1));
    for (int span = 0; span < spans_; ++span) {
      VectorXd costate = span + 1 < spans_
                             ? VectorXd(multipliers.segment(reached_ * span, reached_))
                             : VectorXd(chain.end_rows.transpose() * multipliers.tail(chain.end_rows.rows()));
      result[at(first_stage(span + 1))] = costate;
      for (int k = first_stage(span + 1) - 1; k >= first_stage(span); --k)
        result[at(k)] = costate = (chain.stage[at(k)].A.transpose() * costate).eval();
    }
    return result;
  }

  MatrixXd form(const Chain& chain) const {
    MatrixXd all = MatrixXd::Zero(unknowns(), unknowns());
    for (int span = 0; span < spans_; ++span) {
      MatrixXd own = MatrixXd::Zero(own_unknowns(span), own_unknowns(span));
      MatrixXd half;
      const MatrixXd end = follow(chain, span, [&](int k, const MatrixXd& state) {
        const ChainStage& stage = chain.stage[at(k)];
        const MatrixXd moment = moments(k);
        half.noalias() = stage.Q * state;
        own.noalias() += state.transpose() * half;
        half.noalias() = stage.S * state;
        half.leftCols(coefficients()) += 0.5 * stage.R * moment;
        const MatrixXd mixed = moment.transpose() * half;
        own.topRows(coefficients()) += mixed;
        own.leftCols(coefficients()) += mixed.transpose();
      });
      if (span + 1 == spans_) own += end.transpose() * chain.end_form * end;
      add_form(span, own, all);
    }
    return all;
  }

  // Of the effort, [coefficients]².
  MatrixXd metric() const {
    const MatrixXd gram = basis_.transpose() * weights_.asDiagonal() * basis_;
    MatrixXd result = MatrixXd::Zero(coefficients(), coefficients());
    for (Eigen::Index p = 0; p < gram.rows(); ++p)
      for (Eigen::Index q = 0; q < gram.cols(); ++q)
        result.block(controls_ * p, controls_ * q, controls_, controls_).diagonal().setConstant(gram(p, q));
    return result;
  }

  // Of the effort by all unknowns.
  VectorXd gradient(const MatrixXd& moments) const {
    VectorXd result = VectorXd::Zero(unknowns());
    result.head(coefficients()) = (moments * weights_.asDiagonal() * basis_).reshaped();
    return result;
  }

 private:
  Eigen::Index own_unknowns(int span) const { return coefficients() + (span > 0 ? reached_ : 0); }
  Eigen::Index place(int span) const { return coefficients() + reached_ * (span - 1); }

  Eigen::Index controls_, reached_;
  int stages_, spans_;
  VectorXd weights_;  // [stages]
  MatrixXd basis_;    // [stages][points]
};

// Eigenvalues of a form against a metric, ascending; empty where the metric is singular.
VectorXd eigenvalues(const MatrixXd& form, const MatrixXd& metric) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> split(metric);
  const VectorXd& sizes = split.eigenvalues();
  if (!(sizes[0] > singular_metric * sizes[sizes.size() - 1])) return {};
  const MatrixXd unit = split.eigenvectors() * sizes.cwiseSqrt().cwiseInverse().asDiagonal();
  const MatrixXd half = form * unit;
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(unit.transpose() * half, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace

std::optional<SecondOrder> second_order_on_splines(const StoredMotion& motion, EffortChain effort) {
  const SpannedChain spanned(motion, effort);
  const MatrixXd all = spanned.conditions(effort.chain);
  const std::vector<int> independent = algebra::independent_rows(all, dependent_condition);
  const MatrixXd conditions = all(independent, Eigen::all);
  if (conditions.rows() >= conditions.cols()) return std::nullopt;  // nothing is left to vary
  const VectorXd gradient = spanned.gradient(effort.input);
  VectorXd multipliers = VectorXd::Zero(all.rows());
  multipliers(independent) = algebra::least_squares(conditions.transpose(), -gradient);
  Costates costates;
  costates.residual =
      (gradient + all.transpose() * multipliers).lpNorm<Eigen::Infinity>() / gradient.lpNorm<Eigen::Infinity>();
  if (!(costates.residual <= costates_hold)) return std::nullopt;
  const std::vector<VectorXd> nothing(effort.basis.size(), VectorXd::Zero(effort.tangents.scale.size()));
  spread_costates(effort, spanned.costates(effort.chain, multipliers), nothing, costates);
  const Chain chain = lagrangian_chain(motion, std::move(effort), costates, {});

  const MatrixXd kept = algebra::null_space(conditions);
  const MatrixXd half = spanned.form(chain) * kept;
  const MatrixXd few = kept.topRows(spanned.coefficients());
  const MatrixXd few_half = spanned.metric() * few;
  const VectorXd values = eigenvalues(kept.transpose() * half, few.transpose() * few_half);
  if (values.size() == 0 || !values.allFinite()) return std::nullopt;
  return SecondOrder{values[0], values[0] > curvature_mark,
                     static_cast<int>((values.array() < -curvature_mark).count())};
}

}  // namespace lamprey::optimality
