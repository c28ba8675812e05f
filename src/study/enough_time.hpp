// How long a motion that its motors are too weak or too slow for would have to take.
#pragma once

#include <optional>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::study {

/// s: the duration in which the same motion keeps limits of moments and of rates. From rest and without springs and dampers total
/// momentum zero moves a swimmer the same way however fast it moves: moments fall with the square of the duration, rates with the
/// duration. Nothing where that is not so, where the motion breaks other limits, or keeps those as it is. `roughly`: of a motion that
/// is not yet one that is asked for, whose other limits do not count.
std::optional<double> enough_time(const model::System& system, const maneuver::Problem& problem,
                                  const maneuver::Solution& solution, bool roughly = false);

}  // namespace lamprey::study
