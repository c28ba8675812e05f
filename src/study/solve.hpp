// From a problem to candidate maneuvers: starts on a coarse grid, the cheapest few refined to full resolution.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::study {

/// automatic: newton where it takes the problem, ipopt otherwise.
enum class Solver { automatic, newton, ipopt };

struct SolveOptions {
  Solver solver = Solver::automatic;
  int workers = 1;                                   // threads (Ipopt: processes); the answer does not depend on it
  std::function<void(const std::string&)> progress;  // a line for people, may be empty
  std::function<bool()> interrupted;                 // asked often; may be empty
  std::function<bool(maneuver::Solution&)>
      accept;  // whether a candidate can be the answer; may be empty: all are refined
};

/// Candidates at full resolution, at least one. Status and message are the optimiser's own view, which a certificate confirms
/// or not (see answer); `accept` may change them.
/// Throws model::InputError where the problem itself is at fault.
std::vector<maneuver::Solution> solve(const model::System& system, const maneuver::Problem& problem,
                                      const SolveOptions& options);

}  // namespace lamprey::study
