// What swimmers of ellipses must keep to: a fluid that moves in a plane has nothing to say beside it.
#pragma once

#include "maneuver/problem.hpp"

namespace lamprey::file {

/// Where any body is an ellipse, all are; joints are hinges about e_3 or fixed; inertia, offsets, start, goal, waypoints, obstacles and
/// the price of displacement keep to the plane of e_1 and e_2. model::InputError names the key that does not.
void require_plane(const maneuver::Problem& problem);

}  // namespace lamprey::file
