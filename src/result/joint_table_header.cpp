#include "result/joint_table_header.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "document/text_file.hpp"
#include "document/toml_document.hpp"
#include "lie/so3.hpp"

namespace lamprey::result {

namespace {

using Eigen::Vector3d;
using model::JointKind;
using Joints = std::vector<model::JointDescription>;

constexpr std::string_view separators = " \t._-:/";

struct Label {
  std::string_view name, unit;  // unit without its brackets; empty: none
};

// "front x (N m)" or "front x [N m]".
Label label_of(std::string_view cell) {
  if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"')
    cell = document::trimmed(cell.substr(1, cell.size() - 2));
  if (cell.empty() || (cell.back() != ')' && cell.back() != ']')) return {cell, {}};
  const std::size_t open = cell.rfind(cell.back() == ')' ? '(' : '[');
  if (open == std::string_view::npos) return {cell, {}};
  return {document::trimmed(cell.substr(0, open)), document::trimmed(cell.substr(open + 1, cell.size() - open - 2))};
}

// What a column may hold of a joint.
struct Part {
  std::string_view suffix;  // behind the joint's name; empty: the name alone
  Vector3d direction;
  bool of_motor = false;  // a moment along an axis of the joint: all of these say the same as all the others
};

// Of its motors, parent's frame at zero angle, unit, orthogonal.
std::array<Vector3d, 2> moment_axes(const model::JointDescription& universal) {
  const std::array<Vector3d, 2> axes =
      universal.axes.value_or(std::array<Vector3d, 2>{Vector3d::Zero(), Vector3d::Zero()});
  const Vector3d first = axes[0].stableNormalized();
  const Vector3d second = lie::exp(universal.reference_rotation) * axes[1].stableNormalized();
  return {first, (second - first * first.dot(second)).stableNormalized()};
}

// Those that stand one beside the other come first, in the order of tables without names.
std::vector<Part> parts_of(TableKind kind, const model::JointDescription& joint) {
  const std::vector<Part> axes = {{"x", Vector3d::UnitX()}, {"y", Vector3d::UnitY()}, {"z", Vector3d::UnitZ()}};
  const bool hinge = joint.kind == file::JointKind::hinge;
  if (kind == TableKind::angles) {
    if (joint.kind == file::JointKind::fixed) return {};
    if (hinge) return {{"", Vector3d::UnitX()}};
    if (joint.kind == file::JointKind::universal) return {{"1", Vector3d::UnitX()}, {"2", Vector3d::UnitY()}};
    return axes;
  }
  std::vector<Part> parts = axes;
  if (hinge) parts.push_back({"", moment_axis(joint), true});
  if (joint.kind == file::JointKind::universal) {
    const auto [first, second] = moment_axes(joint);
    parts.push_back({"1", first, true});
    parts.push_back({"2", second, true});
  }
  return parts;
}

struct JointPart {
  std::size_t joint, part;
};

// Which part of which joint a table may hold.
class Columns {
 public:
  Columns(TableKind kind, const Joints& joints) : joints_(joints) {
    for (const model::JointDescription& joint : joints) parts_.push_back(parts_of(kind, joint));
  }

  const std::vector<Part>& parts(std::size_t joint) const { return parts_[joint]; }
  const Part& part(const JointPart& place) const { return parts_[place.joint][place.part]; }

  // Of a name such as "front x" or "elbow".
  std::optional<JointPart> named(std::string_view name) const {
    if (joints_.size() == 1)
      if (const auto part = part_named(0, name); part && !name.empty()) return JointPart{0, *part};
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const std::string& joint = joints_[j].name;
      if (joint.empty() || !name.starts_with(joint)) continue;
      const std::string_view rest = name.substr(joint.size());
      const std::size_t suffix = rest.find_first_not_of(separators);
      if (!rest.empty() && (suffix == 0 || suffix == std::string_view::npos)) continue;
      if (const auto part = part_named(j, rest.empty() ? rest : rest.substr(suffix))) return JointPart{j, *part};
    }
    return std::nullopt;
  }

