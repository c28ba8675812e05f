// What limits and costs beside effort add to the model of a motion of shapes.
#include <algorithm>

#include "maneuver/shape_program.hpp"

namespace lamprey::maneuver {

using model::at;
using optimizer::Stage;
using optimizer::StageModel;

// What the terms add to what the last model holds goes.
void ShapeProgram::prepare_terms(StageModel& model) {
  const double time = maneuver_.time_weight * h_ * now_.stretch * steps_, others = now_.terms.cost;
  const double spent = now_.cost + won(now_);
  metric_scale_ *= 1.0 + others / std::max(spent - time - others, 1e-6 * spent);
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
    model.stage[at(leads_ + k)].gradient = by_moments_.lpNorm<Eigen::Infinity>();
  }
  terms_.add_to_model(costed(now_), now_.terms, {leads_, maneuver_.free_duration ? tau() : -1, copies(), own_states()},
                      end_by_state_.topRows(controls_), model);
}

void ShapeProgram::add_limit_models(StageModel& model) const {
  const int size = maneuver_.free_duration ? tau() + 1 : tau();
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

}  // namespace lamprey::maneuver
