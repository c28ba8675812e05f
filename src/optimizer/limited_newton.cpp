#include "optimizer/limited_newton.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace lamprey::optimizer {

namespace {

constexpr int most_rounds = 60;
constexpr int most_landings = 24;                        // sets of limits that hold, before a search returns
constexpr int landing_iterations = 20;                   // with one of them
constexpr double settling_weight = 1e-2;                 // of that of landings
constexpr double landing_share = 0.5;                    // of a set's error, that the next one may leave
constexpr double near_cost = 1e-3;                       // relative, by which its cost may differ where it leaves more
constexpr int most_worse = 3;                            // sets in a row, each of which leaves
constexpr double far_worse = 2.0;                        // times as much as the one before
constexpr int most_idle_sets = 5;                        // from an old answer's on, that are no better than one before
constexpr double slow_share = 0.2;                       // of the error before a landing, from where its weight grows
constexpr double more_weight = 10.0, most_weight = 1e3;  // times it
constexpr double first_landing = 1e-5;                   // error, of other costs' kinks too, from which sets are tried
constexpr double next_landing = 1e-2;                    // of the error before a landing that failed
constexpr int most_idle_rounds = 6;                      // without progress
constexpr double idle_share = 0.7;                       // of the best error so far, that is no progress
constexpr int most_round_iterations = 150;
constexpr double least_tolerance = 1e-11;  // where a search's own error keeps the limits' from falling
constexpr double first_tolerance = 1e-3;   // of a search while the multipliers are still rough
constexpr double tolerance_share = 0.1;    // of the limits' error, that searches are worth
constexpr double out_of_reach = 1e-3;      // limit error that is no matter of a few more rounds
constexpr double astray = 1e-2;            // violation of what is asked at a round's end, of which limits are no cause
constexpr int most_rounds_astray = 3;
constexpr int most_easings = 4;      // of limits, before a search
constexpr double long_enough = 0.5;  // first step, where no more are needed
constexpr double least_easing = 10.0, most_easing = 1e3;

bool gave_up(Termination termination) {
  return termination == Termination::time_limit || termination == Termination::interrupted;
}

// Whether the search has to end here; the outcome then says why.
bool stopped(const Options& options, double seconds, Outcome& outcome) {
  const bool interrupted = options.interrupted && options.interrupted();
  if (!interrupted && !options.late(seconds)) return false;
  outcome.termination = interrupted ? Termination::interrupted : Termination::time_limit;
  outcome.reason = interrupted ? "interrupted" : "the time limit was reached";
  return true;
}

// An old answer's motion stands so near its limits that a step to another goal may hardly move: farther from them it can.
void ease(StageNewton& newton, StageProgram& program) {
  if (!program.pulled_as_answer()) return;
  for (int easing = 0; easing < most_easings; ++easing) {
    const double length = newton.first_length(program);
    if (length > long_enough || !program.ease_limits(std::clamp(1.0 / length, least_easing, most_easing))) return;
  }
}

// A barrier as stiff as at an answer lets no search get far from there: one that is stuck has a weaker one from then on. Returns whether
// it has.
bool ease_where_stuck(StageProgram& program, const Outcome& outcome) {
  const bool stuck = outcome.termination != Termination::converged && outcome.infeasibility > astray;
  return stuck && !program.landed() && program.pulled_as_answer() && program.ease_limits(most_easing);
}

// When a search goes on with the limits that hold as equalities, and when it returns from there.
struct Landing {
  int left;                                                // sets of such limits that are tried
  double from = first_landing;                             // error
  double error = std::numeric_limits<double>::infinity();  // of the last one
  double cost = std::numeric_limits<double>::infinity();   // likewise
  double grown = 1.0;                                      // how many times the weight is that of a landing
  int worse = 0;                                           // sets in a row that left far more than the one before
  bool old = false;                                        // whether the first set was an old answer's
  double best = std::numeric_limits<double>::infinity();   // error of the sets since then
  int idle = 0;                                            // sets since the best one

  bool worth_trying(double found) const { return left > 0 && found < from; }