  std::string name(const JointPart& place) const {
    const std::string& joint = joints_[place.joint].name;
    return part(place).suffix.empty() ? joint : fmt::format("{} {}", joint, part(place).suffix);
  }

  // Whether it seems to mean a joint, such as "elbow_deg".
  bool begins_with_joint(std::string_view name) const {
    return std::any_of(joints_.begin(), joints_.end(), [&](const model::JointDescription& joint) {
      const std::string_view rest = name.starts_with(joint.name) ? name.substr(joint.name.size()) : "?";
      return !joint.name.empty() && (rest.empty() || separators.find(rest.front()) != std::string_view::npos);
    });
  }

  // In the joints' order.
  std::vector<JointPart> in_order() const {
    std::vector<JointPart> places;
    for (std::size_t j = 0; j < parts_.size(); ++j)
      for (std::size_t p = 0; p < parts_[j].size(); ++p)
        if (!parts_[j][p].of_motor) places.push_back({j, p});
    return places;
  }

 private:
  std::optional<std::size_t> part_named(std::size_t joint, std::string_view suffix) const {
    for (std::size_t p = 0; p < parts_[joint].size(); ++p)
      if (parts_[joint][p].suffix == suffix) return p;
    return std::nullopt;
  }

  const Joints& joints_;
  std::vector<std::vector<Part>> parts_;  // [joints]
};

// What a table of a kind is about, in words.
struct Wording {
  std::initializer_list<std::string_view> units;
  std::string_view quantity, unit, unit_cure, once, zeros;
};

const Wording& wording(TableKind kind) {
  static const Wording moments{
      {"N m", "Nm", "N*m", "N·m", "N.m"},
      "moments",
      "N m",
      "convert the column to newton metres",
      "each joint's x, y and z once, or of a hinge its name alone, of a universal joint 1 and 2",
      "add it (zeros where it exerts nothing)"};
  static const Wording angles{
      {"rad", "deg", "°"},
      "angles",
      "rad or deg",
      "convert the column to radians",
      "the angles of each joint once: a hinge's name, 1 and 2 of a universal joint, x, y, z of a ball joint",
      "add it (zeros where it stays)"};
  return kind == TableKind::moments ? moments : angles;
}

std::optional<HeaderFault> wrong_unit(TableKind kind, const std::vector<Label>& labels) {
  const Wording& words = wording(kind);
  for (std::size_t n = 0; n < labels.size(); ++n) {
    const std::string_view unit = labels[n].unit;
    if (unit.empty()) continue;
    if (n == 0 && unit != "s")
      return HeaderFault{n, "times in " + document::in_quotes(unit), "s", "convert the column to seconds"};
    if (n > 0 && std::find(words.units.begin(), words.units.end(), unit) == words.units.end())
      return HeaderFault{n, fmt::format("{} in {}", words.quantity, document::in_quotes(unit)), std::string(words.unit),
                         std::string(words.unit_cure)};
  }
  return std::nullopt;
}

// Radians would be read where the others' degrees are meant. Moments have one unit.
std::optional<HeaderFault> lacking_unit(TableKind kind, const std::vector<Label>& labels,
                                        const std::vector<std::string_view>& cells) {
  if (kind == TableKind::moments) return std::nullopt;
  const auto find = [&](bool with_unit) {
    std::size_t n = 1;
    while (n < labels.size() && (labels[n].name.empty() || labels[n].unit.empty() == with_unit)) ++n;
    return n;
  };
  const std::size_t without = find(false), with = find(true);
  if (without >= labels.size() || with >= labels.size()) return std::nullopt;
  const std::string name(labels[without].name);
  return HeaderFault{
      without, fmt::format("{} without a unit beside {}", document::in_quotes(name), document::in_quotes(cells[with])),
      "a unit behind every column, or behind none where all are radians",
      fmt::format("write {} or {}", document::in_quotes(name + " (deg)"), document::in_quotes(name + " (rad)"))};
}

// In the unit that samples have.
double in_unit(std::string_view unit) { return unit == "deg" || unit == "°" ? std::numbers::pi / 180.0 : 1.0; }

// Which parts of one joint a header holds, so far or in all.
class Held {
 public:
  explicit Held(const std::vector<Part>& parts) : parts_(parts), held_(parts.size(), false) {}
  bool add(std::size_t part) {
    const bool is_new = !held_[part];
    held_[part] = true;
    return is_new;
  }
  bool any(bool of_motors) const { return count(of_motors, true) > 0; }
  bool all(bool of_motors) const { return count(of_motors, false) == 0; }
  bool both() const { return any(true) && any(false); }
  /// What is still lacking: of the way that is begun, or of x, y, z.
  std::optional<std::size_t> lacking() const {
    const bool of_motors = any(true) && !any(false);
    for (std::size_t p = 0; p < held_.size(); ++p)
      if (!held_[p] && parts_[p].of_motor == of_motors) return p;
    return std::nullopt;
  }

