// What the columns of a table over joints hold, by its header.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "model/description.hpp"

namespace lamprey::result {

/// Moments on the parents (N m), or angles from the joints' zero angles (rad, or deg where the header says so).
enum class TableKind { moments, angles };

/// What is wrong with a header, as input errors are worded.
struct HeaderFault {
  std::size_t cell;
  std::string found, allowed, cure;
};

/// What a column after the first holds: so much along a direction of a joint's moment, or of its turn.
struct TableColumn {
  std::size_t joint;
  Eigen::Vector3d
      direction;       // moments: unit, parent's frame with the joint at its zero angle; angles: [3] of joint_angle
  bool again = false;  // a motor's moment where x, y and z hold it, too
};

struct NamedColumn {
  std::string name;  // without unit
  TableColumn column;
};

struct TableHeader {
  std::vector<TableColumn> columns;  // [columns − 1]
  bool named = false;                // by the header; otherwise those of each joint in the joints' order
  std::optional<HeaderFault> fault;
};

/// Of a hinge, parent's frame, unit.
Eigen::Vector3d moment_axis(const model::JointDescription& joint);

/// Of moments x, y, z of each joint in their order; of angles those of each joint's freedoms: one of a hinge, the two of a universal
/// joint, of a ball joint x, y, z of its rotation vector.
std::vector<TableColumn> columns_in_order(TableKind kind, const std::vector<model::JointDescription>& joints);

/// Columns by name where the header has names: "front x", "front.x" or "front_x", with the unit "(N m)" behind it or none, in
/// any order; a hinge's name alone is its motor's moment along its axis, or its angle; "fin 1" and "fin 2" are those of
/// the motors of a universal joint, or its angles; motors' moments stand in the place of x, y and z, or beside them; of
/// a single joint "x" is enough. Joints that exert no moments may be left out. Of angles all columns have a unit, or none. A header in which no cell names a joint leaves columns in the joints' order.
TableHeader read_table_header(TableKind kind, const std::vector<std::string_view>& cells,
                              const std::vector<model::JointDescription>& joints);

/// What a header without names of these joints seems to call its own: its cells without units, x, y, z, 1 and 2; each once.
std::vector<std::string> names_in_header(const std::vector<std::string_view>& cells);

/// Names of the columns in the joints' order, without units.
std::vector<std::string> column_names(TableKind kind, const std::vector<model::JointDescription>& joints);

/// What a table of a motion holds: the columns in the joints' order, and after those of each joint the moments of its
/// motors.
std::vector<NamedColumn> columns_to_write(TableKind kind, const std::vector<model::JointDescription>& joints);

/// The header that says the same as the joints' order: "t, front x, front y, front z, back x, ...", the first few of it.
std::string header_in_order(TableKind kind, const std::vector<model::JointDescription>& joints);

}  // namespace lamprey::result
