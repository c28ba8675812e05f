// Controls for `lamprey simulate --controls`: the moments of an earlier solution.json, or a table that people write.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "maneuver/problem.hpp"

namespace lamprey::file {

/// How samples run between their times.
enum class ControlSource {
  steps,   // nodes of a solution with control kind "steps": linear
  spline,  // nodes of a solution with control kind "spline": natural cubic spline through `points` uniform points
  table    // rows of a CSV table: not-a-knot cubic
};

struct ControlSamples {
  ControlSource source = ControlSource::table;
  std::vector<double> time;                               // s, strictly rising, at least two
  std::vector<std::vector<Eigen::Vector3d>> control;      // [time][joints] N m, on the parent, parent's frame
  int points = 0;                                         // with spline
  maneuver::Scheme scheme = maneuver::Scheme::trapezoid;  // of the solution
};

/// Reads a solution.json (text that begins with '{') or a CSV table: t, then three columns for each joint, in the problem's order;
/// a header line, blank lines and lines beginning with # are allowed. IoError when the file cannot be read, model::InputError
/// (file, line, column) when it is wrong or has not `joints` joints.
ControlSamples read_controls(const std::string& path, int joints);

/// The same from the file's bytes; `path` only names them.
ControlSamples parse_controls(const std::string& bytes, const std::string& path, int joints);

}  // namespace lamprey::file
