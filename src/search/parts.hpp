// Searches that reach a goal in equal parts, each from rest to rest, and make one motion of them.
#pragma once

#include <vector>

#include "search/grids.hpp"

namespace lamprey::search {

/// A half, a quarter … of the way solved by itself, done twice, solved as the double of it, and so on to the whole. What does not
/// arrive on its way is left as it is, done twice: it gets there all the same.
std::vector<Found> solve_in_parts(const Grids& grids);

}  // namespace lamprey::search
