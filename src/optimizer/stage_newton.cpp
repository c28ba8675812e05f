#include "optimizer/stage_newton.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "optimizer/small_dense.hpp"

namespace lamprey::optimizer {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double most_end_change = 0.5;  // that one step takes off an end row
constexpr double valley_shift = 1e-4;    // next to a flat valley, so that steps do not run along it
constexpr double gradient_shift = 1.0;   // by which a step is nearly the gradient
constexpr double ran_along =
    0.5;  // of the change before, what a step next to a solution leaves where it runs along a valley
constexpr double flat = 1e-5;            // curvature of a valley, of the effort's own
constexpr double most_multiplier = 1.0;  // that the end rows' removal may add, relative to what they have
constexpr double sufficient = 1e-2;      // share of what the model promises
constexpr double widest_funnel = 0.3;
constexpr double least_funnel = 0.02;
constexpr double funnel_shrink = 0.3;
constexpr double least_idle = 1e-6;  // violation; what a point misses by less that does nothing counts as this
constexpr double widest_idle_share = 0.5,
                 least_idle_share = 0.2;  // of what a point misses that does nothing, as of funnels
constexpr double violation_worth = 0.3;   // of the multipliers: promises beyond it must come true in the cost
constexpr double met = 1e-9;              // violation
constexpr double nearly_met = 1e-5;
constexpr double saddle = 2e-3;             // stationarity at which an indefinite Hessian means a saddle
constexpr double drowned = 1e-6;            // stationarity below which a step's gain is lost in round-off
constexpr double moved_by_weights = 1e-4;   // stationarity that other weights of its rows may leave of a solution
constexpr double last_rise = 1e-9;          // of the cost, relative
constexpr double close = 3e-2;              // stationarity before a step after which its factors may be good for more
constexpr double follow_to = 1e-6;          // of the tolerance, what such steps may leave
constexpr double following = 0.1;           // what a step with old factors may leave of the one before
constexpr double most_shift_at_rest = 1e3;  // beyond, steps are short for the shift's sake
constexpr double short_steps = 3e-3;        // stationarity at which what a little shift adds to costates has faded
constexpr double little_shift = 1.0;
constexpr double worth_going_on = 1e-4;  // what the cost falls by in max_iterations, relative
constexpr double nearer_by = 0.1;        // and violations, while there are any

double round_off(const Merit& merit) { return 1e-13 * std::abs(merit.cost) + merit.round_off; }

// Iterations come in parts: another one is granted where the last one was worth it.
class Patience {
 public:
  Patience(const Merit& begun, const Options& options, int iterations)
      : options_(options), begun_(begun), end_of_part_(iterations + options.max_iterations) {}

  int granted() const { return part_ * options_.max_iterations; }

  bool goes_on(const Merit& here, int iterations) {
    if (iterations < end_of_part_) return true;
    const bool nearer = here.violation < (1.0 - nearer_by) * begun_.violation;
    const bool falls = here.cost < begun_.cost - worth_going_on * std::abs(begun_.cost);
    const bool worth = part_ == 1 || (here.violation > nearly_met ? nearer : falls);
    if (part_ == options_.patience || !worth) return false;
    ++part_;
    end_of_part_ += options_.max_iterations;
    begun_ = here;
    return true;
  }

 private:
  const Options& options_;
  Merit begun_;  // where the part began
  int part_ = 1;
  int end_of_part_;
};

}  // namespace

StageNewton::StageNewton(const StageSizes& sizes)
    : sizes_(sizes),
      model_(sizes),
      riccati_(sizes),
      step_(sizes),
      corrected_(sizes),
      response_(sizes),
      slopes_(sizes),
      state_(sizes.states),
      input_(sizes.inputs),
      missed_(sizes.end_rows),
      corrected_rows_(sizes.end_rows) {}

void StageNewton::solve_model(double share) {
  riccati_.solve(model_, share, step_);
  if (with_costates_) riccati_.find_costates(step_);
}

// Of the end rows a step takes away as much as does not cost more than a few times what they cost already: where the
// Hessian is shifted, multipliers of the whole would be those of the shift.
void StageNewton::find_step() {
  share_ = 1.0;
  const double largest = sizes_.end_rows > 0 ? model_.c.lpNorm<Eigen::Infinity>() : 0.0;
  if (largest > most_end_change) share_ = most_end_change / largest;
  if (largest > 0.0) riccati_.end_response(model_.c, missed_);
  if (shift_ > 0.0 && largest > 0.0) {
    end_multiplier_ = riccati_.look_back(model_, 0.0);
    const double added = missed_.lpNorm<Eigen::Infinity>();
    const double bearable = most_multiplier * std::max(end_multiplier_.lpNorm<Eigen::Infinity>(), highest_cost_);
    if (share_ * added > bearable) share_ = bearable / added;
  }
  solve_model(share_);
  step_.shifted = shift_ > 0.0;
  end_multiplier_ = step_.end_multiplier;
  if (largest > 0.0) algebra::add_multiple(-share_, missed_, end_multiplier_);
}

