// What moments can do to a swimmer near a motion: which coordinates they move, which end conditions they can meet.
#pragma once

#include "maneuver/end_rows.hpp"
#include "maneuver/node_path.hpp"

namespace lamprey::maneuver {

/// Coordinates that moments can move along a motion and near it: fewer than all where symmetry keeps the swimmer in a
/// plane, say.
ShapeCoordinates reachable_coordinates(const model::System& system, const Maneuver& maneuver, const NodePath& path);

/// Of the conditions a maneuver states those that moments along a motion can meet independently: momentum conservation and
/// symmetry make others follow from them.
std::vector<EndRow> independent_end_rows(const model::System& system, const Maneuver& maneuver,
                                         const ShapeCoordinates& coordinates, const NodePath& path);

}  // namespace lamprey::maneuver
