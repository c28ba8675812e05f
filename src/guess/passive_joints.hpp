// Joints that no motor moves: what they do while the others go a given way.
#pragma once

#include <optional>

#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"
#include "shape/pose_at_end.hpp"

namespace lamprey::guess {

using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::ShapeCoordinates;

/// The motion of a path whose moved joints go as they do there while those directions that no moment acts along follow, by their
/// springs, dampers and inertia and that of the fluid, at zero total momentum: node by node, by Newton's method on the shape to come.
/// Nothing where that is not found, as where steps are too long for a spring. For starts without total momentum.
std::optional<NodePath> with_passive_joints(const model::System& system, const Maneuver& maneuver,
                                            const ShapeCoordinates& coordinates, const NodePath& path);

/// The cycle of a path whose shapes close, with a first shape that is free: the moved joints swing by this share of what they do
/// there, by less where the others cannot go along, and these go round with them so that nothing asks for a moment where no motor is: all
/// nodes at once, by Newton's method (chapter 9). Nothing where that is not found.
std::optional<NodePath> cycle_of_passive_joints(const model::System& system, const Maneuver& maneuver,
                                                const ShapeCoordinates& coordinates, const NodePath& path,
                                                double share);

}  // namespace lamprey::guess
