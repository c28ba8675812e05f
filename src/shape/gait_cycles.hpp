// A gait repeated: each cycle begins where and as the one before it ends.
#pragma once

#include "maneuver/node_path.hpp"
#include "maneuver/solution.hpp"
#include "shape/limit_terms.hpp"

namespace lamprey::shape {

using maneuver::NodePath;
using maneuver::Solution;

/// The gait `cycles` times over, [cycles N + 1] nodes with their moments, velocities and gains; all else is left out. Where two
/// cycles meet, a node has the mean of the moments that both have there, half a step's impulse of each. Gains that answer world
/// directions turn with the swimmer. The gait's moments are at its nodes, one scheme's step between them.
Solution repeated(const Solution& gait, int cycles);

/// The same of a path up to order 2, as a first guess of a gait that takes several strokes.
NodePath repeated(const NodePath& gait, int cycles);

/// What limits are worth in it, alike in each cycle.
LimitMultipliers repeated(const LimitMultipliers& gait, int cycles);

/// The same motion begun elsewhere: its root at `position` (m, world), headed as `heading` (body → world); gains turn with it.
Solution begun_at(const Solution& gait, const Eigen::Vector3d& position, const Eigen::Matrix3d& heading);

}  // namespace lamprey::shape
