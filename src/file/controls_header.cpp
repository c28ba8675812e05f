#include "file/controls_header.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "file/text_file.hpp"
#include "file/toml_document.hpp"

namespace lamprey::file {

namespace {

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

// 3 × joint + axis of a name such as "front x".
std::optional<std::size_t> component_of(std::string_view name, const Joints& joints) {
  if (joints.size() == 1)
    if (const auto axis = axis_of(name)) return axis;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::string& joint = joints[j].name;
    if (joint.empty() || !name.starts_with(joint)) continue;
    const std::string_view rest = name.substr(joint.size());
    const std::size_t letter = rest.find_first_not_of(separators);
    if (letter == 0 || letter == std::string_view::npos) continue;
    if (const auto axis = axis_of(rest.substr(letter))) return 3 * j + *axis;
  }
  return std::nullopt;
}

std::string component_name(std::size_t component, const Joints& joints) {
  return fmt::format("{} {}", joints[component / 3].name, axis_letters[component % 3]);
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
  for (std::size_t n = 0; n < 3 * joints.size(); ++n) header.component.push_back(n);
  std::vector<Label> labels;
  for (const std::string_view cell : cells) labels.push_back(label_of(cell));
  if ((header.fault = wrong_unit(labels))) return header;
  std::vector<std::optional<std::size_t>> component;
  for (std::size_t n = 1; n < labels.size(); ++n) component.push_back(component_of(labels[n].name, joints));
  header.named = std::any_of(component.begin(), component.end(), [](const auto& one) { return one.has_value(); });
  if (!header.named) return header;
  std::vector<std::size_t> column(header.component.size(), 0);  // that holds a component; 0: none yet
  for (std::size_t n = 0; n < component.size(); ++n) {
    if (!component[n]) {
      header.fault = {n + 1, in_quotes(cells[n + 1]),
                      "a joint and its axis in every column, as " + in_quotes(component_name(0, joints)),
                      "name this column too, or none"};
      return header;
    }
    std::size_t& holds = column[*component[n]];
    if (holds > 0) {
      header.fault = {n + 1, fmt::format("{} a second time", in_quotes(cells[n + 1])), "each joint's x, y and z once",
                      "rename or remove one of the two columns"};
      return header;
    }
    holds = n + 1;
  }
  const auto missing = std::find(column.begin(), column.end(), 0U);
  if (missing != column.end()) {
    const std::string name = component_name(static_cast<std::size_t>(missing - column.begin()), joints);
    header.fault = {0, "no column " + in_quotes(name), "each joint's x, y and z once",
                    "add it (zeros where it exerts nothing)"};
    return header;
  }
  for (std::size_t n = 0; n < component.size(); ++n) header.component[n] = *component[n];
  return header;
}

std::string controls_header_in_order(const Joints& joints) {
  constexpr std::size_t enough = 4;  // columns by which the order is plain
  std::string text = "t";
  for (std::size_t n = 0; n < std::min(3 * joints.size(), enough); ++n) text += ", " + component_name(n, joints);
  return text + (3 * joints.size() > enough ? ", ..." : "");
}

}  // namespace lamprey::file
