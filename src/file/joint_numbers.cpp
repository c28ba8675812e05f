#include "file/joint_numbers.hpp"

#include <fmt/format.h>

#include "file/words.hpp"

namespace lamprey::file {

using model::JointDescription;
using model::JointKind;

namespace {

std::vector<double> about_two_axes(const TableReader& table, const JointDescription& joint, const Range& range) {
  const document::TomlValue& value = *table.find(joint.name);
  const std::string allowed = fmt::format("two numbers ({}), one about each axis", range.unit);
  if (value.kind != document::TomlValue::Kind::array || value.items.size() != 2)
    refuse(table.key(joint.name), shown(value), allowed, "write them in brackets, as in [0.1, 0.0]");
  return {table.number_in(value.items[0], joint.name, range, value, allowed),
          table.number_in(value.items[1], joint.name, range, value, allowed)};
}

}  // namespace

TableReader table_of_joints(const TableReader& table, const char* name, const model::SwimmerDescription& swimmer) {
  std::vector<std::string> joints;
  for (const JointDescription& joint : swimmer.joints) joints.push_back(joint.name);
  const TableReader of_joints = table.table(name);
  of_joints.allow_only(joints);
  return of_joints;
}

std::optional<std::vector<double>> read_angles(const TableReader& table, const JointDescription& joint) {
  if (!table.find(joint.name)) return std::nullopt;
  switch (joint.kind) {
    case JointKind::hinge:
      return {{*table.number(joint.name, turn())}};
    case JointKind::universal:
      return about_two_axes(table, joint, turn());
    case JointKind::ball: {
      const Eigen::Vector3d vector = *table.vector(joint.name, turn());
      return {{vector[0], vector[1], vector[2]}};
    }
    case JointKind::fixed:
      break;
  }
  refuse(table.key(joint.name), "angles of a fixed joint, which has none", "those of joints that turn", "remove it");
}

std::optional<std::vector<double>> read_angle_rates(const TableReader& table, const JointDescription& joint,
                                                    const char* instead) {
  const Range range = any_number("rad/s");
  if (!table.find(joint.name)) return std::nullopt;
  if (joint.kind == JointKind::hinge) return {{*table.number(joint.name, range)}};
  if (joint.kind == JointKind::universal) return about_two_axes(table, joint, range);
  refuse(table.key(joint.name), fmt::format("a number about the axes of a {} joint", word(joint.kind)),
         "those of hinges and universal joints",
         fmt::format("state {} instead", document::key_path(instead, joint.child)));
}

void refuse_both(const TableReader& by_joint, const TableReader& by_body, const JointDescription& joint) {
  if (!by_body.find(joint.child)) return;
  refuse(by_joint.key(joint.name), fmt::format("it beside {}", by_body.key(joint.child)), "one of the two",
         "remove one");
}

}  // namespace lamprey::file
