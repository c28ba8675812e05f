// What limits and costs beside effort add to the model of a motion of shapes.
#include <algorithm>

#include "optimizer/small_dense.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::shape {

using model::at;
using optimizer::Stage;
using optimizer::StageModel;
using optimizer::StageStep;

// What the terms add to what the last model holds goes.
void ShapeProgram::prepare_terms(StageModel& model) {
  for (Stage& stage : model.stage) {
    stage.S.setZero();
    stage.A.bottomRows(terms_.states()).setZero();
    stage.B.bottomRows(terms_.states()).setZero();
  }
}

void ShapeProgram::add_term_models(StageModel& model) {
  for (int k = 0; k < steps_; ++k) {
    by_moments_ = now_.moment[at(k)].head(controls_);
    by_moments_ *= node_weight(now_, k);
    terms_.add_by_moments(costed(now_), now_.terms, k, by_moments_);
    model.stage[at(leads_ + k)].gradient =
        std::max(by_moments_.lpNorm<Eigen::Infinity>(), node_weight(now_, k) * least_moment());
  }
  terms_.add_to_model(costed(now_), now_.terms, {leads_, maneuver_.free_duration ? tau() : -1, copies(), own_states()},
                      end_by_state_.topRows(controls_), model);
}

bool ShapeProgram::land() {
  if (limits_.empty()) return false;
  aloft_ = now_;
  limits_.land(now_.limit_value);
  measure(now_);
  return true;
}

void ShapeProgram::take_off() {
  std::swap(now_, aloft_);
  limits_.take_off(now_.limit_value);
  measure(now_);
}

void ShapeProgram::keep_worth() {
  limits_.keep();
  end_kept_ = end_multiplier_;
}

void ShapeProgram::take_kept_worth() {
  limits_.take_kept();
  end_multiplier_ = end_kept_;
  measure(now_);
}

void ShapeProgram::weigh_landed(double times) {
  limits_.renew(now_.limit_value, spent(now_));  // what heavier ones pulled is their multipliers'
  limits_.weigh(times);
  measure(now_);
}

bool ShapeProgram::ease_limits(double times) {
  if (limits_.empty() || !limits_.ease(times)) return false;
  measure(now_);
  return true;
}

// What limits' rows change by along a step.
void ShapeProgram::foresee_limits(const StageStep& step) {
  for (int k = 0; k <= steps_; ++k) {
    if (limits_.of_moments()) foresee_moments(k, step);
    limits_.foresee(k, step.state[at(leads_ + k)].head(limited_states()), by_moments_);
  }
}

// What a node's moments change by along a step, into by_moments_.
void ShapeProgram::foresee_moments(int k, const StageStep& step) {
  by_moments_.setZero();
  if (of_the_end(k)) {
    if (maneuver_.rest || maneuver_.periodic)
      optimizer::add_image(1.0, end_by_state_.topRows(controls_), step.state.back(), by_moments_);
  } else if (by_shapes()) {
    const MatrixXd& moments = moments_of_stage_[at(k)];
    optimizer::add_image(1.0, moments.leftCols(felt()), step.state[at(k)].head(felt()), by_moments_);
    optimizer::add_image(1.0, moments.rightCols(shape_), step.input[at(k)], by_moments_);
  } else {
    by_moments_ = step.input[at(leads_ + k)];
  }
}

void ShapeProgram::bend_gaps(double length, StageModel& model) {
  for (int k = first_idle_node(); k < steps_; ++k) {
    missed_idle_ = trial_.moment[at(k)].tail(idle());
    missed_idle_ -= (1.0 - length) * now_.moment[at(k)].tail(idle());
    missed_idle_ /= length;
    add_gap(k, missed_idle_, model.stage[at(leads_ + k)]);
    idle_bend_[at(k)] += missed_idle_;
  }
}

void ShapeProgram::unbend_gaps(StageModel& model) {
  if (idle() == 0) return;
  for (int k = first_idle_node(); k < steps_; ++k) {
    idle_bend_[at(k)] *= -1.0;
    add_gap(k, idle_bend_[at(k)], model.stage[at(leads_ + k)]);
    idle_bend_[at(k)].setZero();
  }
}

// What makes the next shape the one that leaves no idle moments at node k.
void ShapeProgram::add_gap(int k, const Eigen::Ref<const VectorXd>& idle_moment, Stage& stage) const {
  optimizer::add_image(-1.0, next_by_idle_[at(k)], idle_moment, stage.gap);
}

bool ShapeProgram::bend_limits(const StageStep& step, double length, StageModel& model) {
  if (limits_.empty()) return false;
  foresee_limits(step);
  limits_.compare(now_.limit_value, trial_.limit_value, length);
  add_limit_bends(1.0, model);
  return true;
}

void ShapeProgram::add_limit_bends(double factor, StageModel& model) {
  for (int k = 0; k <= steps_; ++k) {
    VectorXd& q = k == steps_ ? model.q_end : model.stage[at(leads_ + k)].q;
    if (k > 0) limits_.add_bend(k, factor, limited_states(), q);
    if (!limits_.of_moments()) continue;
    by_moments_.setZero();
    limits_.add_bend_by_moments(k, factor, by_moments_);
    if (of_the_end(k)) {
      if (maneuver_.rest || maneuver_.periodic)
        optimizer::add_transposed_image(1.0, end_by_state_.topRows(controls_), by_moments_, model.q_end);
    } else if (by_shapes()) {
      const MatrixXd& moments = moments_of_stage_[at(k)];
      optimizer::add_transposed_image(1.0, moments.rightCols(shape_), by_moments_, model.stage[at(k)].r);
      if (k > 0) optimizer::add_transposed_image(1.0, moments.leftCols(felt()), by_moments_, q.head(felt()));
    } else {
      model.stage[at(leads_ + k)].r += by_moments_;
    }
  }
}

void ShapeProgram::add_limit_models(StageModel& model) const {
  const int size = limited_states();
  for (int k = 1; k <= steps_; ++k) {
    const LimitModel& limited = limit_model_[at(k)];
    if (!limited.any) continue;
    const bool last = k == steps_;
    (last ? model.Q_end : model.stage[at(leads_ + k)].Q).topLeftCorner(size, size) +=
        limited.Q.topLeftCorner(size, size);
    (last ? model.q_end : model.stage[at(leads_ + k)].q).head(size) += limited.q.head(size);
  }
}

void ShapeProgram::model_limits() {
  if (limits_.empty()) return;
  for (int k = 1; k <= steps_; ++k)
    limits_.model(k, limited_node(now_, k), now_.limit_value.col(k), limit_model_[at(k)]);
}

}  // namespace lamprey::shape
