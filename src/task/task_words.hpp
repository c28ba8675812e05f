// Limits, waypoints and ends of joints of a problem in words, wherever people read of them.
#pragma once

#include <string>
#include <vector>

#include "maneuver/problem.hpp"

namespace lamprey::task {

/// How numbers are written, such as short_number.
using NumberText = std::string (*)(double);

/// One line for each limit, with its unit: "moment at each joint up to 400 N m"; none where there are no limits.
std::vector<std::string> limit_lines(const maneuver::Limits& limits, NumberText number);

/// One line for each waypoint: "at 0.5 s: 0.2 m along e₃ from the start". Where the first shape is free the root alone is turned.
std::vector<std::string> waypoint_lines(const std::vector<maneuver::Waypoint>& waypoints, bool free_shape,
                                        NumberText number);

/// How joints are told to end: "joint fin ends at 0.4 rad", "other joints end as they begin"; none where they are not.
std::vector<std::string> joint_end_lines(const maneuver::Goal& goal, NumberText number);

}  // namespace lamprey::task
