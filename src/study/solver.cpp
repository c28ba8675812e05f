#include "study/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "maneuver/ends_within_limits.hpp"
#include "maneuver/feedback.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/reach.hpp"
#include "maneuver/seen_shape.hpp"
#include "mechanics/continuous.hpp"
#include "model/input_error.hpp"
#include "optimizer/limited_newton.hpp"
#include "study/plain_words.hpp"

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
constexpr double exactly_asked = 1e-10;      // rad or m, of the same
constexpr double same_place = 1e-7;          // rad or swimmer's sizes
constexpr double goal_met = 1e-8;            // units of the end rows
constexpr double limits_met = 1e-7;          // units of the limits
constexpr double same_turn = 1e-10;          // rad
constexpr double same_answer = 1e-6;         // relative difference of cost
constexpr double least_of_most = 1e-3;       // least duration over the most, where the least asked for has passed
constexpr double most_beyond = 0.1;          // rad, of a joint seen beyond its limit
constexpr double most_inside = 0.01;         // swimmer's sizes, of a body seen beyond a limit of place or clearance
constexpr double most_out_of_plane = 0.1;    // of the bodies' momentum, that is seen of the whole's beside its plane
constexpr double nothing_left = 1e-6;        // of the time
constexpr double least_stirred = 1e-6;       // of the way that the shapes led before
constexpr int most_polishing = 5;            // iterations at an answer
constexpr std::size_t longest_reason = 100;  // letters, of a search that converges

// The problem, where it is one that a Solver takes.
const Problem& taken(const System& system, const Problem& problem) {
  const bool single = integrator::single_step(problem.scheme);
  if (problem.goal && single && newton_takes(system, problem)) return problem;
  const std::string found = !problem.goal                                      ? "no goal"
                            : problem.control == maneuver::ControlKind::spline ? "spline moments (control.kind)"
                            : !single ? "a scheme above order 2 (integrator.scheme)"
                                      : "total momentum at the start beside a free duration or a periodic goal";
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
    stirred_ =
        Beginning{maneuver::random_guess(system, maneuver_, seed_of_start(problem, 0)), last_.duration, {}, {}, {}};
    answers_ = stays();
    return;
  }
  if (!begin()) return;
  const maneuver::NodePath moved = program_.path();
  last_.path.control = moved.control;
  answers_ = last_.converged() && same_motion(moved) && program_.merit().violation <= goal_met &&
             program_.limit_violation() <= limits_met &&
             std::abs(program_.cost() - last_.cost) <= same_answer * std::abs(last_.cost);
  if (answers_) learn_from_answer();
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
  answers_ = outcome_.termination == Termination::converged &&
             std::abs(program_.cost() - last_.cost) <= same_answer * std::abs(last_.cost);
  if (!answers_) return;
  moved_ = false;
  keep_answer();
}

namespace {

void refuse_end(const System& system, const char* end, const maneuver::BrokenLimit& broken, const char* mend) {
  throw InputError(end, "found a " + std::string(end) + " that breaks " + broken.row->listed_key() +
                            (broken.row->body >= 0 ? broken.row->bearer(system) : std::string()) + " by " +
                            number(broken.excess, 3) + " " + broken.row->unit_name() + "; " + mend);
}

// As in problem files: more is meant in degrees.
void require_turn(const std::string& key, const Eigen::Vector3d& turn) {
  if (turn.cwiseAbs().maxCoeff() <= 2.0 * std::numbers::pi) return;
  throw InputError(key, "found a turn by " + number(turn.norm(), 6) +
                            " rad; allowed: at most a full turn, 2 pi, along each axis; convert degrees to radians");
}

}  // namespace

void Solver::set_goal(const Goal& goal) {
  if (goal.turn) require_turn("goal.turn", *goal.turn);
  for (const auto& [body, rotation] : goal.rotation)
    if (rotation) require_turn("goal.rotation." + body, *rotation);
  for (const auto& [joint, angles] : goal.angle)
    for (double angle : angles) require_turn("goal.angle." + joint, Eigen::Vector3d(angle, 0.0, 0.0));
  if (goal.rest != problem_.goal->rest || goal.periodic != problem_.goal->periodic)
    throw InputError("goal", "found another kind of goal (rest or periodic differ); make a new Solver for it");
  Problem problem = problem_;
  problem.goal = goal;
  const Maneuver asked = maneuver::make_maneuver(system_, problem, problem.steps);
  bool same = true;
  for (std::size_t i = 0; i < asked.end_rotation.size(); ++i)
    same = same && asked.end_rotation[i].has_value() == maneuver_.end_rotation[i].has_value();
  for (std::size_t j = 0; j < asked.end_joint.size(); ++j)
    same = same && asked.end_joint[j].has_value() == maneuver_.end_joint[j].has_value();
  for (std::size_t c = 0; c < 3; ++c)
    same = same && asked.end_position[c].has_value() == maneuver_.end_position[c].has_value();
  if (!same)
    throw InputError("goal",
                     "found a goal that leaves other attitudes, joints or axes of move free than the problem's; give "
                     "those it gives, or "
                     "make a new Solver of another problem");
  Maneuver moved = maneuver_;
  moved.end_rotation = asked.end_rotation;
  moved.end_joint = asked.end_joint;
  moved.end_position = asked.end_position;
  moved.cost_weights = maneuver::weights_along(moved, problem_.cost_weights);
  if (!moved.periodic) {
    if (const auto broken = maneuver::broken_by_goal(system_, moved, program_.limit_rows()))
      refuse_end(system_, "goal", *broken, "give a goal within the limits");
  }
  maneuver_ = moved;
  answers_ = false;
}

