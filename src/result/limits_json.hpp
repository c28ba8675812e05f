// Limits, waypoints and the multipliers of limits as solution.json holds them: the words of the problem file.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "document/json_document.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::result {

/// One JSON object on one line; keys that the problem file left out are left out.
std::string limits_text(const maneuver::Limits& limits);
maneuver::Limits read_limits(const document::JsonReader& reader);

/// The displacement of a goal or a waypoint: three entries, each a number or "free".
std::string move_text(const std::array<std::optional<double>, 3>& move);
std::array<std::optional<double>, 3> read_move(const document::JsonReader& reader);

/// A JSON array of objects, one line each.
std::string waypoints_text(const std::vector<maneuver::Waypoint>& waypoints);
std::vector<maneuver::Waypoint> read_waypoints(const document::JsonReader& reader);

/// A JSON array of objects {key, joint, bodies, component, time, multiplier [N + 1]}, one line each.
std::string limit_multipliers_text(const std::vector<maneuver::LimitMultiplier>& multipliers);
std::vector<maneuver::LimitMultiplier> read_limit_multipliers(const document::JsonReader& reader, std::size_t nodes);

}  // namespace lamprey::result