  // After a round, limits being kept or not: whether the program has landed or taken off.
  bool changes(StageProgram& program, bool kept, bool converged, double found) {
    if (left == 0 || (kept && converged && program.landed())) return false;
    if (!program.landed()) {
      if (!kept || !converged || !worth_trying(found)) return false;
      from = next_landing * found;
      error = cost = std::numeric_limits<double>::infinity();
      grown = 1.0;
      worse = 0;
      if (!program.land()) left = 0;
      return left > 0;
    }
    const double before = std::exchange(error, found);
    worse = found > far_worse * before ? worse + 1 : 0;
    idle = found < best ? 0 : idle + 1;
    best = std::min(best, found);
    const bool lost = worse == most_worse || (old && idle == most_idle_sets);
    if (converged && found < before && found > slow_share * before && grown < most_weight) {
      grown *= more_weight;
      program.weigh_landed(more_weight);
      return false;
    }
    const double cost_before = std::exchange(cost, program.cost()), changed = std::abs(cost - cost_before);
    const bool near = changed > 0.0 && changed <= near_cost * std::abs(cost);  // a node may be all that is missing
    if (--left > 0 && converged && !lost && (found < landing_share * before || near)) return false;
    program.take_off();
    old = false;
    return true;
  }
};

}  // namespace

int most_iterations(const StageProgram& program, const Options& options) {
  return options.patience * (program.limited() ? most_rounds * most_round_iterations : options.max_iterations);
}

namespace {

// What finds the limits that hold brings round-off into their multipliers: a last step at the least weight of theirs, from this one up
// to that of landings, that leaves the Hessian definite.
void settle_landed(StageNewton& newton, StageProgram& program, double least, Outcome& outcome) {
  program.weigh_landed(least);
  for (double weight = least; !newton.step_once_more(program, outcome) && weight < 1.0; weight *= more_weight)
    program.weigh_landed(more_weight);
}

// Where no set of limits that hold was found, and none with more weight, to the answer that a barrier had found before. Returns
// whether it is one.
bool go_back(StageNewton& newton, StageProgram& program, const Options& round, double limit_tolerance,
             Outcome& outcome) {
  program.take_kept_worth();
  newton.solve(program, round, outcome);
  const bool kept = program.limit_violation() <= limit_tolerance, met = program.limit_error() <= limit_tolerance;
  const bool answer = outcome.termination == Termination::converged && kept && met;
  program.renew_limits(!met);
  return answer;
}

// Rounds of searches, between which limits' multipliers and weights are renewed.
class Rounds {
 public:
  Rounds(StageNewton& newton, StageProgram& program, const Options& options, double limit_tolerance, Outcome& outcome)
      : newton_(newton),
        program_(program),
        options_(options),
        limit_tolerance_(limit_tolerance),
        outcome_(outcome),
        round_(options),
        finest_(options.tolerance) {
    landing_.left = options.exact_limits ? most_landings : 0;
    landing_.old = program.landed();
    if (landing_.old) program.land();  // the limits that hold an old answer may hold the new one
  }

  void search() {
    for (int n = 0; n < most_rounds && idle_ < most_idle_rounds && astray_ < most_rounds_astray; ++n) {
      begin_round();
      newton_.solve(program_, round_, outcome_);
      if (gave_up(outcome_.termination)) return;
      observe();
      take_answer();
      if (goes_back()) return;
      if (ease_where_stuck(program_, outcome_)) {
        if (late()) return;
        astray_ = 0;
        continue;
      }
      program_.renew_limits(!met_);  // at the answer too: its multipliers make it stationary
      if (done_ && (program_.landed() || !landing_.worth_trying(error_))) return;
      if (out_of_iterations()) return;
      land_or_take_off();
      if (late()) return;
    }
    say_why_it_ended();
  }

 private:
  bool converged() const { return outcome_.termination == Termination::converged; }

  // Eases the barrier before the first round without sets of limits that hold, and chooses how far a round goes.
  void begin_round() {
    if (!eased_ && !program_.landed()) {
      ease(newton_, program_);
      eased_ = true;
    }
    const double error = program_.limit_error();
    if (idle_ > 1) finest_ = std::max(least_tolerance, 0.1 * finest_);
    round_.tolerance = std::clamp(tolerance_share * error, finest_, std::max(first_tolerance, finest_));
    if (error <= limit_tolerance_ || program_.landed()) round_.tolerance = finest_;
    round_.max_iterations =
        std::min(options_.max_iterations, program_.landed() ? landing_iterations : most_round_iterations);
    round_.patience = program_.landed() ? 1 : options_.patience;
  }