// How much of what the model promises came true: of the cost, or of violations where these matter more; negative where
// the trial point is no better.
double StageNewton::judge(const Merit& here, const Merit* there, double cheaper) {
  by_cost_ = false;
  if (!there) return -1.0;
  const double noise = round_off(here);
  const double ratio = (here.cost - there->cost + noise) / (std::max(cheaper, 0.0) + noise);
  by_cost_ = there->violation <= funnel_ && cheaper > 0.0 && ratio > sufficient;
  if (by_cost_) return ratio;
  if (cheaper > violation_worth * end_multiplier_.lpNorm<1>() * here.violation) return -1.0;
  const double nearer = length_ * share_ * here.violation;
  if (nearer == 0.0 || there->violation > here.violation - sufficient * nearer) return -1.0;
  return std::min((here.violation - there->violation) / nearer, 1.0);
}

// Tries the longest sensible step, corrected to second order where it misses the end rows; leaves the program at the
// trial point.
double StageNewton::try_out(StageProgram& program, Outcome& outcome) {
  const Merit here = program.merit();
  own_factors_ = true;
  const double rate = here.gaps - slope(), bend = curvature();
  length_ =
      program.longest(step_, {std::max(rate, bend), bend});  // for end rows that are met a step may cost something
  const double cheaper = length_ * rate - 0.5 * length_ * length_ * bend;
  gain_drowns_ = std::abs(cheaper) <= round_off(here);
  const Merit* there = program.try_step(step_, length_);
  ++outcome.evaluations;
  double found = judge(here, there, cheaper);
  if (!there || found > good_ratio) return found;
  found = try_corrected(program, here, cheaper, found, outcome);
  program.unbend_gaps(model_);
  return found;
}

// Of corrections of the step, which come nearer to what its model says as long as they do.
double StageNewton::try_corrected(StageProgram& program, const Merit& here, double cheaper, double found,
                                  Outcome& outcome) {
  if (!begin_corrections(program)) return found;
  for (int correction = 0; correction < most_corrections; ++correction) {
    correct(program);
    const Merit* there = program.try_step(corrected_, length_);
    ++outcome.evaluations;
    const double corrected = judge(here, there, cheaper);
    if (corrected > good_ratio) return corrected;
    if (!there || corrected <= found) return corrected;  // to go back to the plain step wins nothing on the whole
    found = corrected;
  }
  return found;
}

// At a solution what a step gains drowns in round-off: it is taken wherever it keeps what is met, or meets it better by far.
void StageNewton::take_last_step(StageProgram& program, Outcome& outcome) {
  const Merit here = program.merit();
  const double length = program.longest(step_, {});
  const Merit* there = program.try_step(step_, length);
  ++outcome.evaluations;
  if (!there || there->violation > met) return;
  const bool nearer = there->violation < following * here.violation;
  if (!nearer && !(there->cost <= here.cost + last_rise * std::abs(here.cost))) return;
  program.accept();
  if (program.limited()) program.take_multipliers(step_, length);
}

// Where no step shows progress any more because what it gains drowns in round-off: a last one, without a shift, of no more than
// a given change.
bool StageNewton::settle(StageProgram& program, double most_change, Outcome& outcome) {
  if (program.merit().violation > met) return false;
  if (valley_ > 0.0) {
    if (!find_step_beside_valley()) return false;
  } else {
    if (!factor_unshifted()) return false;
    shift_ = 0.0;
    find_step();
    change_ = stationarity();
  }
  if (!(change_ <= most_change)) return false;
  take_last_step(program, outcome);
  return true;
}

// The Lagrangian's gradient by the inputs, states following them.
void StageNewton::take_gradient() {
  VectorXd& costate = state_;
  costate = slopes_.q_end;
  add_transposed_image(1.0, slopes_.C, multiplier_, costate);
  for (std::size_t k = model_.stage.size(); k-- > 0;) {
    const StageSlopes::Slope& slope = slopes_.stage[k];
    Stage& stage = model_.stage[k];
    stage.r = slope.r;
    add_transposed_image(1.0, slope.B, costate, stage.r);
    stage.q = slope.q;
    add_transposed_image(1.0, slope.A, costate, stage.q);
    costate.swap(stage.q);
    stage.q.setZero();
  }
  model_.q_end.setZero();
  model_.c = slopes_.c;
}

