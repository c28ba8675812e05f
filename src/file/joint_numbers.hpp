// Numbers that a problem file gives by joint, one about each of its axes.
#pragma once

#include <optional>
#include <vector>

#include "file/toml_reader.hpp"
#include "model/description.hpp"

namespace lamprey::file {

/// A table whose keys are names of joints.
TableReader table_of_joints(const TableReader& table, const char* name, const model::SwimmerDescription& swimmer);

/// Of a hinge one number, of a universal joint two, of a ball joint the three of its rotation vector from its zero angle; none of a
/// fixed joint.
std::optional<std::vector<double>> read_angles(const TableReader& table, const model::JointDescription& joint);

/// The rates of a hinge's or a universal joint's angles, rad/s. `instead`: the table by body that serves others.
std::optional<std::vector<double>> read_angle_rates(const TableReader& table, const model::JointDescription& joint,
                                                    const char* instead);

/// A joint's numbers stand in the place of its child's.
void refuse_both(const TableReader& by_joint, const TableReader& by_body, const model::JointDescription& joint);

}  // namespace lamprey::file
