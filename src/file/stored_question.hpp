// Whether the question that a solution.json repeats is one that a problem file may ask.
#pragma once

#include <string>

#include "maneuver/problem.hpp"

namespace lamprey::file {

/// Why it is not, as the problem file's own reader would say it; empty where it is. Checks of answers to other questions leave
/// parts of them out.
std::string refusal_of(const maneuver::Problem& problem);

}  // namespace lamprey::file
