// The sections [limits] and [[waypoint]] of a problem file.
#pragma once

#include "file/toml_reader.hpp"
#include "maneuver/problem.hpp"

namespace lamprey::file {

/// Whether a value is the word "free".
bool says_free(const document::TomlValue& value);

/// `move` of a goal or a waypoint: three entries, each a number (m) or "free"; all free where the key is absent.
std::array<std::optional<double>, 3> read_move(const TableReader& table);

/// `turn` of a goal or a waypoint, rad; nothing where it is "free" or absent.
std::optional<Eigen::Vector3d> read_turn(const TableReader& table);

/// After the swimmer.
void read_limits(const TableReader& table, maneuver::Problem& problem);
void read_waypoints(const TableReader& document, maneuver::Problem& problem);

/// Limits are of quantities that their joints have: throws model::InputError with the key alone, as do the next.
void check_limits(const maneuver::Problem& problem);

/// Waypoints ask for something, at nodes between start and end, and do not contradict each other.
void check_waypoints(const maneuver::Problem& problem);

}  // namespace lamprey::file