// After a Newton step next to a solution: its factors are good for more steps, for which only first derivatives are taken
// anew. Returns whether they arrive; where they do not, the search goes on from there.
bool StageNewton::follow(StageProgram& program, const Options& options, Outcome& outcome) {
  if (!own_factors_ || shift_ > 0.0 || share_ < 1.0 || length_ < 1.0 || change_ > close) return false;
  while (program.differentiate(slopes_)) {
    multiplier_ = step_.end_multiplier;
    take_gradient();
    solve_model(1.0);
    step_.end_multiplier += multiplier_;
    const double before = change_;
    change_ = stationarity();
    if (!(change_ <= following * before)) return false;
    const double violation = program.merit().violation;
    const Merit* there = program.try_step(step_, 1.0);
    ++outcome.evaluations;
    if (!there || there->violation > std::max(met, violation)) return false;
    program.accept();
    program.take_multipliers(step_, 1.0);
    const double ratio = change_ / before, enough = follow_to * options.tolerance;
    if (ratio * change_ <= enough && there->violation <= met) return true;
    record(program, outcome);
    if (ratio * ratio * change_ > enough) return false;  // a Newton step is nearer than two of these
  }
  return false;
}

void StageNewton::record(const StageProgram& program, Outcome& outcome) const {
  ++outcome.iterations;
  outcome.history.push_back({outcome.iterations, program.cost(), program.merit().violation, change_,
                             program.goal_error(), length_, program.drift()});
}

// Whether the step next to a solution runs along a flat valley of solutions, as of gaits that may begin anywhere along themselves.
bool StageNewton::runs_along_valley(const StageProgram& program, double change_before) {
  if (shift_ > 0.0 || !near_ || program.merit().violation > met) return false;
  return change_ < nearly_stationary && change_ > ran_along * change_before &&
         bare_curvature() < flat * effort_of_step();
}

// How far along a valley a Newton step goes says nothing: the gradient is measured by one that is shifted far, and the step
// taken by one that is shifted a little.
bool StageNewton::find_step_beside_valley() {
  if (!factor(gradient_shift)) return false;
  find_step();
  change_ = stationarity();
  if (!factor(std::max(damping_, valley_))) return false;
  find_step();
  return true;
}

// The step from the model, and what of the gradient is left.
bool StageNewton::find_measured_step(const StageProgram& program) {
  if (valley_ > 0.0) return find_step_beside_valley();
  if (!factor(damping_)) return false;
  find_step();
  const double before = std::exchange(change_, stationarity());
  if (!runs_along_valley(program, before)) return true;
  valley_ = valley_shift;
  return find_step_beside_valley();
}

// One step from the model at the point.
StageNewton::Verdict StageNewton::improve(StageProgram& program, const Options& options, Outcome& outcome) {
  if (!find_measured_step(program)) return Verdict::stuck;
  const bool settled = change_ <= options.tolerance && program.merit().violation <= met && shift_ <= most_shift_at_rest;
  if (shift_ > valley_ && change_ <= saddle && program.merit().violation <= nearly_met) {
    if (std::exchange(may_be_saddle_, false) && leave_saddle(program, outcome)) return Verdict::accepted;
    if (!factor(settled ? 0.0 : damping_)) return Verdict::stuck;  // what damps the search has no part in the last step
    find_step();
  }
  if (settled) {
    if (shift_ <= valley_) take_last_step(program, outcome);
    return Verdict::converged;
  }
  const double before = program.merit().violation;
  const double ratio = try_out(program, outcome);
  ease_or_damp(ratio);
  if (!(ratio > sufficient)) {
    const bool at_rest = gain_drowns_ && change_ <= drowned && before <= met;
    return damping_ < largest_shift && !at_rest ? Verdict::rejected : Verdict::stuck;
  }
  program.accept();
  near_ = change_ < nearly_stationary;
  if (!by_cost_)
    funnel_ = std::max({std::min(least_funnel, least_idle_share * idle_violation_), funnel_shrink * funnel_,
                        0.5 * (before + program.merit().violation)});
  const double idle = widest_idle_share * idle_violation_;  // once nearer than that, not so far again
  if (idle < widest_funnel) funnel_ = std::min(funnel_, std::max(idle, program.merit().violation));
  if (shift_ > 0.0) step_.end_multiplier = end_multiplier_;
  if (change_ < short_steps && shift_ <= little_shift) step_.shifted = false;
  program.take_multipliers(step_, length_);
  return Verdict::accepted;
}

