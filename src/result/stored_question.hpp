// Whether the question that a solution.json repeats is one that a problem file may ask.
#pragma once

#include <string>
#include <vector>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::result {

/// Why it is not, as the problem file's own reader would say it; empty where it is. Checks of answers to other questions leave
/// parts of them out.
std::string refusal_of(const maneuver::Problem& problem);

/// Which of an answer's multipliers belongs to no limit of the problem, or to one that has its own; empty where none does.
std::string foreign_multiplier(const model::System& system, const maneuver::Problem& problem,
                               const std::vector<maneuver::LimitMultiplier>& multipliers);

}  // namespace lamprey::result
