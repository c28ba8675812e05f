#include "study/solver.hpp"

#include "lie/so3.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/motion.hpp"
#include "model/input_error.hpp"
#include "study/method.hpp"

namespace lamprey::study {

namespace {

using maneuver::EndRow;
using maneuver::Goal;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;
using maneuver::Solution;
using mechanics::Rotations;
using model::at;
using model::InputError;
using model::System;

constexpr double asked_twice = 1e-6;   // rad or m, of conditions that follow from others
constexpr double no_momentum = 1e-10;  // of what the start's bodies have

// The problem, where it is one that a Solver takes.
const Problem& taken(const System& system, const Problem& problem) {
  const bool plain = !problem.limits.any() && problem.waypoints.empty() && !problem.duration.free &&
                     !problem.cost_weights.any() && problem.goal && !problem.goal->periodic &&
                     integrator::single_step(problem.scheme);
  if (!plain || !newton_takes(system, problem))
    throw InputError("problem",
                     "found limits, waypoints, a periodic goal, a free duration, costs beside effort, spline moments, "
                     "momentum at the start or a scheme above order 2, which a Solver does not take; use solve");
  return problem;
}

NodePath nodes_of(const System& system, const Problem& problem, const Solution& solution) {
  if (solution.rotation.size() != static_cast<std::size_t>(problem.steps) + 1)
    throw InputError("solution", "found " + std::to_string(solution.rotation.size()) + " nodes, the problem has " +
                                     std::to_string(problem.steps + 1) + "; give a solution of this problem");
  NodePath path;
  path.rotation = solution.rotation;
  path.position = solution.position;
  for (std::size_t k = 0; k + 1 < path.rotation.size(); ++k) {
    path.cayley.emplace_back();
    for (int i = 0; i < system.body_count(); ++i)
      path.cayley.back().push_back(
          lie::inverse_cayley(path.rotation[k][at(i)].transpose() * path.rotation[k + 1][at(i)]));
  }
  return path;
}

// Largest of all conditions that the goal states, those that follow from others included.
double goal_error(const System& system, const Maneuver& maneuver, const NodePath& path) {
  double error = 0.0;
  Eigen::RowVectorXd unused(maneuver::shape_size(system) + 6);
  for (const EndRow& row : maneuver::stated_end_rows(system, maneuver, {}))
    error = std::max(
        error, std::abs(maneuver::end_row(system, maneuver, row, path.rotation.back(), path.position.back(), unused)));
  return error;
}

}  // namespace

Solver::Solver(const System& system, const Problem& problem, const Solution& solution)
    : Solver(system, problem, solution, Reached(system, taken(system, problem))) {}

Solver::Solver(const System& system, const Problem& problem, const Solution& solution, const Reached& reached)
    : system_(system),
      problem_(problem),
      maneuver_(maneuver::make_maneuver(system, problem, problem.steps)),
      program_(system, maneuver_, reached.coordinates, reached.rows),
      newton_(program_.sizes()),
      path_(nodes_of(system, problem, solution)) {}

void Solver::set_goal(const Goal& goal) {
  if (!problem_.goal || goal.rest != problem_.goal->rest || goal.periodic)
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
  maneuver_.end_rotation = asked.end_rotation;
  maneuver_.end_position = asked.end_position;
}

void Solver::set_start(const integrator::State& start) {
  const auto total = mechanics::spatial_momentum(system_, start.rotation, start.position, start.momentum);
  const double scale = start.momentum.lpNorm<Eigen::Infinity>();
  if (std::max(total.linear.lpNorm<Eigen::Infinity>(), total.angular.lpNorm<Eigen::Infinity>()) > no_momentum * scale)
    throw InputError("start", "found total momentum, which joint moments cannot change; give a start without");
  if (!system_.only_free_joints())
    throw InputError("start",
                     "found a joint that is not a ball joint, along which a motion does not follow another start "
                     "yet; make a new Solver from a solution of that start");
  // bodies seen from the root follow the start's, less and less towards the end
  const Rotations before = path_.rotation.front();
  for (std::size_t k = 0; k < path_.rotation.size(); ++k) {
    const double share = 1.0 - static_cast<double>(k) / static_cast<double>(path_.rotation.size() - 1);
    Rotations& R = path_.rotation[k];
    for (std::size_t i = 1; i < R.size(); ++i) {
      const Eigen::Matrix3d was = before[0].transpose() * before[i],
                            is = start.rotation[0].transpose() * start.rotation[i];
      R[i] = R[i] * lie::exp(share * lie::log(was.transpose() * is));
    }
  }
  maneuver_.start = start;
  moved_ = true;
}

void Solver::set_duration(double duration) {
  if (!(duration > 0.0) || !std::isfinite(duration))
    throw InputError("duration", "found " + std::to_string(duration) + ", allowed: positive numbers, s");
  maneuver_.duration = duration;
  maneuver_.node_weight =
      maneuver::node_weights(problem_.cost_rule(), problem_.effort, maneuver_.time_step(), maneuver_.steps);
  moved_ = true;
}

optimizer::Options Solver::newton_options() {
  optimizer::Options options;
  options.tolerance = 1e-7;
  return options;
}

optimizer::Outcome Solver::solve(const optimizer::Options& options) {
  optimizer::Outcome outcome;
  program_.retarget(maneuver_);
  if (moved_) {
    if (!program_.go_to(path_)) {
      outcome.reason = "no motion was found through the shapes of the last answer";
      return outcome;
    }
  } else {
    newton_.foresee(program_);
  }
  outcome = newton_.solve(program_, options);
  moved_ = true;
  if (outcome.termination != optimizer::Termination::converged) return outcome;
  const NodePath found = program_.path();
  if (const double error = goal_error(system_, maneuver_, found); error > asked_twice) {
    outcome.termination = optimizer::Termination::infeasible;
    outcome.reason =
        "the goal asks for what moments cannot reach: it stays " + std::to_string(error) + " (rad, m) away";
    return outcome;
  }
  moved_ = false;
  program_.keep_multipliers();
  path_ = found;
  cost_ = program_.cost();
  return outcome;
}

Solution Solver::solution() const {
  Solution solution;
  maneuver::describe_motion(system_, maneuver_.lagrangian, maneuver_.time_step(), path_, solution);
  solution.cost = cost_;
  return solution;
}

}  // namespace lamprey::study