void Solver::set_start(const integrator::State& start) {
  if (maneuver_.periodic)
    throw InputError("start", "found a periodic goal, whose motion begins where it closes; make a new Solver");
  mechanics::Rotations fitting = start.rotation;
  maneuver::fit_to_joints(system_, fitting);
  for (std::size_t i = 0; i < fitting.size(); ++i)
    if (!(lie::rotation_angle(fitting[i].transpose() * start.rotation[i]) <= same_turn))
      throw InputError("start.rotation." + system_.body(static_cast<int>(i)).name,
                       "found a rotation beside what its joint allows; make the state by start_without_momentum");
  Maneuver moved = maneuver_;
  moved.start = kept_within_limits(with_takeable_momentum(start));
  moved.total = total_of(moved.start);
  const auto broken = maneuver::broken_by_start(system_, moved, program_.limit_rows());
  if (broken && broken->row->of_gap() && broken->excess > most_inside * system_.size())
    refuse_end(system_, "start", *broken, "no motion leads out of there in a step");
  moved.cost_weights = maneuver::weights_along(moved, problem_.cost_weights);
  Beginning& beginning = moved_beginning();
  beginning.path = maneuver::led_to_start(system_, beginning.path, moved.start.rotation);
  maneuver_ = moved;
}

// With its plane: momentum that leaves it would carry the swimmer along with coordinates that the search does not have.
integrator::State Solver::with_takeable_momentum(const integrator::State& start) const {
  if (!maneuver::has_momentum(system_, start)) return start;
  if (!program_.carries_momentum())
    throw InputError(
        "start",
        "found total momentum, which joint moments cannot change, and the problem's own start has none; make "
        "the state by start_without_momentum (in Python leave linear_velocity out), or a Solver of a problem that "
        "starts with "
        "momentum");
  const double beside = maneuver::momentum_beside(system_, start, program_.pose_basis());
  if (beside == 0.0) return start;
  if (beside <= most_out_of_plane)
    return maneuver::state_of(system_, start.rotation[0], start.position, maneuver::shape_of(system_, start),
                              maneuver::momentum_within(system_, start, program_.pose_basis()));
  throw InputError("start",
                   "found total momentum out of the plane or line in which the problem's own motion stays; make a new "
                   "Solver of a problem that starts so");
}

// Which joint moments keep; none, to the last digit, where the program has none.
mechanics::SpatialMomentum Solver::total_of(const integrator::State& state) const {
  if (!program_.carries_momentum()) return {};
  return mechanics::spatial_momentum(system_, state.rotation, state.position, state.momentum);
}

// Joints that are seen a little beyond their limits begin at these, still.
integrator::State Solver::kept_within_limits(const integrator::State& seen) const {
  const std::vector<maneuver::LimitRow>& rows = program_.limit_rows();
  const maneuver::SeenShape shape = maneuver::shape_of(system_, seen);
  const maneuver::BeyondLimit beyond = maneuver::beyond_limits(system_, rows, shape);
  if (beyond.limit == nullptr) return seen;
  const model::Joint& joint = system_.joint(beyond.limit->joint);
  if (beyond.angle > most_beyond)
    throw InputError("start.rotation." + system_.body(joint.child).name,
                     "found joint " + joint.name + " beyond " + beyond.limit->key + " by " + number(beyond.angle, 4) +
                         " rad; allowed: up to " + number(most_beyond, 4) +
                         " rad, as measurements have it; mend this rotation or its parent's");
  const mechanics::Rotations& inside = last_.path.rotation[node_before(passed_)];
  return maneuver::state_of(system_, seen.rotation[0], seen.position,
                            maneuver::held_within_limits(system_, rows, shape, inside), total_of(seen));
}

// The node of the last answer at a time, s, or the last one before it.
std::size_t Solver::node_before(double time) const {
  const std::size_t steps = last_.path.rotation.size() - 1;
  return std::min(static_cast<std::size_t>(time / last_.duration * static_cast<double>(steps)), steps - 1);
}

// Where the next search begins, to be moved further: at first the last answer.
Solver::Beginning& Solver::moved_beginning() {
  if (!led_)
    led_ =
        Beginning{last_.path, last_.duration, last_.limit_multipliers, last_.work_multipliers, last_.end_multipliers};
  moved_ = true;
  answers_ = false;
  return *led_;
}

