#include "search/slower_joints.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

namespace lamprey::search {

namespace {

using maneuver::Problem;
using optimizer::Termination;

constexpr double held_turn = 0.5;  // rad a step, of a joint
constexpr double faster = 2.0;     // times, as long as they turn by not much more than that
constexpr double not_much = 1.2;   // more than the rounding of rates

double two_digits(double value) {
  const double last = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return last * std::round(value / last);
}

// The problem with joints no faster than so many rad/s, if any.
Problem held_to(const Grids& grids, std::optional<double> joint_rate) {
  Problem held = grids.problem();
  if (!joint_rate) return held;
  held.limits.angular_velocity = std::min(held.limits.angular_velocity.value_or(*joint_rate), *joint_rate);
  for (auto& [joint, own] : held.limits.joint_angular_velocity) own = std::min(own, *joint_rate);
  return held;
}

// The multipliers of what was found, for the rows of such a problem.
shape::LimitMultipliers multipliers_held_to(const Grids& grids, std::optional<double> joint_rate, const Found& found) {
  const auto rows = [&](std::optional<double> rate) {
    return maneuver::limit_rows(grids.system(), held_to(grids, rate));
  };
  return shape::of_rows(found.limit_multipliers, rows(found.joint_rate), rows(joint_rate));
}

std::string at_rate(const Found& held) {
  std::ostringstream words;
  words << "with limits.angular_velocity = " << *held.joint_rate;
  return words.str();
}

// From an answer with joints held on by faster and faster ones.
Found let_go(const Grids& grids, Found held) {
  while (held.joint_rate) {
    const double turn = *held.joint_rate * held.duration / steps_of(held.path);
    Found freer = held;
    freer.joint_rate = turn < not_much * held_turn ? std::optional(faster * *held.joint_rate) : std::nullopt;
    freer.limit_multipliers = multipliers_held_to(grids, freer.joint_rate, held);
    Grid grid = grids.grid(held_to(grids, freer.joint_rate), steps_of(held.path));
    grids.solve(grid, held.path, fine_tolerance, freer);
    if (!freer.converged()) {
      take_effort(freer, held);
      held.outcome.termination = Termination::feasible;
      held.outcome.reason = why_held(held, freer);
      return held;
    }
    held = std::move(freer);
  }
  return held;
}

}  // namespace

std::string why_held(const Found& held, const Found& freer) {
  const Termination end = freer.outcome.termination;
  const std::string reason = at_rate(held) + " it is a minimum, and without that ";
  if (end == Termination::time_limit || end == Termination::interrupted)
    return reason + "there was no time to solve it";
  if (largest_turn(freer.path.rotation).angle > nearly_quarter_turn)
    return reason + "searches lead to turns that no step shows";
  return reason + "a search from there found none: " + freer.outcome.reason;
}

bool whirls(const Grids& grids, const Found& found) {
  if (found.converged() || found.path.rotation.empty() || grids.budget().closing()) return false;
  return !grids.composed() && !grids.passive() && largest_turn(found.path.rotation).angle > nearly_quarter_turn;
}

Found solve_with_slower_joints(const Grids& grids, const maneuver::NodePath& from, int steps, const Found& before) {
  Found found;
  found.outcome = before.outcome;
  found.duration = before.duration;
  found.joint_rate = two_digits(held_turn * steps / before.duration);
  Grid grid = grids.grid(held_to(grids, found.joint_rate), steps);
  grids.solve(grid, from, fine_tolerance, found);
  if (found.converged()) return let_go(grids, std::move(found));
  Found again = before;
  take_effort(found, again);
  return again;
}

Found refine_with_slower_joints(const Grids& grids, const Found& coarse) {
  Found found = coarse;
  found.outcome.termination = Termination::converged;
  found = grids.with(held_to(grids, coarse.joint_rate)).refine(found);
  if (found.converged())
    found = let_go(grids, std::move(found));
  else
    found.outcome.reason = at_rate(coarse) + ", to which this search held them, " + found.outcome.reason;
  found.limit_multipliers = multipliers_held_to(grids, std::nullopt, found);
  return found;
}

}  // namespace lamprey::search
