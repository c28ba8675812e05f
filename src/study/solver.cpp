#include "study/solver.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>

#include "maneuver/feedback.hpp"
#include "maneuver/guess.hpp"
#include "mechanics/continuous.hpp"
#include "model/input_error.hpp"
#include "optimizer/limited_newton.hpp"

namespace lamprey::study {

namespace {

using maneuver::Goal;
using maneuver::Maneuver;
using maneuver::Problem;
using maneuver::Solution;
using model::InputError;
using model::System;
using optimizer::Termination;

constexpr double asked_twice = 1e-6;         // rad or m, of conditions that follow from others
constexpr double same_turn = 1e-10;          // rad
constexpr double same_answer = 1e-6;         // relative difference of cost
constexpr double least_of_most = 1e-3;       // least duration over the most, where the least asked for has passed
constexpr int most_polishing = 5;            // iterations at an answer
constexpr std::size_t longest_reason = 100;  // letters, of a search that converges

// The problem, where it is one that a Solver takes.
const Problem& taken(const System& system, const Problem& problem) {
  if (!problem.goal || !integrator::single_step(problem.scheme) || !newton_takes(system, problem))
    throw InputError(
        "problem",
        "found no goal, spline moments, momentum at the start or a scheme above order 2, which a Solver does not "
        "take; use solve");
  return problem;
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
  if (!begin()) return;
  last_.path.control = program_.path().control;
  if (last_.converged()) learn_from_answer();
}

// Multipliers and factors at an answer, for what is asked next to begin with.
void Solver::learn_from_answer() {
  optimizer::Options options = newton_options();
  options.max_iterations = most_polishing;
  solve_program(newton_, program_, options, outcome_);
  if (outcome_.termination != Termination::converged) return;
  if (std::abs(program_.cost() - last_.cost) > same_answer * std::abs(last_.cost)) return;
  moved_ = false;
  keep_answer();
}

namespace {

// As in problem files: more is meant in degrees.
void require_turn(const std::string& key, const Eigen::Vector3d& turn) {
  if (turn.cwiseAbs().maxCoeff() <= 2.0 * std::numbers::pi) return;
  throw InputError(key, "found a turn by " + std::to_string(turn.norm()) +
                            " rad; allowed: at most a full turn, 2 pi, along each axis; convert degrees to radians");
}

}  // namespace

void Solver::set_goal(const Goal& goal) {
  if (goal.turn) require_turn("goal.turn", *goal.turn);
  for (const auto& [body, rotation] : goal.rotation)
    if (rotation) require_turn("goal.rotation." + body, *rotation);
  if (goal.rest != problem_.goal->rest || goal.periodic != problem_.goal->periodic)
    throw InputError("goal", "found another kind of goal (rest or periodic differ); make a new Solver for it");
  Problem problem = problem_;
  problem.goal = goal;
  const Maneuver asked = maneuver::make_maneuver(system_, problem, problem.steps);
  bool same = true;
  for (std::size_t i = 0; i < asked.end_rotation.size(); ++i)
    same = same && asked.end_rotation[i].has_value() == maneuver_.end_rotation[i].has_value();
  for (std::size_t c = 0; c < 3; ++c)
    same = same && asked.end_position[c].has_value() == maneuver_.end_position[c].has_value();
  if (!same) throw InputError("goal", "found other numbers free than in the goal before; make a new Solver for it");
  Maneuver moved = maneuver_;
  moved.end_rotation = asked.end_rotation;
  moved.end_position = asked.end_position;
  moved.cost_weights = maneuver::weights_along(moved, problem_.cost_weights);
  maneuver_ = moved;
}

void Solver::set_start(const integrator::State& start) {
  if (maneuver_.periodic)
    throw InputError("start", "found a periodic goal, whose motion begins where it closes; make a new Solver");
  if (maneuver::has_momentum(system_, start))
    throw InputError("start", "found total momentum, which joint moments cannot change; give a start without");
  mechanics::Rotations fitting = start.rotation;
  maneuver::fit_to_joints(system_, fitting);
  for (std::size_t i = 0; i < fitting.size(); ++i)
    if (!(lie::rotation_angle(fitting[i].transpose() * start.rotation[i]) <= same_turn))
      throw InputError("start.rotation." + system_.body(static_cast<int>(i)).name,
                       "found a rotation beside what its joint allows; make the state by start_without_momentum");
  Maneuver moved = maneuver_;
  moved.start = start;
  moved.cost_weights = maneuver::weights_along(moved, problem_.cost_weights);
  Beginning& beginning = moved_beginning();
  beginning.path = maneuver::led_to_start(system_, beginning.path, start.rotation);
  maneuver_ = moved;
}

// Where the next search begins, to be moved further: at first the last answer.
Solver::Beginning& Solver::moved_beginning() {
  if (!led_) led_ = Beginning{last_.path, last_.duration, last_.limit_multipliers, last_.work_multipliers};
  moved_ = true;
  return *led_;
}

void Solver::set_duration(double duration) {
  if (!(duration > 0.0) || !std::isfinite(duration))
    throw InputError("duration", "found " + std::to_string(duration) + ", allowed: positive numbers, s");
  if (maneuver_.free_duration)
    throw InputError("duration", "found " + std::to_string(duration) +
                                     " where the problem's duration is free; make a new Solver of another problem");
  if (!problem_.waypoints.empty())
    throw InputError("duration", "found " + std::to_string(duration) +
                                     " where waypoints are tied to times; make a new Solver of another problem");
  take_duration(duration);
}

void Solver::take_duration(double duration) {
  maneuver_.duration = duration;
  maneuver_.node_weight =
      maneuver::node_weights(problem_.cost_rule(), problem_.effort, maneuver_.time_step(), maneuver_.steps);
  moved_ = true;
}

namespace {

// Numbers at nodes, [any][N + 1], from a share of the time on at as many nodes.
Eigen::MatrixXd rest_of(const Eigen::MatrixXd& nodes, double share) {
  const Eigen::Index steps = nodes.cols() - 1;
  Eigen::MatrixXd rest(nodes.rows(), nodes.cols());
  for (Eigen::Index k = 0; k <= steps; ++k) {
    const double place = share * static_cast<double>(steps) + (1.0 - share) * static_cast<double>(k);
    const Eigen::Index left = std::min(static_cast<Eigen::Index>(place), steps - 1);
    const double part = place - static_cast<double>(left);
    rest.col(k) = (1.0 - part) * nodes.col(left) + part * nodes.col(left + 1);
  }
  return rest;
}

// What a swimmer that follows a solution shows of itself at a time, s.
maneuver::Start seen_at(const System& system, const Solution& solution, double time) {
  const integrator::ReferenceState state =
      integrator::MotionPath(system, maneuver::node_motion(system, solution)).at_time(time);
  maneuver::Start seen;
  for (const Eigen::Matrix3d& R : state.rotation) seen.rotation.push_back(lie::log(R));
  seen.position = state.position;
  seen.angular_velocity = mechanics::angular_velocities(system, state.rotation, state.velocity);
  return seen;
}

}  // namespace

void Solver::advance(double elapsed) {
  require_left(elapsed);
  const double passed = passed_ + elapsed;
  Maneuver moved = maneuver_;
  moved.start = maneuver::start_without_momentum(system_, seen_at(system_, solution(), passed));
  moved.cost_weights = maneuver::weights_along(moved, problem_.cost_weights);
  led_ = rest_of_answer(passed, moved.start.rotation);
  passed_ = passed;
  maneuver_ = moved;
  shorten(elapsed);
}

void Solver::require_left(double elapsed) const {
  const double left =
      std::min(last_.duration - passed_, maneuver_.free_duration ? problem_.duration.max : maneuver_.duration);
  if (!(elapsed > 0.0) || !(elapsed < left))
    throw InputError("elapsed", "found " + std::to_string(elapsed) + " s; allowed: more than 0 and less than the " +
                                    std::to_string(left) + " s that are left; make a plan of its own for what follows");
  if (maneuver_.periodic)
    throw InputError("elapsed", "found a periodic goal, whose motion goes on as it began; make a new Solver");
  if (!problem_.waypoints.empty())
    throw InputError("elapsed", "found waypoints, which are tied to times; make a new Solver of another problem");
}

Solver::Beginning Solver::rest_of_answer(double passed, const mechanics::Rotations& start) const {
  const double share = passed / last_.duration;
  Beginning rest{maneuver::led_to_start(system_, maneuver::rest_of(system_, last_.path, share), start),
                 last_.duration - passed, last_.limit_multipliers, last_.work_multipliers};
  for (Eigen::MatrixXd* values :
       {&rest.limit_multipliers.value, &rest.work_multipliers.mean, &rest.work_multipliers.change})
    if (values->size() > 0) *values = rest_of(*values, share);
  return rest;
}

// By the time that has passed.
void Solver::shorten(double elapsed) {
  if (!maneuver_.free_duration) return take_duration(maneuver_.duration - elapsed);
  maneuver::Duration& asked = problem_.duration;
  asked.max -= elapsed;
  asked.min = std::max(asked.min - elapsed, least_of_most * asked.max);
  program_.bound_duration(asked.min, asked.max);
  moved_ = true;
}

optimizer::Options Solver::newton_options() {
  optimizer::Options options;
  options.tolerance = 1e-7;
  return options;
}

// To a motion of what is asked for now.
bool Solver::begin() {
  if (led_) return go_to(led_->path, led_->duration, led_->limit_multipliers, led_->work_multipliers);
  return go_to(last_.path, last_.duration, last_.limit_multipliers, last_.work_multipliers);
}

// With a path's shapes and the last answer's end multipliers.
bool Solver::go_to(const maneuver::NodePath& path, double duration, const maneuver::LimitMultipliers& limits,
                   const maneuver::WorkMultipliers& work) {
  program_.take_duration(maneuver_.free_duration ? duration : maneuver_.duration);
  program_.take_end_multipliers(last_.end_multipliers);
  program_.take_limit_multipliers(limits);
  program_.take_work_multipliers(work);
  return program_.go_to(path);
}

const optimizer::Outcome& Solver::solve(const optimizer::Options& options) {
  outcome_.history.clear();
  outcome_.iterations = outcome_.evaluations = 0;
  outcome_.termination = Termination::stalled;
  program_.retarget(maneuver_);
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
  if (outcome_.termination != Termination::converged) return outcome_;
  if (const double error = program_.stated_goal_error(); error > asked_twice) {
    outcome_.termination = Termination::infeasible;
    outcome_.reason =
        "the goal asks for what moments cannot reach: it stays " + std::to_string(error) + " (rad, m) away";
    return outcome_;
  }
  moved_ = false;
  keep_answer();
  return outcome_;
}

void Solver::keep_answer() {
  answered_ = maneuver_;
  answered_rows_ = program_.limit_rows();
  passed_ = 0.0;
  led_.reset();
  program_.write_path(last_.path);
  last_.cost = program_.cost();
  last_.duration = program_.duration();
  last_.end_multipliers = program_.end_multipliers();
  last_.limit_multipliers = program_.limit_multipliers();
  last_.work_multipliers = program_.work_multipliers();
  if (maneuver_.cost_weights.any()) last_.cost_parts = program_.cost_parts();
  last_.outcome = outcome_;
  program_.take_end_multipliers(last_.end_multipliers);  // which the next solve goes on with
}

Solution Solver::solution() const { return describe(system_, answered_, problem_.scheme, answered_rows_, last_); }

maneuver::Feedback Solver::feedback() const { return maneuver::design_feedback(system_, problem_, solution()); }

}  // namespace lamprey::study
