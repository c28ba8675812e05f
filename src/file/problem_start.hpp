// The [start] of a problem file: where bodies are and how they move, from what it states of bodies and of joint angles.
#pragma once

#include "file/toml_reader.hpp"
#include "maneuver/problem.hpp"

namespace lamprey::file {

/// Reads the start of a swimmer whose tree and joints have been checked.
void read_start(const TableReader& table, maneuver::Problem& problem);

/// With start.zero_momentum: joints turn as the start says while the whole moves so that its total momentum is zero. After all checks.
void balance_start(const TableReader& table, maneuver::Problem& problem);

}  // namespace lamprey::file
