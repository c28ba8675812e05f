// Rules of a problem file's [goal] that reach beyond one key.
#pragma once

#include "maneuver/problem.hpp"

namespace lamprey::file {

/// The goal asks for something and does not contradict itself, the joints or the start. Throws model::InputError with the key alone.
void check_goal(const maneuver::Problem& problem);

}  // namespace lamprey::file
