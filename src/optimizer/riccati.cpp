#include "optimizer/riccati.hpp"

#include <algorithm>
#include <cmath>

#include "optimizer/small_dense.hpp"

namespace lamprey::optimizer {

namespace {

constexpr std::size_t at(int n) { return static_cast<std::size_t>(n); }

}  // namespace

StageModel::StageModel(const StageSizes& z)
    : stage(at(z.stages)),
      Q_end(MatrixXd::Zero(z.states, z.states)),
      q_end(VectorXd::Zero(z.states)),
      metric_end(MatrixXd::Zero(z.states, z.states)),
      C(MatrixXd::Zero(z.end_rows, z.states)),
      c(VectorXd::Zero(z.end_rows)) {
  for (Stage& s : stage) {
    s.A.setZero(z.states, z.states);
    s.B.setZero(z.states, z.inputs);
    s.gap.setZero(z.states);
    s.Q.setZero(z.states, z.states);
    s.S.setZero(z.inputs, z.states);
    s.R.setZero(z.inputs, z.inputs);
    s.q.setZero(z.states);
    s.r.setZero(z.inputs);
    s.metric.setZero(z.states, z.states);
  }
}

StageSlopes::StageSlopes(const StageSizes& z)
    : stage(at(z.stages), {MatrixXd::Zero(z.states, z.states), MatrixXd::Zero(z.states, z.inputs),
                           VectorXd::Zero(z.states), VectorXd::Zero(z.inputs)}),
      q_end(VectorXd::Zero(z.states)),
      C(MatrixXd::Zero(z.end_rows, z.states)),
      c(VectorXd::Zero(z.end_rows)) {}

StageStep::StageStep(const StageSizes& z)
    : state(at(z.stages + 1), VectorXd::Zero(z.states)),
      input(at(z.stages), VectorXd::Zero(z.inputs)),
      costate(at(z.stages + 1), VectorXd::Zero(z.states)),
      end_multiplier(VectorXd::Zero(z.end_rows)) {}

Riccati::Riccati(const StageSizes& z)
    : sizes_(z),
      transposed_(z.states + z.inputs, z.states),
      PA_(z.states, z.states),
      PB_(z.states, z.inputs),
      by_input_(z.end_rows + z.states + z.inputs, z.inputs),
      end_gram_(z.end_rows, z.end_rows),
      end_solver_(z.end_rows),
      ahead_(z.states),
      state_(z.states),
      input_(z.inputs),
      back_(z.end_rows + z.states),
      reached_(z.end_rows),
      multiplier_(z.end_rows),
      placed_sweep_(PlacedSweep::of(z)),
      P_end_(z.states, z.states),
      p_end_(z.states),
      factor_(z.inputs, z.inputs),
      failed_input_(z.inputs) {}

bool Riccati::factor(const StageModel& model, double shift, double penalty) {
  penalty_ = penalty;
  failed_stage_ = -1;
  P_end_ = model.Q_end;
  if (shift > 0.0) algebra::add_multiple(shift, model.metric_end, P_end_);
  algebra::add_product(penalty, model.C.transpose(), model.C, P_end_);
  end_gram_.setZero();
  placed_ = placed_alone(model);
  if (placed_) {
    if (!placed_sweep_->factor(model, shift, P_end_, end_gram_)) {
      failed_stage_ = placed_sweep_->failed_stage();
      placed_sweep_->read_factor(failed_stage_, factor_);
      find_failed_input(factor_, placed_sweep_->failed_input());
      return false;
    }
  } else if (!sweep(model, shift)) {
    return false;
  }
  end_solver_.compute(end_gram_);
  return sizes_.end_rows == 0 || end_solver_.info() == Eigen::Success;
}

// Whether a PlacedSweep takes all stages and nothing will ask for what it does not keep.
bool Riccati::placed_alone(const StageModel& model) const {
  return placed_sweep_ && !with_costates_ &&
         std::all_of(model.stage.begin(), model.stage.end(), [&](const Stage& stage) {
           return stage.shifted == sizes_.inputs && stage.placed == sizes_.inputs && stage.metric_input.size() == 0 &&
                  stage.gap.isZero(0.0);
         });
}

MatrixXd Riccati::feedback(int stage) const {
  if (placed_) return placed_sweep_->feedback(stage);
  return -gain_[at(stage)].by_back.bottomRows(sizes_.states).transpose();
}

// For the first sweep.
void Riccati::make_room() {
  const int n = sizes_.states, m = sizes_.inputs, e = sizes_.end_rows;
  gain_.assign(at(sizes_.stages + 1),
               {MatrixXd(n, n), MatrixXd(m, m), MatrixXd(e + n, m), MatrixXd(e, n), VectorXd(n), VectorXd(m)});
}

bool Riccati::sweep(const StageModel& model, double shift) {
  if (gain_.empty()) make_room();
  gain_.back().P = P_end_;
  gain_.back().end = model.C;
  for (int k = sizes_.stages - 1; k >= 0; --k) {
    Gain& gain = gain_[at(k)];
    carry_hessian(model.stage[at(k)], shift, gain_[at(k + 1)], gain);
    carry_end(model.stage[at(k)], gain_[at(k + 1)], gain);
    if (!eliminate_inputs(gain)) {
      failed_stage_ = k;
      return false;
    }
  }
  return true;
}

// What the stage makes of the Hessian still to come: (A, B)ᵀP(A, B) and its own, before inputs are eliminated.
void Riccati::carry_hessian(const Stage& stage, double shift, const Gain& next, Gain& gain) {
  const int n = sizes_.states, m = sizes_.inputs, shifted = stage.shifted, placed = stage.placed;
  const int rest = n - shifted - placed, seen = seen_states(stage);
  auto transposed = transposed_.leftCols(rest).bottomRows(seen + m);
  set_transposed(stage.A.bottomRows(rest).rightCols(seen), transposed.topRows(seen));
  set_transposed(stage.B.bottomRows(rest), transposed.bottomRows(m));
  auto PA = PA_.rightCols(seen);
  PA.setZero();
  PA_.middleCols(shifted, shifted) = next.P.leftCols(shifted);
  add_product(1.0, next.P.rightCols(rest), stage.A.bottomRows(rest).rightCols(seen), PA);
  if (placed > 0)
    PB_ = next.P.middleCols(shifted, placed);
  else
    PB_.setZero();
  add_product(1.0, next.P.rightCols(rest), stage.B.bottomRows(rest), PB_);

  auto own = by_input_.bottomRows(n + m);
  set_transposed(stage.S, own.topRows(n));
  own.bottomRows(m) = stage.R;
  if (shift > 0.0 && stage.metric_input.size() > 0) {
    algebra::add_multiple(shift, stage.metric_mixed.transpose(), own.topRows(n));
    algebra::add_multiple(shift, stage.metric_input, own.bottomRows(m));
  }
  own.middleRows(shifted, shifted) += PB_.topRows(shifted);
  if (placed > 0) own.bottomRows(m) += PB_.middleRows(shifted, placed);
  add_product(1.0, transposed, PB_.bottomRows(rest), own.bottomRows(seen + m));

  gain.P = stage.Q;
  if (shift > 0.0) algebra::add_multiple(shift, stage.metric, gain.P);
  gain.P.middleRows(shifted, shifted).rightCols(seen) += PA.topRows(shifted);
  add_lower_product(1.0, transposed.topRows(seen), PA.bottomRows(rest), gain.P.bottomRightCorner(seen, seen));
}

// The last states, which do more than move on.
int Riccati::seen_states(const Stage& stage) const {
  return stage.placed > 0 ? sizes_.states - stage.shifted : sizes_.states;
}

void Riccati::carry_end(const Stage& stage, const Gain& next, Gain& gain) {
  const int shifted = stage.shifted, placed = stage.placed, rest = sizes_.states - shifted - placed;
  const auto kept = next.end.rightCols(rest);
  gain.end.setZero();
  gain.end.middleCols(shifted, shifted) = next.end.leftCols(shifted);
  const int seen = seen_states(stage);
  add_product(1.0, kept, stage.A.bottomRows(rest).rightCols(seen), gain.end.rightCols(seen));
  auto by_input = by_input_.topRows(sizes_.end_rows);
  if (placed > 0)
    by_input = next.end.middleCols(shifted, placed);
  else
    by_input.setZero();
  add_product(1.0, kept, stage.B.bottomRows(rest), by_input);
}

// Cholesky factor L of the inputs' own block, everything else by inputs times L⁻ᵀ, and what that leaves of states and end
// rows. Returns false at the first pivot that is not positive.
bool Riccati::eliminate_inputs(Gain& gain) {
  const int n = sizes_.states, m = sizes_.inputs, others = sizes_.end_rows + n;
  for (int c = 0; c < m; ++c) {
    const auto row = input_.head(c);
    input_.head(c) = by_input_.row(others + c).head(c).transpose();
    add_image(-1.0, by_input_.leftCols(c), row, by_input_.col(c));
    const double pivot = by_input_(others + c, c);
    if (!(pivot > 0.0) || !std::isfinite(pivot)) {
      find_failed_input(gain.factor, c);
      return false;
    }
    gain.factor(c, c) = 1.0 / std::sqrt(pivot);
    by_input_.col(c) *= gain.factor(c, c);
    gain.factor.col(c).tail(m - 1 - c) = by_input_.col(c).tail(m - 1 - c);
  }
  const auto by_end = by_input_.topRows(sizes_.end_rows);
  const auto by_state = by_input_.middleRows(sizes_.end_rows, n);
  add_lower_product_transposed(-1.0, by_state, by_state, gain.P);
  mirror_lower(gain.P);  // asymmetry would grow from stage to stage
  add_product_transposed(-1.0, by_end, by_state, gain.end);
  add_lower_product_transposed(1.0, by_end, by_end, end_gram_);
  gain.by_back = by_input_.topRows(others);
  for (int c = m - 1; c >= 0; --c) {
    add_image(-1.0, gain.by_back.rightCols(m - 1 - c), gain.factor.col(c).tail(m - 1 - c), gain.by_back.col(c));
    gain.by_back.col(c) *= gain.factor(c, c);
  }
  return true;
}

// The direction in which the pivot of an input says that curvature is negative: those before it make the best of it.
void Riccati::find_failed_input(const MatrixXd& factor, int input) {
  failed_input_.setZero(sizes_.inputs);
  failed_input_[input] = 1.0;
  for (int i = input - 1; i >= 0; --i)
    failed_input_[i] =
        -factor.col(i).segment(i + 1, input - i).dot(failed_input_.segment(i + 1, input - i)) * factor(i, i);
}

const VectorXd& Riccati::look_back(const StageModel& model, double share) {
  const int n = sizes_.states, m = sizes_.inputs, rows = sizes_.end_rows;
  reached_ = model.c;  // C s_N + target, before the end rows' multipliers act
  reached_ *= share;
  p_end_ = model.q_end;
  algebra::add_product(penalty_, model.C.transpose(), reached_, p_end_);
  if (placed_) {
    placed_sweep_->look_back(model, p_end_, reached_);
    multiplier_ = end_solver_.solve(reached_);
    return multiplier_;
  }
  gain_.back().p = p_end_;
  back_.head(rows) = reached_;
  for (int k = sizes_.stages - 1; k >= 0; --k) {
    const Stage& stage = model.stage[at(k)];
    const Gain& next = gain_[at(k + 1)];
    Gain& gain = gain_[at(k)];
    const int shifted = stage.shifted, placed = stage.placed, rest = n - shifted - placed;
    ahead_ = next.p;
    if (!stage.gap.isZero(0.0)) {
      add_image(1.0, next.P, stage.gap, ahead_);
      add_image(1.0, next.end, stage.gap, back_.head(rows));
    }
    input_ = stage.r;
    input_ *= -1.0;
    if (placed > 0) input_ -= ahead_.segment(shifted, placed);
    add_transposed_image(-1.0, stage.B.bottomRows(rest), ahead_.tail(rest), input_);
    back_.tail(n) = stage.q;
    back_.segment(rows + shifted, shifted) += ahead_.head(shifted);
    add_transposed_image(1.0, stage.A.bottomRows(rest), ahead_.tail(rest), back_.tail(n));
    add_image(1.0, gain.by_back, input_, back_);
    gain.p = back_.tail(n);
    // (L Lᵀ)⁻¹
    for (int c = 0; c < m; ++c) {
      input_[c] *= gain.factor(c, c);
      for (int i = c + 1; i < m; ++i) input_[i] -= gain.factor(i, c) * input_[c];
    }
    for (int c = m - 1; c >= 0; --c) {
      for (int i = c + 1; i < m; ++i) input_[c] -= gain.factor(i, c) * input_[i];
      input_[c] *= gain.factor(c, c);
    }
    gain.input = input_;
  }
  reached_ = back_.head(rows);
  multiplier_ = end_solver_.solve(reached_);
  return multiplier_;
}

void Riccati::end_response(const VectorXd& end_rows, VectorXd& multipliers) const {
  multipliers = end_solver_.solve(end_rows);
  algebra::add_multiple(-penalty_, end_rows, multipliers);
}

void Riccati::solve(const StageModel& model, double share, StageStep& step) {
  step.end_multiplier = look_back(model, share);
  step.state.front().setZero();
  follow(model, 0, step.state.front(), step.end_multiplier, true, false, step);
}

void Riccati::correct(const StageModel& model, const VectorXd& end_rows, StageStep& step) {
  multiplier_ = end_solver_.solve(end_rows);
  state_.setZero();
  follow(model, 0, state_, multiplier_, false, true, step);
}

void Riccati::bend(const StageModel& model, double size, StageStep& step) {
  for (VectorXd& state : step.state) state.setZero();
  for (VectorXd& input : step.input) input.setZero();
  const auto failed = at(failed_stage_);
  step.input[failed] = failed_input_;
  step.input[failed] *= size;
  move(model.stage[failed], step.input[failed], step.state[failed], step.state[failed + 1]);
  multiplier_.setZero();
  follow(model, failed_stage_ + 1, step.state[failed + 1], multiplier_, false, false, step);
}

// Inputs and states from a stage on, which begins at `state`, along the feedback: added to a step or put in their place; with
// what gaps and gradients call for, or without.
void Riccati::follow(const StageModel& model, int first, const VectorXd& state, const VectorXd& end_multiplier,
                     bool own_inputs, bool add, StageStep& step) {
  if (placed_) return placed_sweep_->follow(model, first, state, end_multiplier, own_inputs, add, step);
  back_.head(sizes_.end_rows) = end_multiplier;
  back_.tail(sizes_.states) = state;
  for (int k = first; k < sizes_.stages; ++k) {
    const Gain& gain = gain_[at(k)];
    if (own_inputs)
      input_ = gain.input;
    else
      input_.setZero();
    add_transposed_image(-1.0, gain.by_back, back_, input_);
    state_ = back_.tail(sizes_.states);
    move(model.stage[at(k)], input_, state_, ahead_);
    if (own_inputs) ahead_ += model.stage[at(k)].gap;
    back_.tail(sizes_.states) = ahead_;
    VectorXd &input = step.input[at(k)], &next = step.state[at(k + 1)];
    if (add) {
      input += input_;
      next += ahead_;
    } else {
      input = input_;
      next = ahead_;
    }
  }
}

void Riccati::find_costates(StageStep& step) const {
  for (int k = 0; k <= sizes_.stages; ++k) {
    const Gain& gain = gain_[at(k)];
    VectorXd& costate = step.costate[at(k)];
    costate = gain.p;
    add_image(1.0, gain.P, step.state[at(k)], costate);
    add_transposed_image(1.0, gain.end, step.end_multiplier, costate);
  }
}

// The next state without the gap.
void Riccati::move(const Stage& stage, const VectorXd& input, const VectorXd& state, VectorXd& next) const {
  const int shifted = stage.shifted, placed = stage.placed, rest = sizes_.states - shifted - placed;
  next.head(shifted) = state.segment(shifted, shifted);
  if (placed > 0) next.segment(shifted, placed) = input;
  next.tail(rest).setZero();
  add_image(1.0, stage.A.bottomRows(rest), state, next.tail(rest));
  add_image(1.0, stage.B.bottomRows(rest), input, next.tail(rest));
}

}  // namespace lamprey::optimizer
