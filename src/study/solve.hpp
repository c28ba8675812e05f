// From a problem to its best maneuver: starts on a coarse grid, the cheapest refined to full resolution.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::study {

struct SolveOptions {
  int workers = 1;                                      // processes for the starts; the answer does not depend on it
  std::function<void(const std::string&)> progress;     // a line for people, may be empty
  std::function<bool()> interrupted;                    // asked often; may be empty
};

/// Solves the problem; the status is the optimiser's own view, which a certificate confirms or not (see judge).
/// Throws model::InputError where the problem itself is at fault.
maneuver::Solution solve(const model::System& system, const maneuver::Problem& problem, const SolveOptions& options);

}  // namespace lamprey::study
