// Mirror images: a question that a reflection leaves as it is has answers in pairs of equal cost, of which one turns the asked way.
#pragma once

#include <optional>

#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"

namespace lamprey::guess {

using Eigen::Vector3d;
using maneuver::Maneuver;
using maneuver::NodePath;

/// A coordinate axis whose reversal, in the world and in every body, turns `turn` (rotation vector, world) into its opposite and leaves
/// swimmer, start, goal and cost as they are: inertia, offsets and control axes, start at rest, end rotations and position,
/// displacements that are won. Nothing where there is none.
std::optional<int> mirror_axis(const model::System& system, const Maneuver& maneuver, const Vector3d& turn);

/// The image of a motion under reversal of that axis through its start: R → PRP, displacements → P, moments → −P.
NodePath mirrored(const model::System& system, const NodePath& path, int axis);

/// Whether the root comes to its end by the other way round than a turn by `turn` (rotation vector, world): by −π for π.
bool turns_against(const Vector3d& turn, const NodePath& path);

}  // namespace lamprey::guess
