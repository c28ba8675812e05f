// Searches with joints held from whirling. A step shows turns up to a quarter turn, and next to it almost nothing of what they cost:
// there searches may stall, or find all that is cheaper. Where joints are held to less there are minima, which may be some without
// that, too, if not on so few steps.
#pragma once

#include <string>

#include "search/grids.hpp"

namespace lamprey::search {

/// Whether a search that has not arrived has run to such turns, and slower joints may help.
bool whirls(const Grids& grids, const Found& found);

/// Why an answer with joints held stays one, where a search from it that leaves them freer found no minimum.
std::string why_held(const Found& held, const Found& freer);

/// From a motion on so many steps: with joints held to half a radian a step, then to more and more, until they are free. Where that
/// leads to none, the last answer with joints held, feasible, its `joint_rate` and a reason that names the limit; what was there
/// `before` where there is no such answer.
Found solve_with_slower_joints(const Grids& grids, const maneuver::NodePath& from, int steps, const Found& before);

/// Such an answer carried on to all steps, and there again until joints are free.
Found refine_with_slower_joints(const Grids& grids, const Found& coarse);

}  // namespace lamprey::search