void StageNewton::begin(const StageProgram& program) {
  factored_ = false;
  with_costates_ = program.takes_costates();
  riccati_.want_costates(with_costates_);
  damping_ = valley_ = 0.0;
  unshifted_first_ = firm_ = false;
  change_ = 1.0;
  near_ = false;
  highest_cost_ = std::max(std::abs(program.merit().cost), 1e-300);
  const double idle = program.idle_violation();
  idle_violation_ = idle < small_violation ? std::max(idle, least_idle) : std::numeric_limits<double>::infinity();
  funnel_ = std::max(std::min(widest_funnel, widest_idle_share * idle_violation_), program.merit().violation);
}

double StageNewton::first_length(StageProgram& program) {
  begin(program);
  program.linearize(model_);
  if (!factor(0.0)) return 0.0;
  find_step();
  return program.longest(step_, {});
}

Outcome StageNewton::solve(StageProgram& program, const Options& options) {
  Outcome outcome;
  solve(program, options, outcome);
  return outcome;
}

// Multipliers of a first step, for a program that has none: without the curvature that they bring.
bool StageNewton::take_first_multipliers(StageProgram& program) {
  program.linearize(model_);
  if (!factor(0.0)) return false;
  find_step();
  step_.end_multiplier = end_multiplier_;
  program.take_multipliers(step_, 1.0);
  return true;
}

void StageNewton::begin_iteration(StageProgram& program) {
  program.linearize(model_);
  highest_cost_ = std::max(highest_cost_, std::abs(program.merit().cost));
  may_be_saddle_ = true;
  small_miss_ = program.merit().violation <= nearly_met;
}

// After the last trial point of an iteration: what more its factors are good for.
StageNewton::Verdict StageNewton::end_iteration(StageProgram& program, const Options& options, Verdict verdict,
                                                Outcome& outcome) {
  if (verdict == Verdict::accepted) {
    record(program, outcome);
    if (follow(program, options, outcome)) verdict = Verdict::converged;
  }
  if (verdict == Verdict::stuck && settle(program, drowned, outcome)) verdict = Verdict::converged;
  factored_ = verdict == Verdict::converged && shift_ == 0.0;
  if (verdict == Verdict::converged) multiplier_ = step_.end_multiplier;
  return verdict;
}

void StageNewton::solve(StageProgram& program, const Options& options, Outcome& outcome) {
  const auto began = Clock::now();
  const auto finish = [&](Termination termination, const char* reason) {
    outcome.termination = termination;
    outcome.reason = reason;
    outcome.objective = program.cost();
    outcome.infeasibility = program.merit().violation;
  };
  const auto give_up_after = [&](int iterations) {
    finish(Termination::stalled, "no convergence within ");
    outcome.reason.append(std::to_string(iterations)).append(" iterations");
  };
  bool interrupted = false;
  const auto stopped = [&] {
    interrupted = options.interrupted && options.interrupted();
    return interrupted || options.late(std::chrono::duration<double>(Clock::now() - began).count());
  };
  Patience patience(program.merit(), options, outcome.iterations);
  begin(program);
  if (!program.has_multipliers() && !take_first_multipliers(program))
    return finish(Termination::stalled, "the first motion leads nowhere");
  while (true) {
    begin_iteration(program);
    Verdict verdict = improve(program, options, outcome);
    while (verdict == Verdict::rejected && !stopped()) verdict = improve(program, options, outcome);
    verdict = end_iteration(program, options, verdict, outcome);
    if (verdict == Verdict::converged) return finish(Termination::converged, "converged");
    if (verdict == Verdict::stuck)
      return finish(program.merit().violation <= met ? Termination::feasible : Termination::stalled,
                    "no step makes progress any more");
    if (stopped())
      return interrupted ? finish(Termination::interrupted, "interrupted")
                         : finish(Termination::time_limit, "the time limit was reached");
    if (outcome.iterations >= options.most_iterations) return give_up_after(options.most_iterations);
    if (!patience.goes_on(program.merit(), outcome.iterations)) return give_up_after(patience.granted());
  }
}

bool StageNewton::step_once_more(StageProgram& program, Outcome& outcome) {
  program.linearize(model_);
  factored_ = settle(program, moved_by_weights, outcome);
  if (factored_) multiplier_ = step_.end_multiplier;
  return factored_;
}

bool StageNewton::foresee(StageProgram& program) {
  if (!factored_) return false;
  for (Stage& stage : model_.stage) {  // the gradient is gone
    stage.q.setZero();
    stage.r.setZero();
  }
  model_.q_end.setZero();
  model_.c = program.end_rows();
  solve_model(1.0);
  step_.end_multiplier += multiplier_;
  length_ = program.longest(step_, {});
  if (!program.try_step(step_, length_)) return false;
  program.accept();
  program.take_multipliers(step_, length_);
  return true;
}

}  // namespace lamprey::optimizer
