#include "search/stroke_searches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "guess/guess.hpp"
#include "guess/strokes.hpp"
#include "guess/whole_turns.hpp"
#include "lie/so3.hpp"
#include "search/smaller_problem.hpp"
#include "shape/gait_cycles.hpp"

namespace lamprey::search {

namespace {

using maneuver::NodePath;
using maneuver::Problem;

constexpr std::array stroke_counts = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
constexpr std::array cycle_counts = {2, 3, 5, 8, 16};
constexpr std::array gait_counts = {3, 5, 8, 11, 14, 18, 24};
constexpr double lost_strokes = 1.2;  // to those that grow and shrink
constexpr std::size_t solved_strokes = 4;
constexpr int least_steps_of_stroke = 12, steps_of_stroke = 20;
constexpr int least_steps_of_turn = 16, steps_of_turn = 25;
constexpr int searches_of_turns = 4;
constexpr double wholly_turned = 0.25;    // of the drawings
constexpr int most_turns = 8;             // of a joint
constexpr int drawn_turns = 4;            // of which the most promising one is solved
constexpr int free_durations = 8;         // tried of strokes, and one
constexpr double little_broken = 0.1;     // units of the limits, which a search mends
constexpr double goal_of_strokes = 1e-3;  // units of the end rows, what is missed

// Strokes towards the goal, and how they keep to the limits.
struct StrokesOnGrid {
  int strokes;
  bool within_limits;
  NodePath path = {};
  double duration = 0.0;  // s
  double missed = 0.0, broken = 0.0, cost = 0.0;
  std::tuple<bool, double, double, double> rank() const {
    const auto known = [](double value) { return std::isnan(value) ? std::numeric_limits<double>::infinity() : value; };
    return {path.rotation.empty(), missed > goal_of_strokes ? missed : 0.0, known(broken), known(cost)};
  }
};

// s: that of the problem, or where it is free some from the least to the most.
std::vector<double> durations_of(const maneuver::Duration& asked) {
  if (!asked.free) return {asked.value};
  std::vector<double> durations;
  for (int n = 0; n <= free_durations; ++n)
    durations.push_back(asked.min * std::pow(asked.max / asked.min, static_cast<double>(n) / free_durations));
  return durations;
}

// Where strokes get a swimmer that begins at rest does not depend on how fast they are: where the duration is free they have the
// most that there is, to be kept to rates, and then the one at which they break limits and cost least.
StrokesOnGrid swum(const Grids& grids, StrokesOnGrid tried) {
  const int steps = std::min(grids.problem().steps, std::max(grids.coarse(), tried.strokes * steps_of_stroke));
  const maneuver::Duration& asked = grids.problem().duration;
  Grid grid = grids.grid(steps);
  const guess::StrokeLimits kept = tried.within_limits
                                       ? guess::stroke_limits(grids.system(), grids.problem(), grid.maneuver.start,
                                                              asked.free ? asked.max : asked.value, tried.strokes)
                                       : guess::no_stroke_limits(grids.system());
  const guess::Strokes found =
      guess::strokes_to_goal(grids.system(), grid.maneuver, grids.reached().coordinates, grids.reached().rows, kept,
                             tried.strokes, seed_of_start(grids.problem(), 0));
  if (found.path.rotation.empty()) return tried;
  tried.missed = found.missed;
  for (const double duration : durations_of(asked)) {
    grid.program.take_duration(duration);
    if (!grid.program.go_to(found.path)) continue;
    const double broken = grid.program.limit_violation(), cost = grid.program.cost();
    const double more = std::max(broken, little_broken), before = std::max(tried.broken, little_broken);
    if (!tried.path.rotation.empty() && std::tuple(more, cost) >= std::tuple(before, tried.cost)) continue;
    tried.path = found.path;
    tried.duration = duration;
    tried.broken = broken;
    tried.cost = cost;
  }
  return tried;
}

// From rest through so many cycles of a gait to rest: its shapes grow out of the first one over the first cycle, and go back over
// the last.
NodePath begun_and_ended_at_rest(const Grids& grids, const maneuver::Maneuver& maneuver, const NodePath& cycle,
                                 int cycles) {
  const model::System& system = grids.system();
  const NodePath gait = guess::refined(system, shape::repeated(cycle, cycles), maneuver.steps);
  return guess::swung(system, maneuver, [&](int j, double fraction) -> Eigen::Vector3d {
    const model::Joint& joint = system.joint(j);
    const auto node = static_cast<std::size_t>(std::lround(fraction * maneuver.steps));
    const double grown = guess::blend(std::min({1.0, cycles * fraction, cycles * (1.0 - fraction)}));
    const Eigen::Matrix3d first = mechanics::child_to_parent(maneuver.start.rotation, joint);
    const Eigen::Matrix3d now = mechanics::child_to_parent(gait.rotation[node], joint);
    if (joint.free()) return grown * lie::log(now * first.transpose());
    return grown * (mechanics::joint_angles(joint, now) - mechanics::joint_angles(joint, first));
  });
}

}  // namespace

std::vector<Found> solve_gaits_from_rest(const Grids& grids) {
  const maneuver::Goal& goal = *grids.problem().goal;
  if (!goal.stills_joints() || !goal.rotation.empty() || !goal.angle.empty() || !grids.problem().waypoints.empty())
    return {};
  std::vector<int> counts;
  for (int cycles : gait_counts)
    if (cycles * least_steps_of_stroke <= grids.problem().steps) counts.push_back(cycles);
  return grids.in_threads(static_cast<int>(counts.size()), "gaits from rest", [&](int n) {
    const int cycles = counts[static_cast<std::size_t>(n)];
    const Found cycle = solve_smaller(grids, cycle_of(grids.problem(), cycles, cycles - lost_strokes));
    Found found;
    count_effort(cycle.outcome, found.outcome);
    fail_for_want_of_motion(found.outcome);
    if (!cycle.converged()) return found;
    found.duration = cycles * cycle.duration;
    Grid grid = grids.grid(std::min(grids.problem().steps, std::max(grids.coarse(), cycles * steps_of_stroke)));
    grids.solve(grid, begun_and_ended_at_rest(grids, grid.maneuver, cycle.path, cycles), fine_tolerance, found);
    return found;
  });
}

std::vector<Found> solve_swum_strokes(const Grids& grids) {
  std::vector<StrokesOnGrid> tries;
  for (int strokes : stroke_counts)
    for (const bool within_limits : {false, true})
      if (strokes * least_steps_of_stroke <= grids.problem().steps) tries.push_back({strokes, within_limits});
  grids.in_threads(static_cast<int>(tries.size()), "", [&](int n) {
    tries[static_cast<std::size_t>(n)] = swum(grids, tries[static_cast<std::size_t>(n)]);
    return Found();
  });
  std::sort(tries.begin(), tries.end(), [](const auto& a, const auto& b) { return a.rank() < b.rank(); });
  while (!tries.empty() && (tries.back().path.rotation.empty() || tries.size() > solved_strokes)) tries.pop_back();
  return grids.in_threads(static_cast<int>(tries.size()), "strokes", [&](int n) {
    const StrokesOnGrid& from = tries[static_cast<std::size_t>(n)];
    Grid grid = grids.grid(steps_of(from.path));
    Found found;
    found.duration = from.duration;
    grids.solve(grid, from.path, fine_tolerance, found);
    return found;
  });
}

namespace {

// Drawn turns and the strokes that bring them to the goal; no path where they do not get there.
StrokesOnGrid turned_round(const Grids& grids, maneuver::Random& random) {
  StrokesOnGrid tried{.strokes = 1, .within_limits = false};
  const model::System& system = grids.system();
  const Problem& problem = grids.problem();
  const auto& [coordinates, rows, reason] = grids.reached();
  const int most = std::min(problem.steps / least_steps_of_turn, most_turns);
  const double share_of_way =
      random.uniform() < wholly_turned ? 1.0 : random.uniform();  // strokes may do the rest cheaper
  const std::optional<guess::WholeTurns> turns =
      guess::whole_turns_to_goal(system, maneuver::make_maneuver(system, problem, problem.steps), coordinates, rows,
                                 guess::joints_that_turn_round(system, problem), share_of_way, most, random);
  if (!turns) return tried;
  double largest = 0.0;
  for (const Eigen::Vector3d& turn : *turns) largest = std::max(largest, turn.norm() / (2.0 * std::numbers::pi));
  Grid grid = grids.grid(std::min(problem.steps, std::max(grids.coarse(), static_cast<int>(largest * steps_of_turn))));
  const guess::Strokes found =
      guess::strokes_to_goal(system, grid.maneuver, coordinates, rows, guess::no_stroke_limits(system), tried.strokes,
                             static_cast<std::uint64_t>(1e15 * random.uniform()), *turns);
  tried.duration = problem.duration.value;
  grid.program.take_duration(tried.duration);
  if (found.path.rotation.empty() || !grid.program.go_to(found.path)) return tried;
  tried.path = found.path;
  tried.missed = found.missed;
  tried.broken = grid.program.limit_violation();
  tried.cost = grid.program.cost();
  return tried;
}

}  // namespace

Found solve_whole_turns(const Grids& grids, std::uint64_t seed) {
  maneuver::Random random(seed);
  StrokesOnGrid best = turned_round(grids, random);
  for (int draw = 1; draw < drawn_turns && !grids.budget().closing(); ++draw)
    if (StrokesOnGrid other = turned_round(grids, random); other.rank() < best.rank()) best = std::move(other);
  Found found;
  if (best.path.rotation.empty()) {
    fail_for_want_of_motion(found.outcome);
    return found;
  }
  found.duration = best.duration;
  Grid grid = grids.grid(steps_of(best.path));
  grids.solve(grid, best.path, fine_tolerance, found);
  return found;
}

std::vector<Found> solve_whole_turns(const Grids& grids) {
  if (guess::joints_that_turn_round(grids.system(), grids.problem()).empty()) return {};
  return grids.in_threads(searches_of_turns, "whole turns", [&](int n) {
    return solve_whole_turns(grids, seed_of_start(grids.problem(), grids.problem().search.starts + n));
  });
}

namespace {

// As many cycles as there are steps for; none where a gait's shape is given.
int most_cycles(const Problem& problem) {
  const bool given = !problem.start.free_shape || !problem.waypoints.empty() || !problem.goal->rotation.empty();
  return given ? 0 : problem.steps / least_steps_of_stroke;
}

Found solve_several_cycles(const Grids& grids, int cycles) {
  const int steps = std::min(grids.problem().steps, std::max(grids.coarse(), cycles * steps_of_stroke));
  const Found cycle = solve_smaller(grids, cycle_of(grids.problem(), cycles, cycles));
  Found found;
  count_effort(cycle.outcome, found.outcome);
  if (!cycle.converged()) {
    fail_for_want_of_motion(found.outcome);
    return found;
  }
  found.duration = cycles * cycle.duration;
  found.limit_multipliers = shape::repeated(cycle.limit_multipliers, cycles);
  Grid grid = grids.grid(steps);
  grids.solve(grid, guess::refined(grids.system(), shape::repeated(cycle.path, cycles), steps), fine_tolerance, found);
  return found;
}

}  // namespace

std::vector<Found> solve_cycles(const Grids& grids) {
  std::vector<int> counts;
  for (int cycles : cycle_counts)
    if (cycles <= most_cycles(grids.problem())) counts.push_back(cycles);
  return grids.in_threads(static_cast<int>(counts.size()), "strokes",
                          [&](int n) { return solve_several_cycles(grids, counts[static_cast<std::size_t>(n)]); });
}

std::vector<Found> solve_more_cycles(const Grids& grids) {
  constexpr int at_once = 2;  // odd and even numbers of them may differ
  const int most = most_cycles(grids.problem());
  double before = std::numeric_limits<double>::infinity();  // cost of the cheapest of as many less two
  std::vector<Found> all;
  for (int first = 2; first <= most && !grids.budget().closing(); first += at_once) {
    const std::vector<Found> found = grids.in_threads(std::min(at_once, most - first + 1), "several cycles",
                                                      [&](int n) { return solve_several_cycles(grids, first + n); });
    double cheapest = std::numeric_limits<double>::infinity();
    for (const Found& one : found)
      if (one.converged()) cheapest = std::min(cheapest, one.cost);
    all.insert(all.end(), found.begin(), found.end());
    if (!(cheapest < before)) break;
    before = cheapest;
  }
  return all;
}

}  // namespace lamprey::search
