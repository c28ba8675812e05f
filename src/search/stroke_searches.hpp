// Searches that begin with many strokes: the more limits the fewer single strokes serve.
#pragma once

#include <vector>

#include "search/grids.hpp"

namespace lamprey::search {

/// From rest to rest: few strokes towards the goal or many, within the limits and without, more than once each; the most
/// promising are solved.
std::vector<Found> solve_swum_strokes(const Grids& grids);

/// From rest to rest: joints that turn all the way round towards the goal, and strokes for the rest of the way. A search that has
/// not arrived where nothing of that kind was found.
Found solve_whole_turns(const Grids& grids, std::uint64_t seed);
/// The same several times, where first guesses and strokes have found nothing.
std::vector<Found> solve_whole_turns(const Grids& grids);

/// From rest to rest: cycles of a gait, which grow out of rest and go back to it.
std::vector<Found> solve_gaits_from_rest(const Grids& grids);

/// Of a gait with a free shape: from a smaller one, done several times over.
std::vector<Found> solve_cycles(const Grids& grids);

/// The same where gaits are known: more and more cycles as long as more of them cost less than fewer. No smooth way leads from one
/// cycle in a period to two.
std::vector<Found> solve_more_cycles(const Grids& grids);

}  // namespace lamprey::search
