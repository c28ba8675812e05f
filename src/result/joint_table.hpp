// CSV tables over the joints that people write: times, then columns for each joint.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "model/description.hpp"
#include "result/joint_table_header.hpp"

namespace lamprey::result {

inline constexpr std::size_t table_byte_limit = std::size_t{1} << 30;

/// Of the swimmer that is to move.
using Joints = std::vector<model::JointDescription>;

struct JointTable {
  std::vector<double> time;                         // s, rising strictly, at least two
  std::vector<std::vector<Eigen::Vector3d>> value;  // [time][joints] N m or rad, as TableColumn says
  std::vector<bool> left_out;                       // [joints] whether the header names nothing of a joint
  std::string remark;                               // what its reader should be told; may be empty
};

/// t, then the columns of each joint, in the problem's order or as a header names them (joint_table_header.hpp); blank lines and
/// lines beginning with # are allowed. model::InputError (file, line, column) when it is wrong; `path` only names it.
JointTable parse_joint_table(TableKind kind, std::string_view text, const std::string& path, const Joints& joints);

}  // namespace lamprey::result
