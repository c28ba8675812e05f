// Height functions of a swimmer that moves in a plane by two shape variables: what a loop of shapes moves it by, read off as the
// volume over the loop (chapter 9).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "mechanics/connection.hpp"

namespace lamprey::mechanics {

/// A rectangle of shapes: the joints' turns are middle + s₁ direction₁ + s₂ direction₂, as rotation_at_turn has them. A ball joint
/// turns about one of its parent's axes alone.
struct ShapePlane {
  Vectors middle;                    // [joints][3] rad
  std::array<Vectors, 2> direction;  // [joints][3] rad for each of the variable's unit
  std::array<double, 2> low{}, high{};
  int points = 25;  // along each, at least 4
};

/// A place and a heading in the plane, or rates of these by angles.
using Planar = Vector3d;  // (along, across, turn): m, m, rad

/// Told in the frame that shapes disturb least: of all frames that the shape fixes to the root, the one whose rates by the two
/// variables have the least squares over the rectangle, the turn first, whose mean is zero (Hatton and Choset 2011: minimum perturbation coordinates).
/// There the displacement of a loop is the volume over it to higher order than in the root's own frame.
struct HeightFunctions {
  int normal = 2;  // of the root's axes, the one about which it turns; along, across: the next two
  std::array<std::vector<double>, 2> at;  // [points] the variables
  /// [3][points][points] curvature of the local connection by the first (rows) and the second variable: m, m, rad for each of both
  std::array<MatrixXd, 3> height;
  std::array<MatrixXd, 3> frame;  // [3][points][points] the frame's place and heading seen from the root: m, m, rad
};

/// Nothing where the swimmer moves otherwise than in one plane of its root's axes, a ball joint turns about several axes, or the
/// rectangle is no wider than 1e-6 of where it lies.
std::optional<HeightFunctions> height_functions(const model::System& system, const ShapePlane& plane);

/// The frame at a shape, as the root sees it, cubic between nodes.
Planar frame_at(const HeightFunctions& heights, double first, double second);

/// ∬ of the heights, cubic between nodes, over what a closed polygon of shapes goes round, each part as often as it does, counted
/// from the first to the second variable.
Planar volume_over(const HeightFunctions& heights, const std::vector<std::array<double, 2>>& loop);

/// How a frame has moved, seen from where it was: it stood at `from` in the root's, then stands at `to`, and the root has moved by
/// `root`, seen from where that was.
Planar frame_moved(const Planar& from, const Planar& root, const Planar& to);

/// Of a closed loop: the twist that takes the frame at its first shape from where it was to where it is in unit time, which volume_over
/// comes near to. The root has turned by less than half a turn: more turns have no one twist.
Planar twist_of_frame(const Planar& frame, const Planar& root);

/// A twist seen from a frame that has moved: that of the same loop begun at a later shape.
Planar seen_along(const Planar& twist, const Planar& moved);

}  // namespace lamprey::mechanics
