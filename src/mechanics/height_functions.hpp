// Height functions of a swimmer that moves in a plane by two angles of its joints: what a loop of shapes moves it by, read off as
// the volume over the loop (chapter 9).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "mechanics/connection.hpp"

namespace lamprey::mechanics {

/// A rectangle of shapes: two angles change, all other joints stay at their zero angle.
struct ShapePlane {
  struct Angle {
    int joint = 0, axis = 0;       // of a ball joint about the parent's axis
    double low = 0.0, high = 0.0;  // rad
  };
  std::array<Angle, 2> angle;
  int points = 25;  // along each
};

/// A place and a heading in the plane, or rates of these by angles.
using Planar = Vector3d;  // (along, across, turn): m, m, rad

/// Told in the frame that the angles disturb least: of all frames that the shape fixes to the root, the one whose rates by the two
/// angles have the least squares over the rectangle, the turn first (Hatton and Choset 2011: minimum perturbation coordinates).
/// There the displacement of a loop is the volume over it to higher order than in the root's own frame.
struct HeightFunctions {
  int normal = 2;  // of the root's axes, the one about which it turns; along, across: the next two
  std::array<std::vector<double>, 2> angle;  // [points] rad
  /// [3][points][points] curvature of the local connection by the first (rows) and the second angle: m, m, rad for each rad²
  std::array<MatrixXd, 3> height;
  std::array<MatrixXd, 3> frame;  // [3][points][points] the frame's place and heading seen from the root: m, m, rad
};

/// Nothing where the swimmer moves otherwise than in one plane of its root's axes.
std::optional<HeightFunctions> height_functions(const model::System& system, const ShapePlane& plane);

/// The frame at a shape, as the root sees it, linear between nodes.
Planar frame_at(const HeightFunctions& heights, double first, double second);

/// ∬ of the heights over what a closed polygon of shapes goes round, each part as often as it does, counted from the first to the
/// second angle.
Planar volume_over(const HeightFunctions& heights, const std::vector<std::array<double, 2>>& loop);

/// What the root's displacement (seen from where it began) is to the frame at the shape where the loop begins and ends: the twist
/// that takes the frame from one to the other in unit time, to which volume_over comes near.
Planar displacement_of_frame(const Planar& frame, const Planar& root);

}  // namespace lamprey::mechanics
