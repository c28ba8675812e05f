// Goals and waypoints that put the root where, however it is turned, it is within what limits keep it out of.
#pragma once

#include "maneuver/problem.hpp"
#include "model/system.hpp"

namespace lamprey::file {

/// Throws model::InputError for the first such end or waypoint. What leaves open a direction that matters is not looked at.
void require_room_for_root(const model::System& system, const maneuver::Problem& problem);

}  // namespace lamprey::file
