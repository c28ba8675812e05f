#include "optimizer/riccati.hpp"

#include <cmath>
#include <utility>

namespace lamprey::optimizer {

namespace {

constexpr std::size_t at(int n) { return static_cast<std::size_t>(n); }

// In-place lower Cholesky factor. Returns the first column whose pivot is not positive, or the number of columns.
Eigen::Index cholesky(MatrixXd& m) {
  const Eigen::Index size = m.rows();
  for (Eigen::Index c = 0; c < size; ++c) {
    const double pivot = m(c, c) - m.row(c).head(c).squaredNorm();
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return c;
    const double root = std::sqrt(pivot);
    m(c, c) = root;
    for (Eigen::Index r = c + 1; r < size; ++r) m(r, c) = (m(r, c) - m.row(r).head(c).dot(m.row(c).head(c))) / root;
  }
  return size;
}

template <typename Target>
void solve_factored(const MatrixXd& factor, Target& x) {
  factor.triangularView<Eigen::Lower>().solveInPlace(x);
  factor.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
}

}  // namespace

StageModel::StageModel(const StageSizes& z)
    : stage(at(z.stages)),
      Q_end(MatrixXd::Zero(z.states, z.states)),
      q_end(VectorXd::Zero(z.states)),
      metric_end(MatrixXd::Zero(z.states, z.states)),
      C(MatrixXd::Zero(z.end_rows, z.states)),
      c(VectorXd::Zero(z.end_rows)) {
  for (Stage& s : stage)
    s = {MatrixXd::Zero(z.states, z.states), MatrixXd::Zero(z.states, z.inputs), VectorXd::Zero(z.states),
         MatrixXd::Zero(z.states, z.states), MatrixXd::Zero(z.inputs, z.states), MatrixXd::Zero(z.inputs, z.inputs),
         VectorXd::Zero(z.states),           VectorXd::Zero(z.inputs),           1.0,
         MatrixXd::Zero(z.states, z.states), MatrixXd(),                         MatrixXd()};
}

StageStep::StageStep(const StageSizes& z)
    : state(at(z.stages + 1), VectorXd::Zero(z.states)),
      input(at(z.stages), VectorXd::Zero(z.inputs)),
      costate(at(z.stages + 1), VectorXd::Zero(z.states)),
      end_multiplier(VectorXd::Zero(z.end_rows)) {}

Riccati::Riccati(const StageSizes& z)
    : sizes_(z),
      gain_(at(z.stages + 1)),
      PA_(z.states, z.states),
      PB_(z.states, z.inputs),
      end_gram_(z.end_rows, z.end_rows),
      ahead_(z.states),
      state_(z.states),
      input_(z.inputs) {
  for (Gain& g : gain_)
    g = {MatrixXd(z.states, z.states),
         MatrixXd(z.inputs, z.inputs),
         MatrixXd(z.inputs, z.states),
         MatrixXd(z.states, z.end_rows),
         MatrixXd(z.inputs, z.end_rows),
         VectorXd(z.states),
         VectorXd(z.inputs)};
}

bool Riccati::factor(const StageModel& model, double shift, double penalty) {
  penalty_ = penalty;
  Gain& last = gain_.back();
  last.P = model.Q_end;
  if (shift > 0.0) last.P += shift * model.metric_end;
  last.P.noalias() += penalty * model.C.transpose() * model.C;
  last.end = model.C.transpose();
  end_gram_.setZero();
  for (int k = sizes_.stages - 1; k >= 0; --k) {
    const Stage& stage = model.stage[at(k)];
    const Gain& next = gain_[at(k + 1)];
    Gain& gain = gain_[at(k)];
    PB_.noalias() = next.P * stage.B;
    PA_.noalias() = next.P * stage.A;
    const bool shifted_inputs = shift > 0.0 && stage.metric_input.size() > 0;
    gain.factor = stage.R;
    if (shifted_inputs) gain.factor += shift * stage.metric_input;
    gain.factor.noalias() += stage.B.transpose() * PB_;
    if (const Eigen::Index column = cholesky(gain.factor); column < sizes_.inputs) {
      failed_stage_ = k;
      failed_input_.setZero(sizes_.inputs);
      failed_input_[column] = 1.0;
      auto before = failed_input_.head(column);
      before = -gain.factor.row(column).head(column).transpose();
      gain.factor.topLeftCorner(column, column).triangularView<Eigen::Lower>().transpose().solveInPlace(before);
      return false;
    }
    gain.feedback = stage.S;
    if (shifted_inputs) gain.feedback += shift * stage.metric_mixed;
    gain.feedback.noalias() += PB_.transpose() * stage.A;
    const auto L = std::as_const(gain.factor).triangularView<Eigen::Lower>();
    L.solveInPlace(gain.feedback);
    gain.P = stage.Q;
    if (shift > 0.0) gain.P += shift * stage.metric;
    gain.P.noalias() += stage.A.transpose() * PA_;
    gain.P.noalias() -= gain.feedback.transpose() * gain.feedback;
    gain.P.triangularView<Eigen::StrictlyUpper>() = gain.P.transpose();  // asymmetry would grow from stage to stage
    L.transpose().solveInPlace(gain.feedback);
    gain.feedback = -gain.feedback;
    gain.end_input.noalias() = stage.B.transpose() * next.end;
    gain.end.noalias() = stage.A.transpose() * next.end;
    gain.end.noalias() += gain.feedback.transpose() * gain.end_input;
    L.solveInPlace(gain.end_input);
    end_gram_.noalias() += gain.end_input.transpose() * gain.end_input;
    L.transpose().solveInPlace(gain.end_input);
  }
  end_solver_.compute(end_gram_);
  return sizes_.end_rows == 0 || end_solver_.info() == Eigen::Success;
}

const VectorXd& Riccati::look_back(const StageModel& model, double share) {
  target_ = share * model.c;
  gain_.back().p = model.q_end + penalty_ * (model.C.transpose() * target_);
  reached_ = target_;  // C s_N + target, before the end rows' multipliers act
  for (int k = sizes_.stages - 1; k >= 0; --k) {
    const Stage& stage = model.stage[at(k)];
    const Gain& next = gain_[at(k + 1)];
    Gain& gain = gain_[at(k)];
    ahead_.noalias() = next.P * stage.gap;
    ahead_ += next.p;
    input_ = -stage.r;
    input_.noalias() -= stage.B.transpose() * ahead_;
    gain.p = stage.q;
    gain.p.noalias() += stage.A.transpose() * ahead_;
    gain.p.noalias() -= gain.feedback.transpose() * input_;
    solve_factored(gain.factor, input_);
    gain.input = input_;
    state_ = stage.gap;
    state_.noalias() += stage.B * gain.input;
    reached_.noalias() += next.end.transpose() * state_;
  }
  multiplier_ = end_solver_.solve(reached_);
  return multiplier_;
}

void Riccati::solve(const StageModel& model, double share, StageStep& step) {
  step.end_multiplier = look_back(model, share);
  step.state.front().setZero();
  for (int k = 0; k < sizes_.stages; ++k) follow(model, k, step);
  for (int k = 0; k <= sizes_.stages; ++k) {
    const Gain& gain = gain_[at(k)];
    VectorXd& costate = step.costate[at(k)];
    costate = gain.p;
    costate.noalias() += gain.P * step.state[at(k)];
    costate.noalias() += gain.end * step.end_multiplier;
  }
}

void Riccati::follow(const StageModel& model, int k, StageStep& step) const {
  const Stage& stage = model.stage[at(k)];
  const Gain& gain = gain_[at(k)];
  VectorXd& input = step.input[at(k)];
  input = gain.input;
  input.noalias() += gain.feedback * step.state[at(k)];
  input.noalias() -= gain.end_input * step.end_multiplier;
  VectorXd& next = step.state[at(k + 1)];
  next = stage.gap;
  next.noalias() += stage.A * step.state[at(k)];
  next.noalias() += stage.B * input;
}

void Riccati::bend(const StageModel& model, double size, StageStep& step) const {
  for (VectorXd& state : step.state) state.setZero();
  for (VectorXd& input : step.input) input.setZero();
  for (int k = failed_stage_; k < sizes_.stages; ++k) {
    const Stage& stage = model.stage[at(k)];
    VectorXd& input = step.input[at(k)];
    if (k == failed_stage_)
      input = size * failed_input_;
    else
      input.noalias() = gain_[at(k)].feedback * step.state[at(k)];
    step.state[at(k + 1)].noalias() = stage.A * step.state[at(k)];
    step.state[at(k + 1)].noalias() += stage.B * input;
  }
}

void Riccati::correct(const StageModel& model, const VectorXd& end_rows, StageStep& step) {
  const VectorXd multiplier = end_solver_.solve(end_rows);
  VectorXd state = VectorXd::Zero(sizes_.states);
  for (int k = 0; k < sizes_.stages; ++k) {
    const Stage& stage = model.stage[at(k)];
    const Gain& gain = gain_[at(k)];
    input_.noalias() = gain.feedback * state;
    input_.noalias() -= gain.end_input * multiplier;
    step.input[at(k)] += input_;
    ahead_.noalias() = stage.A * state;
    ahead_.noalias() += stage.B * input_;
    state = ahead_;
    step.state[at(k + 1)] += state;
  }
}

}  // namespace lamprey::optimizer
