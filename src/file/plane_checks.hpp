// What swimmers of ellipses must keep to: a fluid that moves in a plane has nothing to say beside it.
#pragma once

#include "maneuver/problem.hpp"
#include "model/system.hpp"

namespace lamprey::file {

/// Where any body is an ellipse, all are; joints are hinges about e_3 or fixed; inertia, offsets, start, goal, waypoints, obstacles and
/// the price of displacement keep to the plane of e_1 and e_2. model::InputError names the key that does not.
void require_plane(const maneuver::Problem& problem);

/// Whether the start and all that joints exert are mirrored at the plane across world axis `axis` (0, 1, 2) through the root's mass
/// centre, so that no motion leaves it. False also where it is only not seen: universal joints, ball joints of a free first shape.
bool stays_in_plane(const model::System& system, const maneuver::Start& start, int axis);

/// The same problem, but goal and waypoints tell 0, not free, along an axis across the plane that the swimmer stays in.
maneuver::Problem with_plane_told(const model::System& system, maneuver::Problem problem);

}  // namespace lamprey::file
