// What is asked of a Solver anew: another goal, another start, the time that is left.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "guess/guess.hpp"
#include "maneuver/end_rows.hpp"
#include "maneuver/ends_within_limits.hpp"
#include "maneuver/seen_shape.hpp"
#include "mechanics/continuous.hpp"
#include "model/input_error.hpp"
#include "search/solver.hpp"
#include "shape/reach.hpp"

namespace lamprey::search {

namespace {

using maneuver::Goal;
using maneuver::Maneuver;
using maneuver::Problem;
using model::InputError;
using model::System;

constexpr double same_turn = 1e-10;        // rad
constexpr double least_of_most = 1e-3;     // least duration over the most, where the least asked for has passed
constexpr double most_beyond = 0.1;        // rad, of a joint seen beyond its limit
constexpr double most_inside = 0.01;       // swimmer's sizes, of a body seen beyond a limit of place or clearance
constexpr double most_out_of_plane = 0.1;  // of the bodies' momentum, that is seen of the whole's beside its plane
constexpr double nothing_left = 1e-6;      // of the time

void refuse_end(const System& system, const char* end, const maneuver::BrokenLimit& broken, const char* mend) {
  throw InputError(end, "found a " + std::string(end) + " that breaks " + broken.row->listed_key() +
                            (broken.row->body >= 0 ? broken.row->bearer(system) : std::string()) + " by " +
                            maneuver::in_words(broken.excess, 3) + " " + broken.row->unit_name() + "; " + mend);
}

// As in problem files: more is meant in degrees.
void require_turn(const std::string& key, const Eigen::Vector3d& turn) {
  if (turn.cwiseAbs().maxCoeff() <= 2.0 * std::numbers::pi) return;
  throw InputError(key, "found a turn by " + maneuver::in_words(turn.norm(), 6) +
                            " rad; allowed: at most a full turn, 2 pi, along each axis; convert degrees to radians");
}

}  // namespace

void Solver::set_goal(const Goal& goal) {
  if (goal.turn) require_turn("goal.turn", *goal.turn);
  for (const auto& [body, rotation] : goal.rotation)
    if (rotation) require_turn("goal.rotation." + body, *rotation);
  for (const auto& [joint, angles] : goal.angle)
    for (double angle : angles) require_turn("goal.angle." + joint, Eigen::Vector3d(angle, 0.0, 0.0));
  if (goal.rest != problem_.goal->rest || goal.joints_rest != problem_.goal->joints_rest ||
      goal.periodic != problem_.goal->periodic)
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
  beginning.path = guess::led_to_start(system_, beginning.path, moved.start.rotation);
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
  const double beside = shape::momentum_beside(system_, start, program_.pose_basis());
  if (beside == 0.0) return start;
  if (beside <= most_out_of_plane)
    return maneuver::state_of(system_, start.rotation[0], start.position, maneuver::shape_of(system_, start),
                              shape::momentum_within(system_, start, program_.pose_basis()));
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
                     "found joint " + joint.name + " beyond " + beyond.limit->key + " by " +
                         maneuver::in_words(beyond.angle, 4) + " rad; allowed: up to " +
                         maneuver::in_words(most_beyond, 4) +
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
    throw InputError("duration", "found " + maneuver::in_words(duration, 6) + ", allowed: positive numbers, s");
  if (maneuver_.free_duration)
    throw InputError("duration", "found " + maneuver::in_words(duration, 6) +
                                     " where the problem's duration is free; make a new Solver of another problem");
  if (!problem_.waypoints.empty())
    throw InputError("duration", "found " + maneuver::in_words(duration, 6) +
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
    throw InputError("elapsed", "found " + maneuver::in_words(elapsed, 4) +
                                    " s; allowed: more than 0; give the time that has passed");
  if (!(elapsed < (1.0 - nothing_left) * left))
    throw InputError("elapsed", "found " + maneuver::in_words(elapsed, 4) + " s; allowed: less than the " +
                                    maneuver::in_words(left, 4) +
                                    " s that are left; make a Solver of a problem that begins there");
  if (maneuver_.periodic)
    throw InputError("elapsed", "found a periodic goal, whose motion goes on as it began; make a new Solver");
  if (!problem_.waypoints.empty())
    throw InputError("elapsed", "found waypoints, which are tied to times; make a new Solver of another problem");
}

Solver::Beginning Solver::rest_of_answer(double passed, const mechanics::Rotations& start) const {
  const double share = passed / last_.duration;
  Beginning rest{guess::led_to_start(system_, guess::rest_of(system_, last_.path, share), start),
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

}  // namespace lamprey::search
