// What the linear-quadratic model says of a step of StageNewton: what it changes, at what rate, and how that bends.
#include <algorithm>
#include <cmath>
#include <limits>

#include "optimizer/small_dense.hpp"
#include "optimizer/stage_newton.hpp"

namespace lamprey::optimizer {

namespace {

double along(const VectorXd& left, const MatrixXd& form, const VectorXd& right, VectorXd& buffer) {
  buffer.setZero();
  add_image(1.0, form, right, buffer);
  return left.dot(buffer);
}

}  // namespace

// What the step changes of what a stage's weight measures.
const VectorXd& StageNewton::measured(std::size_t k) {
  const Stage& stage = model_.stage[k];
  if (stage.measured_by_input.size() == 0) return step_.input[k];
  input_.setZero();
  add_image(1.0, stage.measured_by_state, step_.state[k], input_);
  add_image(1.0, stage.measured_by_input, step_.input[k], input_);
  return input_;
}

// What a Newton step still changes in the cost's gradient, relative to that gradient.
double StageNewton::stationarity() {
  double change = 0.0, gradient = 0.0;
  for (std::size_t k = 0; k < model_.stage.size(); ++k) {
    const Stage& stage = model_.stage[k];
    const double moved = stage.weight * measured(k).lpNorm<Eigen::Infinity>();
    if (std::isnan(moved)) return std::numeric_limits<double>::infinity();  // a step of no numbers goes on
    change = std::max(change, moved);
    gradient = std::max(gradient, stage.gradient);
  }
  return change / std::max(gradient, 1e-300);
}

// Rate of the cost along the step.
double StageNewton::slope() const {
  double rate = model_.q_end.dot(step_.state.back());
  for (std::size_t k = 0; k < model_.stage.size(); ++k)
    rate += model_.stage[k].q.dot(step_.state[k]) + model_.stage[k].r.dot(step_.input[k]);
  return rate;
}

// What the effort's own form says of the step.
double StageNewton::effort_of_step() {
  double sum = 0.0;
  for (std::size_t k = 0; k < model_.stage.size(); ++k) sum += model_.stage[k].weight * measured(k).squaredNorm();
  return sum;
}

// sᵀHs along any step, without the shift.
double StageNewton::bare_curvature() {
  double value = along(step_.state.back(), model_.Q_end, step_.state.back(), state_);
  for (std::size_t k = 0; k < model_.stage.size(); ++k) {
    const Stage& stage = model_.stage[k];
    const VectorXd &state = step_.state[k], &input = step_.input[k];
    value += along(state, stage.Q, state, state_) + 2.0 * along(input, stage.S, state, input_) +
             along(input, stage.R, input, input_);
  }
  return value;
}

// The same along a Newton step: its own equations tell it, but where there are gaps.
double StageNewton::curvature() {
  const auto closed = [](const Stage& stage) { return stage.gap.isZero(0.0) && stage.metric_input.size() == 0; };
  const bool told = std::all_of(model_.stage.begin(), model_.stage.end(), closed);
  if (told && shift_ == 0.0) return share_ * step_.end_multiplier.dot(model_.c) - slope();
  if (!told) return bare_curvature();
  double value = 0.0;
  for (std::size_t k = 0; k < model_.stage.size(); ++k)
    value += along(step_.state[k], model_.stage[k].metric, step_.state[k], state_);
  const VectorXd& end = step_.state.back();
  value += along(end, model_.metric_end, end, state_);
  return share_ * step_.end_multiplier.dot(model_.c) - slope() - shift_ * value;
}

}  // namespace lamprey::optimizer
