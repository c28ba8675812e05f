#include "file/controls_header.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "file/text_file.hpp"
#include "file/toml_document.hpp"
#include "lie/so3.hpp"

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using Joints = std::vector<model::JointDescription>;

constexpr std::string_view axis_letters = "xyz";
constexpr std::string_view separators = " \t._-:/";

struct Label {
  std::string_view name, unit;  // unit without its brackets; empty: none
};

// "front x (N m)" or "front x [N m]".
Label label_of(std::string_view cell) {
  if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
  if (cell.empty() || (cell.back() != ')' && cell.back() != ']')) return {cell, {}};
  const std::size_t open = cell.rfind(cell.back() == ')' ? '(' : '[');
  if (open == std::string_view::npos) return {cell, {}};
  return {trimmed(cell.substr(0, open)), trimmed(cell.substr(open + 1, cell.size() - open - 2))};
}

std::optional<std::size_t> axis_of(std::string_view letter) {
  if (letter.size() != 1) return std::nullopt;
  const std::size_t axis = axis_letters.find(letter.front());
  if (axis == std::string_view::npos) return std::nullopt;
  return axis;
}

// Which of a joint's moment a column holds: x, y, z, or a hinge's along its axis.
struct Component {
  std::size_t joint;
  std::size_t part;  // 0, 1, 2 or `along`
};
constexpr std::size_t along = 3, part_count = 4;

// Of a name such as "front x" or "elbow".
std::optional<Component> component_of(std::string_view name, const Joints& joints) {
  if (joints.size() == 1)
    if (const auto axis = axis_of(name)) return Component{0, *axis};
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::string& joint = joints[j].name;
    if (joint.empty() || !name.starts_with(joint)) continue;
    const std::string_view rest = name.substr(joint.size());
    if (rest.empty() && joints[j].kind == model::JointKind::hinge) return Component{j, along};
    const std::size_t letter = rest.find_first_not_of(separators);
    if (letter == 0 || letter == std::string_view::npos) continue;
    if (const auto axis = axis_of(rest.substr(letter))) return Component{j, *axis};
  }
  return std::nullopt;
}

std::string component_name(const Component& component, const Joints& joints) {
  const std::string& joint = joints[component.joint].name;
  return component.part == along ? joint : fmt::format("{} {}", joint, axis_letters[component.part]);
}

Vector3d direction_of(const Component& component, const Joints& joints) {
  if (component.part < along) return Vector3d::Unit(static_cast<Eigen::Index>(component.part));
  const model::JointDescription& hinge = joints[component.joint];
  return lie::exp(hinge.reference_rotation) * hinge.axis.value_or(Vector3d::Zero()).stableNormalized();
}

std::optional<HeaderFault> wrong_unit(const std::vector<Label>& labels) {
  for (std::size_t n = 0; n < labels.size(); ++n) {
    const std::string_view unit = labels[n].unit;
    if (unit.empty()) continue;
    const auto is_one_of = [&](std::initializer_list<std::string_view> words) {
      return std::find(words.begin(), words.end(), unit) != words.end();
    };
    if (n == 0 && !is_one_of({"s"}))
      return HeaderFault{n, "times in " + in_quotes(unit), "s", "convert the column to seconds"};
    if (n > 0 && !is_one_of({"N m", "Nm", "N*m", "N·m", "N.m"}))
      return HeaderFault{n, "moments in " + in_quotes(unit), "N m", "convert the column to newton metres"};
  }
  return std::nullopt;
}

}  // namespace

ControlsHeader read_controls_header(const std::vector<std::string_view>& cells, const Joints& joints) {
  ControlsHeader header;
  header.columns = columns_in_order(joints);
  std::vector<Label> labels;
  for (const std::string_view cell : cells) labels.push_back(label_of(cell));
  if ((header.fault = wrong_unit(labels))) return header;
  std::vector<std::optional<Component>> component;
  for (std::size_t n = 1; n < labels.size(); ++n) component.push_back(component_of(labels[n].name, joints));
  header.named = std::any_of(component.begin(), component.end(), [](const auto& one) { return one.has_value(); });
  if (!header.named) return header;
  header.columns.clear();
  std::vector<std::array<bool, part_count>> held(joints.size(), {false, false, false, false});
  for (std::size_t n = 0; n < component.size(); ++n) {
    if (!component[n]) {
      header.fault = {n + 1, in_quotes(cells[n + 1]),
                      "a joint and its axis in every column, as " + in_quotes(component_name({0, 0}, joints)),
                      "name this column too, or none"};
      return header;
    }
    auto& of_joint = held[component[n]->joint];
    if (std::exchange(of_joint[component[n]->part], true)) {
      header.fault = {n + 1, fmt::format("{} a second time", in_quotes(cells[n + 1])), "each joint's x, y and z once",
                      "rename or remove one of the two columns"};
      return header;
    }
    if (of_joint[along] && (of_joint[0] || of_joint[1] || of_joint[2])) {
      header.fault = {n + 1, fmt::format("{} beside another column of that hinge", in_quotes(cells[n + 1])),
                      "its x, y and z, or its moment along its axis alone", "remove one of the two"};
      return header;
    }
    header.columns.push_back({component[n]->joint, direction_of(*component[n], joints)});
  }
  for (std::size_t j = 0; j < joints.size(); ++j)
    for (std::size_t part = 0; part < along; ++part)
      if (!held[j][along] && !held[j][part]) {
        header.fault = {0, "no column " + in_quotes(component_name({j, part}, joints)),
                        "each joint's x, y and z once, or of a hinge its name alone",
                        "add it (zeros where it exerts nothing)"};
        return header;
      }
  return header;
}

std::vector<ControlsColumn> columns_in_order(const Joints& joints) {
  std::vector<ControlsColumn> columns;
  for (std::size_t j = 0; j < joints.size(); ++j)
    for (std::size_t part = 0; part < along; ++part) columns.push_back({j, direction_of({j, part}, joints)});
  return columns;
}

std::string controls_header_in_order(const Joints& joints) {
  constexpr std::size_t enough = 4;  // columns by which the order is plain
  std::string text = "t";
  for (std::size_t n = 0; n < std::min(3 * joints.size(), enough); ++n)
    text += ", " + component_name({n / 3, n % 3}, joints);
  return text + (3 * joints.size() > enough ? ", ..." : "");
}

}  // namespace lamprey::file
