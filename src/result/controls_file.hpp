// Controls for `lamprey simulate --controls`: the moments of an earlier solution.json, or a table that people write.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "maneuver/node_path.hpp"
#include "result/joint_table.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// How samples run between their times.
enum class ControlSource {
  steps,   // nodes of a solution with control kind "steps": linear
  stages,  // stage nodes of a solution above order 2: in each step the polynomial through them
  spline,  // nodes of a solution with control kind "spline": natural cubic spline through `points` uniform points
  table,   // rows of a CSV table: not-a-knot cubic
  lines    // the same: linear
};

struct ControlSamples {
  ControlSource source = ControlSource::table;
  /// s, rising strictly, at least two; with stages: [steps × s], within each step in the order of the scheme's nodes
  std::vector<double> time;
  /// [time][joints] N m, on the parent, parent's frame. A universal joint's vector is meant with the joint at its zero
  /// angle: along a its moment about the first axis, along Q_0 b about the second, whatever the angles are at that time.
  std::vector<std::vector<Eigen::Vector3d>> control;
  std::size_t stages = 0;                                 // with stages: nodes in each step, s
  int points = 0;                                         // with spline
  maneuver::Scheme scheme = maneuver::Scheme::trapezoid;  // of the solution
  std::optional<maneuver::Start> first = {};              // of the solution: its first node
  /// Rotations and positions at the nodes of one cycle, of a solution with a value at each node whose scheme took every step whole.
  maneuver::NodePath motion = {};
  std::vector<std::pair<int, int>> links = {};  // [joints] parent and child of the solution's swimmer, body indices
  bool gait = false;                            // of a solution whose shape closes
  std::string remark = {};                      // of a table: what its reader should be told; may be empty
};

/// What lamprey export begins a table of moments with, which run linear between its rows.
inline constexpr std::string_view exported_moments =
    "# moments on the parents, x, y, z in the parents' frames at zero angles, of hinges and universal joints also "
    "those of their motors, linear between rows; ";

/// Reads a solution.json (text that begins with '{') or a CSV table: t, then three columns for each joint, in the problem's order
/// or as its header names them (see joint_table_header.hpp); blank lines and lines beginning with # are allowed. The moments of a
/// solution's universal joints, which it shows where the axes stood, are turned back to the zero angle. A table that begins with
/// `exported_moments` is of lines. IoError when the file cannot be read, model::InputError (file, line, column) when it is wrong or is
/// of other joints, by number, name or kind.
ControlSamples read_controls(const std::string& path, const Joints& joints);

/// The same from the file's bytes; `path` only names them.
ControlSamples parse_controls(const std::string& bytes, const std::string& path, const Joints& joints);

/// The moments of a motion that is already there.
ControlSamples controls_of_results(const Results& results, const std::string& path, const Joints& joints);

/// Throws InputError where a table does not begin at 0 s or ends with other moments than it begins with.
void require_period(const std::string& path, const Joints& joints, const ControlSamples& table);

/// A gait's moments at its nodes, or a table's, so many times one after the other; where cycles meet, the mean of both.
void repeat(int cycles, ControlSamples& gait);

/// N m: how far a component of the rows' moments goes at most, and the curve between them.
struct Reach {
  double rows, between;
};
Reach reach_of_table(const ControlSamples& samples);

/// As a sentence: the largest part of a moment that its joint cannot exert and a march leaves out. Empty where there is none. Often
/// these are moments of another frame, such as those that a solution shows of its universal joints.
std::string left_out(const ControlSamples& samples, const std::vector<ResolvedJoint>& joints);

}  // namespace lamprey::result