void Solver::set_duration(double duration) {
  if (!(duration > 0.0) || !std::isfinite(duration))
    throw InputError("duration", "found " + number(duration, 6) + ", allowed: positive numbers, s");
  if (maneuver_.free_duration)
    throw InputError("duration", "found " + number(duration, 6) +
                                     " where the problem's duration is free; make a new Solver of another problem");
  if (!problem_.waypoints.empty())
    throw InputError("duration", "found " + number(duration, 6) +
                                     " where waypoints are tied to times; make a new Solver of another problem");
  take_duration(duration);
}

void Solver::take_duration(double duration) {
  maneuver_.duration = duration;
  maneuver_.node_weight =
      maneuver::node_weights(problem_.cost_rule(), problem_.effort, maneuver_.time_step(), maneuver_.steps);
  moved_ = true;
  answers_ = false;
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

}  // namespace

void Solver::advance(double elapsed) {
  require_left(elapsed);
  const double passed = passed_ + elapsed;
  Maneuver moved = maneuver_;
  moved.start = start_at(passed);
  moved.total = total_of(moved.start);
  moved.cost_weights = maneuver::weights_along(moved, problem_.cost_weights);
  led_ = rest_of_answer(passed, moved.start.rotation);
  passed_ = passed;
  maneuver_ = moved;
  moved_ = true;
  answers_ = false;
  shorten(elapsed);
}

// Of a swimmer that follows the last answer, at a time, s. Smooth curves through nodes next to limits of angles go beyond these:
// there joints run straight from node to node.
integrator::State Solver::start_at(double time) const {
  if (still()) return answered_.start;
  const integrator::ReferenceState seen =
      integrator::MotionPath(system_, maneuver::node_motion(system_, solution())).at_time(time);
  maneuver::SeenShape shape =
      maneuver::shape_of(system_, integrator::state_of_velocity(system_, seen.rotation, seen.position, seen.velocity));
  if (maneuver::beyond_limits(system_, program_.limit_rows(), shape).limit != nullptr) {
    const std::size_t node = node_before(time);
    const double step = last_.duration / static_cast<double>(last_.path.rotation.size() - 1);
    shape = maneuver::shape_between(system_, last_.path.rotation[node], last_.path.rotation[node + 1], step,
                                    time / step - static_cast<double>(node));
  }
  return kept_within_limits(
      maneuver::state_of(system_, seen.rotation[0], seen.position, shape, total_of(answered_.start)));
}

void Solver::require_left(double elapsed) const {
  const double left =
      std::min(last_.duration - passed_, maneuver_.free_duration ? problem_.duration.max : maneuver_.duration);
  if (!(elapsed > 0.0))
    throw InputError("elapsed",
                     "found " + number(elapsed, 4) + " s; allowed: more than 0; give the time that has passed");
  if (!(elapsed < (1.0 - nothing_left) * left))
    throw InputError("elapsed", "found " + number(elapsed, 4) + " s; allowed: less than the " + number(left, 4) +
                                    " s that are left; make a Solver of a problem that begins there");
  if (maneuver_.periodic)
    throw InputError("elapsed", "found a periodic goal, whose motion goes on as it began; make a new Solver");
  if (!problem_.waypoints.empty())
    throw InputError("elapsed", "found waypoints, which are tied to times; make a new Solver of another problem");
}

Solver::Beginning Solver::rest_of_answer(double passed, const mechanics::Rotations& start) const {
  const double share = passed / last_.duration;
  Beginning rest{maneuver::led_to_start(system_, maneuver::rest_of(system_, last_.path, share), start),
                 last_.duration - passed, last_.limit_multipliers, last_.work_multipliers, last_.end_multipliers};
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
  return maneuver::calmed(system_, maneuver::led_to_start(system_, path, maneuver_.start.rotation), share);
}

// With a path's shapes.
bool Solver::go_to(const maneuver::NodePath& path, double duration, const maneuver::LimitMultipliers& limits,
                   const maneuver::WorkMultipliers& work, const Eigen::VectorXd& ends) {
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
  if (outcome_.termination != Termination::converged) return outcome_;
  if (const double error = program_.stated_goal_error(); error > asked_twice) {
    outcome_.termination = Termination::infeasible;
    outcome_.reason = "the goal asks for what moments cannot reach: it stays " + number(error, 4) + " (rad, m) away";
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
  if (!maneuver::met_by_rest(system_, problem_, maneuver_)) return false;
  Beginning moving = stirred_ ? std::move(*stirred_)
                     : led_   ? std::move(*led_)
                              : Beginning{last_.path, last_.duration, last_.limit_multipliers, last_.work_multipliers,
                                        last_.end_multipliers};
  stirred_.reset();
  moved_ = true;
  const maneuver::NodePath rest = maneuver::at_rest(system_, maneuver_, problem_.scheme);
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

}  // namespace lamprey::study
