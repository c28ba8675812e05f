// Between problems and results: what solution.json says of its problem, and the problem that it says.
#pragma once

#include "model/system.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// The problem with defaults filled in and names resolved.
ResolvedProblem resolve(const model::System& system, const maneuver::Problem& problem);

/// The swimmer of stored results, every inertia stated.
model::SwimmerDescription swimmer_of(const ResolvedProblem& resolved);

/// The problem that stored results answer, from their own numbers: start state from the first node.
maneuver::Problem problem_of(const Results& results);

/// Version, build, compiler and machine of this program; the caller adds command, hash and seed.
Provenance provenance_here();

}  // namespace lamprey::result
