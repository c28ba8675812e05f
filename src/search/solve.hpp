// From a problem to candidate maneuvers: starts on a coarse grid, the cheapest few refined to full resolution.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"
#include "search/first_motion.hpp"

namespace lamprey::search {

/// automatic: newton where it takes the problem, ipopt otherwise. both: newton and ipopt from the same first guesses, their minima
/// in one catalogue and the cheapest carried on by newton.
enum class Backend { automatic, newton, ipopt, both };

struct SolveOptions {
  Backend solver = Backend::automatic;
  std::optional<FirstMotion> first = {};             // what the first of the first guesses is; else they are random
  bool first_alone = false;                          // no other first guesses, and no strokes, where it does not arrive
  bool resolving = false;                            // whether more steps follow where these do not resolve the answer
  int workers = 1;                                   // threads (Ipopt: processes); the answer does not depend on it
  std::function<void(const std::string&)> progress;  // a line for people, may be empty
  std::function<bool()> interrupted;                 // asked often; may be empty
  std::function<bool()> hurried = {};                // likewise: interrupted, and nothing is refined any more
  std::optional<bool> refinement;  // whether answers are carried over to other grids; by default where that is cheap
  std::function<bool(maneuver::Solution&)>
      accept;  // whether a candidate can be the answer; may be empty: all are refined
};

struct Candidates {
  std::vector<maneuver::Solution> solution;
  /// Cost of a candidate's minimum on another number of steps; nothing where it is not found. Empty where it was not
  /// asked for. Calls use what `find_candidates` was given.
  std::function<std::optional<double>(std::size_t candidate, int steps)> cost_on_grid;
  /// Why no motion meets the goal, where moments' reach shows it without a search: the candidate then is the start at rest.
  std::string out_of_reach;
  /// How many of the first guesses and hops asked for were not tried, since the search had to end; else empty.
  std::string unsearched;
};

/// Candidates at full resolution, at least one. Status and message are the optimiser's own view, which a certificate confirms
/// or not (see answer); `accept` may change them.
/// Throws model::InputError where the problem itself is at fault.
Candidates find_candidates(const model::System& system, const maneuver::Problem& problem, const SolveOptions& options);

/// The candidates alone.
std::vector<maneuver::Solution> solve(const model::System& system, const maneuver::Problem& problem,
                                      const SolveOptions& options);

}  // namespace lamprey::search
