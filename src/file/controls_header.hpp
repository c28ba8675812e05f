// Whose moments the columns of a CSV table hold, by its header.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/description.hpp"

namespace lamprey::file {

/// What is wrong with a header, as input errors are worded.
struct HeaderFault {
  std::size_t cell;
  std::string found, allowed, cure;
};

struct ControlsHeader {
  /// [columns − 1] which component each column after the first holds: 3 × joint + 0, 1, 2 for x, y, z.
  std::vector<std::size_t> component;
  bool named = false;  // by the header; otherwise in the joints' order
  std::optional<HeaderFault> fault;
};

/// Columns by name where the header has names: "front x", "front.x" or "front_x", with the unit "(N m)" behind it or none, in
/// any order; of a single joint "x" is enough. A header in which no cell names a joint leaves columns in the joints' order.
ControlsHeader read_controls_header(const std::vector<std::string_view>& cells,
                                    const std::vector<model::JointDescription>& joints);

/// The header that says the same as the joints' order: "t, front x, front y, front z, back x, ...", the first few of it.
std::string controls_header_in_order(const std::vector<model::JointDescription>& joints);

}  // namespace lamprey::file