 private:
  std::ptrdiff_t count(bool of_motors, bool held) const {
    std::ptrdiff_t number = 0;
    for (std::size_t p = 0; p < held_.size(); ++p) number += parts_[p].of_motor == of_motors && held_[p] == held;
    return number;
  }
  const std::vector<Part>& parts_;
  std::vector<bool> held_;
};

std::vector<Held> nothing_held(const Columns& known, const Joints& joints) {
  std::vector<Held> held;
  for (std::size_t j = 0; j < joints.size(); ++j) held.emplace_back(known.parts(j));
  return held;
}

HeaderFault beside_another(std::size_t cell, const std::string& text, const model::JointDescription& joint) {
  const bool hinge = joint.kind == file::JointKind::hinge;
  return {cell, fmt::format("{} beside another column of that {}", text, hinge ? "hinge" : "joint"),
          fmt::format("its x, y and z, or {}, or both", hinge ? "its name alone" : "1 and 2"),
          "remove one of the two, or add what lacks"};
}

// What of each joint the header names, each part once, and what is wrong with it.
std::optional<HeaderFault> incomplete(TableKind kind, const Columns& known, const Joints& joints,
                                      const std::vector<std::string_view>& cells,
                                      const std::vector<std::optional<JointPart>>& place) {
  const Wording& words = wording(kind);
  std::vector<Held> in_all = nothing_held(known, joints), held = in_all;
  for (const auto& one : place)
    if (one) in_all[one->joint].add(one->part);
  for (std::size_t n = 0; n < place.size(); ++n) {
    const std::string cell = document::in_quotes(cells[n + 1]);
    if (!place[n]) {
      const std::vector<JointPart> all = known.in_order();
      return HeaderFault{n + 1, cell, "a joint in every column, as " + document::in_quotes(known.name(all.front())),
                         "name this column too, or none"};
    }
    const auto [joint, part] = *place[n];
    if (!held[joint].add(part))
      return HeaderFault{n + 1, cell + " a second time", std::string(words.once),
                         "rename or remove one of the two columns"};
    if (held[joint].both() && !(in_all[joint].all(true) && in_all[joint].all(false)))
      return beside_another(n + 1, cell, joints[joint]);
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const bool exerts = joints[j].actuated && joints[j].kind != file::JointKind::fixed;
    const bool named = held[j].any(true) || held[j].any(false);
    if (const auto part = held[j].lacking(); part && (exerts || named))
      return HeaderFault{0, "no column " + document::in_quotes(known.name({j, *part})), std::string(words.once),
                         std::string(words.zeros)};
  }
  return std::nullopt;
}

}  // namespace

Vector3d moment_axis(const model::JointDescription& joint) {
  return lie::exp(joint.reference_rotation) * joint.axis.value_or(Vector3d::Zero()).stableNormalized();
}

