// Whose moments the columns of a CSV table hold, by its header.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "model/description.hpp"

namespace lamprey::file {

/// What is wrong with a header, as input errors are worded.
struct HeaderFault {
  std::size_t cell;
  std::string found, allowed, cure;
};

/// What a column after the first holds: so much along a direction of a joint's moment.
struct ControlsColumn {
  std::size_t joint;
  Eigen::Vector3d direction;  // unit, parent's frame with the joint at its zero angle
};

struct ControlsHeader {
  std::vector<ControlsColumn> columns;  // [columns − 1]
  bool named = false;                   // by the header; otherwise x, y, z of each joint in the joints' order
  std::optional<HeaderFault> fault;
};

/// x, y, z of each joint in their order.
std::vector<ControlsColumn> columns_in_order(const std::vector<model::JointDescription>& joints);

/// Columns by name where the header has names: "front x", "front.x" or "front_x", with the unit "(N m)" behind it or none, in
/// any order; a hinge's name alone is its moment along its axis, in the place of its x, y and z; of a single joint "x" is
/// enough. A header in which no cell names a joint leaves columns in the joints' order.
ControlsHeader read_controls_header(const std::vector<std::string_view>& cells,
                                    const std::vector<model::JointDescription>& joints);

/// The header that says the same as the joints' order: "t, front x, front y, front z, back x, ...", the first few of it.
std::string controls_header_in_order(const std::vector<model::JointDescription>& joints);

}  // namespace lamprey::file
