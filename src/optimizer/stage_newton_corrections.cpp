// Steps and directions of StageNewton again, against what their trial points show beyond first order; and the way off saddles.
#include <algorithm>
#include <cmath>
#include <utility>

#include "optimizer/small_dense.hpp"
#include "optimizer/stage_newton.hpp"

namespace lamprey::optimizer {

namespace {

constexpr double correcting_shift = 10.0;  // in units of the states' metric: what hardly changes anything stays
constexpr double bend_unit = 1e8;          // input, more than any step is allowed to take
constexpr int saddle_halvings = 12;
constexpr double saddle_gain = 1e-9;  // least decrease, relative

// States and inputs.
void add_motion(double factor, const StageStep& from, StageStep& to) {
  for (std::size_t k = 0; k < from.state.size(); ++k) algebra::add_multiple(factor, from.state[k], to.state[k]);
  for (std::size_t k = 0; k < from.input.size(); ++k) algebra::add_multiple(factor, from.input[k], to.input[k]);
}

}  // namespace

bool StageNewton::begin_corrections(StageProgram& program) {
  corrected_ = step_;
  corrected_rows_.setZero();
  return !program.has_gaps() || find_gap_response();
}

// What gaps call for is the difference of two steps, with factors that hold motions along which hardly anything changes: with
// those at hand these would be moved most.
bool StageNewton::find_gap_response() {
  own_factors_ = false;
  const double shift = std::max(shift_, correcting_shift);
  if (!riccati_.factor(model_, shift, end_penalty()) && !factor_firmly(shift)) return false;
  riccati_.solve(model_, share_, response_);
  return true;
}

// What the latest trial missed of the end rows beyond the share that its step takes away.
void StageNewton::find_missed(StageProgram& program, double share) {
  missed_ = program.trial_end_rows();
  algebra::add_multiple(length_ * share - 1.0, model_.c, missed_);
  missed_ /= length_;
}

// The step again, against what the latest trial missed of end rows and gaps and found of limits beyond first order.
void StageNewton::correct(StageProgram& program) {
  find_missed(program, share_);
  const bool limits = program.bend_limits(corrected_, length_, model_);
  if (program.has_gaps())
    correct_with_gaps(program);
  else if (limits)
    correct_anew();
  else
    riccati_.correct(model_, missed_, corrected_);
  if (limits) program.unbend_limits(model_);
}

void StageNewton::correct_anew() {
  corrected_rows_ += missed_;
  riccati_.solve(model_, share_, corrected_);
  riccati_.correct(model_, corrected_rows_, corrected_);
}

void StageNewton::correct_with_gaps(StageProgram& program) {
  program.bend_gaps(length_, model_);
  correct_anew();
  add_motion(1.0, step_, corrected_);
  add_motion(-1.0, response_, corrected_);
}

// A direction of negative curvature, which has no gradient and takes no share of the end rows away.
void StageNewton::correct_bend(StageProgram& program) {
  find_missed(program, 0.0);
  if (program.has_gaps())
    correct_with_gaps(program);
  else
    riccati_.correct(model_, missed_, corrected_);
}

// At a saddle: along the negative curvature that the sweep has met, as far as the cost falls, where that promises more than the
// step that was found.
bool StageNewton::leave_saddle(StageProgram& program, Outcome& outcome) {
  const double ordinary = std::max(0.5 * std::abs(slope()), saddle_gain * std::abs(program.merit().cost));
  if (factor_unshifted() || !riccati_.met_curvature()) return false;
  riccati_.bend(model_, bend_unit, step_);
  const Merit here = program.merit();
  const double worth = 2.0 * end_multiplier_.lpNorm<1>();  // of violations, in cost
  double length = program.longest(step_, {});
  const double rate = std::abs(slope()), bend = std::max(-bare_curvature(), 0.0);
  const auto promised = [&] { return length * (rate + 0.5 * length * bend); };  // at most
  const double cheaper = here.cost - saddle_gain * std::abs(here.cost);
  const Merit* there = nullptr;
  const auto leads_down = [&](const StageStep& step) {
    there = program.try_step(step, length_);
    ++outcome.evaluations;
    return there && there->violation <= funnel_ &&
           there->cost + worth * there->violation <= cheaper + worth * here.violation;
  };
  const auto lagrangian = [&] {  // of the trial point
    missed_ = program.trial_end_rows();
    missed_ -= program.end_rows();
    return there->cost + end_multiplier_.dot(missed_);
  };
  bool corrects = false;  // whether the factors are those for it
  for (int halving = 0; halving < saddle_halvings && promised() > ordinary; ++halving, length *= 0.5)
    for (double sign : {1.0, -1.0}) {
      length_ = sign * length;
      bool down = leads_down(step_);
      corrected_ = step_;
      corrected_rows_.setZero();
      // cheaper, but for what it misses
      for (int correction = 0; correction < most_corrections && !down && there && lagrangian() <= cheaper;
           ++correction) {
        if (!std::exchange(corrects, true) && !(program.has_gaps() ? find_gap_response() : factor(damping_)))
          return false;
        correct_bend(program);
        down = leads_down(corrected_);
      }
      program.unbend_gaps(model_);
      if (!down) continue;
      program.accept();
      return true;
    }
  return false;
}

}  // namespace lamprey::optimizer