TableHeader read_table_header(TableKind kind, const std::vector<std::string_view>& cells, const Joints& joints) {
  TableHeader header;
  header.columns = columns_in_order(kind, joints);
  const Columns known(kind, joints);
  std::vector<Label> labels;
  for (const std::string_view cell : cells) labels.push_back(label_of(cell));
  if ((header.fault = wrong_unit(kind, labels)) || (header.fault = lacking_unit(kind, labels, cells))) return header;
  std::vector<std::optional<JointPart>> place;
  for (std::size_t n = 1; n < labels.size(); ++n) place.push_back(known.named(labels[n].name));
  header.named = std::any_of(place.begin(), place.end(), [](const auto& one) { return one.has_value(); });
  if (!header.named && kind == TableKind::angles &&
      !known.in_order().empty())  // nobody would take degrees for radians, or one joint for another
    for (std::size_t n = 1; n < labels.size(); ++n)
      if (known.begins_with_joint(labels[n].name)) {
        header.fault = {n, document::in_quotes(cells[n]),
                        "a joint's angles as " + document::in_quotes(known.name(known.in_order().front())) +
                            ", with (rad) or (deg) behind",
                        "name the columns so, or leave the header out"};
        return header;
      }
  if (header.named) {
    if ((header.fault = incomplete(kind, known, joints, cells, place))) return header;
    header.columns.clear();
    std::vector<bool> along_axes(joints.size(), false);
    for (const auto& one : place)
      if (!known.part(*one).of_motor) along_axes[one->joint] = true;
    for (const auto& one : place)
      header.columns.push_back(
          {one->joint, known.part(*one).direction, known.part(*one).of_motor && along_axes[one->joint]});
  }
  for (std::size_t n = 0; n < std::min(header.columns.size(), labels.size() - 1); ++n)
    header.columns[n].direction *= in_unit(labels[n + 1].unit);
  return header;
}

std::vector<std::string> names_in_header(const std::vector<std::string_view>& cells) {
  std::vector<std::string> names;
  for (std::size_t n = 1; n < cells.size(); ++n) {
    std::string_view name = label_of(cells[n]).name;
    const std::size_t blank = name.find_last_of(separators);
    const std::string_view last = blank == std::string_view::npos ? "" : name.substr(blank + 1);
    if (last.size() == 1 && std::string_view("xyz12").find(last) != std::string_view::npos)
      name = name.substr(0, name.find_last_not_of(separators, blank) + 1);
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  }
  return names;
}

std::vector<TableColumn> columns_in_order(TableKind kind, const Joints& joints) {
  const Columns known(kind, joints);
  std::vector<TableColumn> columns;
  for (const JointPart& place : known.in_order()) columns.push_back({place.joint, known.part(place).direction});
  return columns;
}

std::vector<std::string> column_names(TableKind kind, const Joints& joints) {
  const Columns known(kind, joints);
  std::vector<std::string> names;
  for (const JointPart& place : known.in_order()) names.push_back(known.name(place));
  return names;
}

std::vector<NamedColumn> columns_to_write(TableKind kind, const Joints& joints) {
  const Columns known(kind, joints);
  std::vector<NamedColumn> columns;
  for (std::size_t j = 0; j < joints.size(); ++j)
    for (std::size_t p = 0; p < known.parts(j).size(); ++p) {
      const Part& part = known.parts(j)[p];
      if (!part.of_motor || joints[j].actuated)
        columns.push_back({known.name({j, p}), {j, part.direction, part.of_motor}});
    }
  return columns;
}

std::string header_in_order(TableKind kind, const Joints& joints) {
  constexpr std::size_t enough = 4;  // columns by which the order is plain
  const std::vector<std::string> names = column_names(kind, joints);
  std::string text = "t";
  for (std::size_t n = 0; n < std::min(names.size(), enough); ++n) text += ", " + names[n];
  return text + (names.size() > enough ? ", ..." : "");
}

}  // namespace lamprey::result
