// Problems that are a part of another: what is done of a motion once, to be done several times.
#pragma once

#include "search/grids.hpp"

namespace lamprey::search {

/// One of so many equal cycles, which go as far as `strokes` of them would: a gait whose shape is free.
maneuver::Problem cycle_of(const maneuver::Problem& whole, int cycles, double strokes);

/// Whether a goal comes in parts: from rest to rest, without waypoints and ends of single bodies.
bool has_parts(const maneuver::Problem& whole);

/// From rest to rest in the first shape, so far that `parts` times of it, each begun where the one before it ends, meet the goal,
/// in as much of its time. Where the goal asks for no turn a part does not turn.
maneuver::Problem part_of(const maneuver::Problem& whole, int parts);

/// Solved by itself, from a few first guesses until one arrives, or by the cheapest of them where a displacement is won; in what a few
/// such tries may take of the time.
Found solve_smaller(const Grids& grids, maneuver::Problem smaller);

}  // namespace lamprey::search
