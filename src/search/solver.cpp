#include "search/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "guess/guess.hpp"
#include "maneuver/end_rows.hpp"
#include "maneuver/feedback.hpp"
#include "mechanics/continuous.hpp"
#include "model/input_error.hpp"
#include "optimizer/limited_newton.hpp"

namespace lamprey::search {

namespace {

using maneuver::Problem;
using maneuver::Solution;
using model::InputError;
using model::System;
using optimizer::Termination;

constexpr double asked_twice = 1e-6;     // units of the end rows, of conditions that follow from others
constexpr double exactly_asked = 1e-10;  // of the same
constexpr double same_place = 1e-7;      // rad or swimmer's sizes
constexpr double goal_met = 1e-8;        // units of the end rows
constexpr double limits_met = 1e-7;      // units of the limits
constexpr double same_answer = 1e-6;     // relative difference of cost
constexpr double least_stirred = 1e-6;   // of the way that the shapes led before
constexpr int most_polishing = 5;        // iterations at an answer
constexpr const char* from_here =
    "from the last answer on no motion was found (solve, or a nearer goal first, may find one): ";
constexpr std::size_t longest_reason = 100;  // letters, of a search that converges

// The problem, where it is one that a Solver takes.
const Problem& taken(const System& system, const Problem& problem) {
  const bool single = integrator::single_step(problem.scheme);
  if (problem.goal && single && newton_takes(system, problem)) return problem;
  const std::string found = !problem.goal                                      ? "no goal"
                            : problem.control == maneuver::ControlKind::spline ? "spline moments (control.kind)"
                            : !single ? "a scheme above order 2 (integrator.scheme)"
                                      : "total momentum at the start beside a periodic goal";
  throw InputError("problem", "found " + found + ", which a Solver does not take; use solve");
}

const Solution& fitting(const Problem& problem, const Solution& solution) {
  if (solution.rotation.size() != static_cast<std::size_t>(problem.steps) + 1)
    throw InputError("solution", "found " + std::to_string(solution.rotation.size()) + " nodes, the problem has " +
                                     std::to_string(problem.steps + 1) + "; give a solution of this problem");
  const auto require = [](bool fits, const std::string& found) {
    if (!fits) throw InputError("solution", "found " + found + "; give a solution of this problem");
  };
  require(solution.position.size() == solution.rotation.size(),
          std::to_string(solution.position.size()) + " positions at its nodes");
  for (const auto& bodies : solution.rotation)
    require(
        bodies.size() == problem.swimmer.bodies.size(),
        std::to_string(bodies.size()) + " bodies, the problem has " + std::to_string(problem.swimmer.bodies.size()));
  for (std::size_t k = 0; k < solution.rotation.size(); ++k) {
    bool finite = solution.position[k].allFinite();
    for (const Eigen::Matrix3d& R : solution.rotation[k]) finite = finite && R.allFinite();
    require(finite, "numbers that are not finite at node " + std::to_string(k));
  }
  return solution;
}

}  // namespace

Solver::Solver(const System& system, const Problem& problem, const Solution& solution)
    : Solver(system, problem, solution, Reached(system, taken(system, problem))) {}

Solver::Solver(const System& system, const Problem& problem, const Solution& solution, const Reached& reached)
    : system_(system),
      problem_(problem),
      maneuver_(maneuver::make_maneuver(system, problem, problem.steps)),
      answered_(maneuver_),
      program_(system, maneuver_, reached.coordinates, reached.rows, maneuver::limit_rows(system, problem),
               steps_for(problem.steps)),
      newton_(program_.sizes()),
      last_(found_in(system, maneuver_, program_.limit_rows(), fitting(problem, solution))),
      answered_rows_(program_.limit_rows()) {
  for (optimizer::Outcome* outcome : {&outcome_, &last_.outcome}) {
    outcome->history.reserve(static_cast<std::size_t>(optimizer::most_iterations(program_, newton_options())));
    outcome->reason.reserve(longest_reason);
  }
  last_.path.control.assign(last_.path.rotation.size(), Eigen::VectorXd::Zero(system.control_count()));
  if (still()) {
    stirred_ = Beginning{guess::random_guess(system, maneuver_, seed_of_start(problem, 0)), last_.duration, {}, {}, {}};
    answers_ = stays();
    return;
  }
  if (!begin()) return;
  const maneuver::NodePath moved = program_.path();
  last_.path.control = moved.control;
  answers_ = last_.converged() && same_motion(moved) && program_.merit().violation <= goal_met &&
             program_.limit_violation() <= limits_met && costs_as_before();
  if (answers_) learn_from_answer();
}

// What a given duration costs hides no difference.
bool Solver::costs_as_before() const {
  const double given = maneuver_.free_duration ? 0.0 : maneuver_.time_weight * maneuver_.duration;
  return std::abs(program_.cost() - last_.cost) <= same_answer * std::abs(last_.cost - given);
}

// Whether what the swimmer makes of the last answer's shapes from the start that is asked for is that answer.
bool Solver::same_motion(const maneuver::NodePath& moved) const {
  const maneuver::NodePath& given = last_.path;
  for (std::size_t k = 0; k < given.rotation.size(); ++k) {
    if (!((given.position[k] - moved.position[k]).norm() <= same_place * system_.size())) return false;
    for (std::size_t i = 0; i < given.rotation[k].size(); ++i)
      if (!((given.rotation[k][i] - moved.rotation[k][i]).norm() <= same_place)) return false;
  }
  return true;
}

// Whether the last answer is to stay where the swimmer is.
bool Solver::still() const {
  const maneuver::NodePath& path = last_.path;
  for (std::size_t k = 1; k < path.rotation.size(); ++k)
    if (path.rotation[k] != path.rotation[0] || path.position[k] != path.position[0]) return false;
  return true;
}

// Multipliers and factors at an answer, for what is asked next to begin with. What leads elsewhere was another problem's.
void Solver::learn_from_answer() {
  optimizer::Options options = newton_options();
  options.max_iterations = most_polishing;
  solve_program(newton_, program_, options, outcome_);
  answers_ = outcome_.termination == Termination::converged && costs_as_before();
  if (!answers_) return;
  moved_ = false;
  keep_answer();
}

optimizer::Options Solver::newton_options() {
  optimizer::Options options;
  options.tolerance = 1e-7;
  return options;
}

// To a motion of what is asked for now.
bool Solver::begin() {
  if (stirred_)
    return go_to(stirred_shapes(), stirred_->duration, stirred_->limit_multipliers, stirred_->work_multipliers,
                 stirred_->end_multipliers);
  if (led_)
    return go_to(led_->path, led_->duration, led_->limit_multipliers, led_->work_multipliers, led_->end_multipliers);
  return go_to(last_.path, last_.duration, last_.limit_multipliers, last_.work_multipliers, last_.end_multipliers);
}

// Of a swimmer at rest, to get where is asked for: displacements and turns grow by the square of strokes.
maneuver::NodePath Solver::stirred_shapes() const {
  const maneuver::NodePath& path = stirred_->path;
  double asked = 0.0, went = 0.0;  // rad, swimmer's sizes, of what is asked for
  for (std::size_t i = 0; i < maneuver_.end_rotation.size(); ++i)
    if (const auto& end = maneuver_.end_rotation[i]) {
      asked += lie::rotation_angle(maneuver_.start.rotation[i].transpose() * *end);
      went += lie::rotation_angle(path.rotation.front()[i].transpose() * path.rotation.back()[i]);
    }
  for (std::size_t c = 0; c < 3; ++c)
    if (const auto& end = maneuver_.end_position[c]) {
      const auto along = static_cast<Eigen::Index>(c);
      asked += std::abs(*end - maneuver_.start.position[along]) / system_.length_unit();
      went += std::abs(path.position.back()[along] - path.position.front()[along]) / system_.length_unit();
    }
  const double share = went > 0.0 ? std::sqrt(std::clamp(asked / went, least_stirred, 1.0)) : 1.0;
  return guess::calmed(system_, guess::led_to_start(system_, path, maneuver_.start.rotation), share);
}

// With a path's shapes.
bool Solver::go_to(const maneuver::NodePath& path, double duration, const shape::LimitMultipliers& limits,
                   const shape::WorkMultipliers& work, const Eigen::VectorXd& ends) {
  program_.take_duration(maneuver_.free_duration ? duration : maneuver_.duration);
  program_.take_end_multipliers(ends);
  program_.take_limit_multipliers(limits);
  program_.take_work_multipliers(work);
  return program_.go_to(path);
}

const optimizer::Outcome& Solver::solve(const optimizer::Options& options) {
  outcome_.history.clear();
  outcome_.iterations = outcome_.evaluations = 0;
  if (answers_ && !moved_) {
    outcome_.termination = Termination::converged;
    outcome_.reason = "nothing else is asked";
    return outcome_;
  }
  outcome_.termination = Termination::stalled;
  program_.retarget(maneuver_);
  if (stays()) return outcome_;
  if (!moved_) {
    newton_.foresee(program_);
  } else if (!begin()) {
    outcome_.reason = "no motion was found through the shapes of the last answer";
    outcome_.objective = std::numeric_limits<double>::quiet_NaN();
    outcome_.infeasibility = std::numeric_limits<double>::infinity();
    return outcome_;
  }
  moved_ = true;
  solve_program(newton_, program_, options, outcome_);
  if (outcome_.termination == Termination::time_limit || outcome_.termination == Termination::interrupted) keep_way();
  if (outcome_.termination == Termination::infeasible) {  // near here alone: what is farther away was not looked at
    outcome_.termination = Termination::stalled;
    outcome_.reason.insert(0, from_here);
  }
  if (outcome_.termination != Termination::converged) return outcome_;
  if (program_.stated_goal_error() > asked_twice) {
    outcome_.termination = Termination::infeasible;
    outcome_.reason = "the goal asks for what moments cannot reach: " + program_.stated_goal_miss();
    return outcome_;
  }
  moved_ = false;
  answers_ = true;
  keep_answer();
  return outcome_;
}

// Nothing costs less than to stay where that is the goal. There no small change of shapes moves the swimmer, and no search that begins
// there gets anywhere: the next one begins with the last shapes that do.
bool Solver::stays() {
  if (maneuver_.free_duration || !guess::met_by_rest(system_, problem_, maneuver_)) return false;
  Beginning moving = stirred_ ? std::move(*stirred_)
                     : led_   ? std::move(*led_)
                              : Beginning{last_.path, last_.duration, last_.limit_multipliers, last_.work_multipliers,
                                        last_.end_multipliers};
  stirred_.reset();
  moved_ = true;
  const maneuver::NodePath rest = guess::at_rest(system_, maneuver_, problem_.scheme);
  if (!go_to(rest, maneuver_.duration, {}, {}, {}) || program_.limit_violation() > limits_met) {
    led_ = std::move(moving);
    return false;
  }
  last_ = staying(system_, problem_, maneuver_, "the goal is where the swimmer rests");
  outcome_.termination = last_.outcome.termination;
  outcome_.reason = last_.outcome.reason;
  outcome_.objective = last_.cost;
  outcome_.infeasibility = last_.outcome.infeasibility;
  answered_ = maneuver_;
  answered_rows_.clear();
  passed_ = 0.0;
  answers_ = true;
  stirred_ = std::move(moving);
  return true;
}

// Where the time ended a search, the next one goes on.
void Solver::keep_way() {
  stirred_.reset();
  led_ = Beginning{program_.path(), program_.duration(), program_.limit_multipliers(), program_.work_multipliers(),
                   program_.end_multipliers()};
}

void Solver::keep_answer() {
  answered_ = maneuver_;
  answered_rows_ = program_.limit_rows();
  passed_ = 0.0;
  led_.reset();
  stirred_.reset();
  program_.write_path(last_.path);
  if (program_.stated_goal_error() > exactly_asked) answer_what_is_reached();
  last_.cost = program_.cost();
  last_.duration = program_.duration();
  last_.end_multipliers = program_.end_multipliers();
  last_.limit_multipliers = program_.limit_multipliers();
  last_.work_multipliers = program_.work_multipliers();
  if (maneuver_.cost_weights.any()) last_.cost_parts = program_.cost_parts();
  last_.outcome = outcome_;
  program_.take_end_multipliers(last_.end_multipliers);  // which the next solve goes on with
}

// A start measured a little out of a plane that moments keep is as far out at the end: that is what the answer answers.
void Solver::answer_what_is_reached() {
  for (std::size_t i = 0; i < answered_.end_rotation.size(); ++i)
    if (auto& end = answered_.end_rotation[i]) end = last_.path.rotation.back()[i];
  for (int j = 0; j < system_.joint_count(); ++j)
    if (auto& end = answered_.end_joint[static_cast<std::size_t>(j)])
      end = mechanics::child_to_parent(last_.path.rotation.back(), system_.joint(j));
  for (std::size_t c = 0; c < 3; ++c)
    if (auto& end = answered_.end_position[c]) end = last_.path.position.back()[static_cast<Eigen::Index>(c)];
}

Solution Solver::solution() const { return describe(system_, answered_, problem_.scheme, answered_rows_, last_); }

maneuver::Feedback Solver::feedback() const { return maneuver::design_feedback(system_, problem_, solution()); }

}  // namespace lamprey::search
