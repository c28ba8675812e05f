// Keep-outs and waypoints as pictures show them.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "report/outline.hpp"
#include "result/results.hpp"

namespace lamprey::report {

/// Where the root's mass centre is to be at a waypoint; along directions that it leaves free, where it was.
struct PassedPoint {
  double time;               // s
  Eigen::Vector3d position;  // m, world
};

/// Of waypoints that ask for a position.
std::vector<PassedPoint> passed_points(const result::Results& results);

/// A half-space cut at a depth, on paper: {y : normal·y ≤ offset} is forbidden.
struct PaperHalfPlane {
  Eigen::Vector2d normal;  // unit
  double offset;           // m
};

/// At the depth of a point; nothing where its face lies rather in the paper than across it.
std::optional<PaperHalfPlane> cut(const maneuver::KeepOutHalfSpace& half, const View& view,
                                  const Eigen::Vector3d& point);

/// Ends of the piece of a straight line {y : normal·y = offset} that lies in a box, m; nothing where it passes by.
std::optional<std::array<Eigen::Vector2d, 2>> line_in_box(const PaperHalfPlane& line, const Eigen::Vector2d& low,
                                                          const Eigen::Vector2d& high);

}  // namespace lamprey::report