  // What a round has come to.
  void observe() {
    arrived_ = converged();
    astray_ = !arrived_ && outcome_.infeasibility > astray ? astray_ + 1 : 0;
    error_ = program_.limit_error();
    kept_ = program_.limit_violation() <= limit_tolerance_;
    met_ = error_ <= limit_tolerance_;
    const bool tries_sets = program_.landed() && !kept_;  // so many of them as `landing_` has
    idle_ = error_ < idle_share * best_ || tries_sets ? 0 : idle_ + 1;
    best_ = std::min(best_, error_);
    done_ = met_ && arrived_ && round_.tolerance == finest_;
  }

  // An answer by limits that hold is settled, one by a barrier kept to go back to.
  void take_answer() {
    if (done_ && program_.landed()) settle_landed(newton_, program_, settling_weight / landing_.grown, outcome_);
    if (done_ && !program_.landed() && !answered_ && landing_.worth_trying(error_)) {
      program_.keep_worth();
      answered_ = true;
    }
  }

  // Where the sets of limits that were tried hold nothing. Returns whether that is an answer.
  bool goes_back() {
    if (!std::exchange(tried_in_vain_, false) || done_) return false;
    round_.tolerance = finest_;
    return go_back(newton_, program_, round_, limit_tolerance_, outcome_);
  }

  bool out_of_iterations() {
    if (outcome_.iterations < options_.most_iterations) return false;
    outcome_.termination = Termination::stalled;
    outcome_.reason = "no convergence within " + std::to_string(options_.most_iterations) + " iterations";
    return true;
  }

  void land_or_take_off() {
    const bool tried = program_.landed();
    if (!landing_.changes(program_, kept_, arrived_, error_)) return;
    tried_in_vain_ = tried && answered_;
    idle_ = 0;
    best_ = std::numeric_limits<double>::infinity();
  }

  bool late() {
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin_;
    round_.time_limit = options_.time_limit - taken.count();  // of all rounds together
    return stopped(options_, taken.count(), outcome_);
  }

  // Limits that stay broken are out of reach of where the search ended.
  void say_why_it_ended() {
    if (program_.limit_violation() > out_of_reach) {
      outcome_.termination = Termination::infeasible;
      outcome_.reason = arrived_ ? "near every motion that was tried limits stay violated however much they weigh"
                                 : "limits stay violated near where the search ended";
    } else if (converged()) {
      outcome_.termination = Termination::stalled;
      outcome_.reason = program_.limit_violation() > limit_tolerance_
                            ? "limits are met slowly"
                            : "kinks of the cost, powers that change sign, settle slowly";
    }
  }

  StageNewton& newton_;
  StageProgram& program_;
  const Options& options_;
  double limit_tolerance_;
  Outcome& outcome_;
  Options round_;  // of the next round
  Landing landing_{0};
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double finest_;                                          // tolerance of a round
  double error_ = 0.0;                                     // of limits after the last round
  double best_ = std::numeric_limits<double>::infinity();  // the least of these
  int idle_ = 0;                                           // rounds since it was much less
  int astray_ = 0;                                         // rounds in a row that arrived nowhere
  bool arrived_ = false;                                   // whether it converged
  bool kept_ = false, met_ = false, done_ = false;         // limits kept, their conditions met, all of an answer
  bool eased_ = false;                                     // whether the barrier was
  bool answered_ = false;                                  // whether an answer by a barrier is kept
  bool tried_in_vain_ = false;                             // whether a set of limits has just failed beside it
};

}  // namespace

void solve_within_limits(StageNewton& newton, StageProgram& program, const Options& options, double limit_tolerance,
                         Outcome& outcome) {
  if (!program.limited()) return newton.solve(program, options, outcome);
  Rounds(newton, program, options, limit_tolerance, outcome).search();
  if (outcome.termination == Termination::converged) return;
  const double broken = program.limit_violation();
  outcome.infeasibility = std::max(outcome.infeasibility, broken);
  if (outcome.termination == Termination::feasible && broken > limit_tolerance)
    outcome.termination = Termination::stalled;
}

}  // namespace lamprey::optimizer
