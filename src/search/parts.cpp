#include "search/parts.hpp"

#include <algorithm>
#include <array>

#include "guess/guess.hpp"
#include "model/input_error.hpp"
#include "search/smaller_problem.hpp"
#include "shape/gait_cycles.hpp"

namespace lamprey::search {

namespace {

using maneuver::Problem;

constexpr std::array part_counts = {2, 4, 8, 16};
constexpr int least_steps_of_part = 12;

// The same motion twice, on `most_steps` at most, as a search for both may begin: with what limits are worth, and what the search has
// cost.
Found doubled(const Grids& whole, const Found& part, int most_steps) {
  Found both;
  count_effort(part.outcome, both.outcome);
  both.duration = 2.0 * part.duration;
  both.limit_multipliers = shape::repeated(part.limit_multipliers, 2);
  const int steps = std::min(2 * steps_of(part.path), most_steps);
  both.path = guess::refined(whole.system(), shape::repeated(part.path, 2), steps);
  return both;
}

// From one part to the whole, by twice as much at a time.
Found solve_from_part(const Grids& grids, int parts) {
  Found found = solve_smaller(grids, part_of(grids.problem(), parts));
  const bool arrived = found.converged();
  while (parts > 1 && arrived && !grids.budget().closing()) {
    parts /= 2;
    const Problem larger = parts == 1 ? grids.problem() : part_of(grids.problem(), parts);
    const Grids whole(grids.system(), larger, grids.options(), grids.budget());
    const int asked_steps = grids.problem().steps;
    const Found twice = doubled(whole, found, parts == 1 ? asked_steps : std::max(asked_steps / parts, coarse_steps));
    Found solved = twice;
    Grid grid = whole.grid(steps_of(twice.path));
    whole.solve(grid, twice.path, fine_tolerance, solved);
    if (solved.converged() || parts == 1) {
      found = std::move(solved);
      continue;
    }
    found = twice;
    take_effort(solved, found);
  }
  if (parts == 1) return found;
  fail_for_want_of_motion(found.outcome);
  found.path = maneuver::NodePath();
  return found;
}

// Parts tell attitudes that the whole may leave free, which mechanics may refuse.
bool may_be_divided(const Grids& grids) {
  if (!has_parts(grids.problem())) return false;
  try {
    const Problem half = part_of(grids.problem(), 2);
    static_cast<void>(maneuver::make_maneuver(grids.system(), half, half.steps));
    return true;
  } catch (const model::InputError&) {
    return false;
  }
}

}  // namespace

std::vector<Found> solve_in_parts(const Grids& grids) {
  if (!may_be_divided(grids)) return {};
  std::vector<int> counts;
  for (int parts : part_counts)
    if (parts * least_steps_of_part <= grids.problem().steps) counts.push_back(parts);
  return grids.in_threads(static_cast<int>(counts.size()), "parts",
                          [&](int n) { return solve_from_part(grids, counts[static_cast<std::size_t>(n)]); });
}

}  // namespace lamprey::search
