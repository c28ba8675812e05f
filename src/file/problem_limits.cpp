#include "file/problem_limits.hpp"

#include <fmt/format.h>

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using maneuver::Limits;
using maneuver::Problem;

constexpr double half_turn = 3.14159265358979323846;

std::map<std::string, double> read_by_joint(const TableReader& table, const std::vector<std::string>& names,
                                            const Range& range) {
  table.allow_only(names);
  std::map<std::string, double> values;
  for (const TomlValue& member : table.members()) values[member.key] = *table.number(member.key, range);
  return values;
}

// One number for every joint, or a table by joint.
void read_for_joints(const TableReader& table, const char* key, const std::vector<std::string>& names,
                     const Range& range, std::optional<double>& all, std::map<std::string, double>& by_joint) {
  const TomlValue* value = table.find(key);
  if (value && value->kind == TomlValue::Kind::table)
    by_joint = read_by_joint(table.table(key), names, range);
  else
    all = table.number(key, range);
}

void read_angles(const TableReader& angle, const std::vector<std::string>& names, Limits& limits) {
  const Range angles{.low = -half_turn, .high = half_turn, .low_included = true, .unit = "rad"};
  angle.allow_only(names);
  for (const TomlValue& member : angle.members()) {
    const std::string allowed = "[min, max] with -π <= min < max <= π (rad)";
    if (member.kind != TomlValue::Kind::array || member.items.size() != 2)
      refuse(angle.key(member.key), shown(member), allowed, "as in [-0.5, 0.5]");
    std::array<double, 2> bounds{};
    for (std::size_t i = 0; i < 2; ++i)
      bounds[i] = angle.number_in(member.items[i], member.key, angles, member, allowed);
    if (!(bounds[0] < bounds[1])) refuse(angle.key(member.key), shown(member), allowed, "exchange or widen the bounds");
    limits.angle[member.key] = bounds;
  }
}

void read_keep_out(const TableReader& table, Limits& limits) {
  for (const TableReader& sphere : table.tables("sphere")) {
    sphere.allow_only({"centre", "radius"});
    sphere.require("centre", "three numbers (m), world");
    sphere.require("radius", "a number > 0 (m)");
    limits.spheres.push_back({*sphere.vector("centre", any_number("m")), *sphere.number("radius", positive("m"))});
  }
  for (const TableReader& half : table.tables("half_space")) {
    half.allow_only({"point", "normal"});
    half.require("point", "three numbers (m), a point of its face, world");
    half.require("normal", "three numbers, not all 0: the direction out of it, world");
    const Vector3d normal = *half.vector("normal", any_number(""));
    if (normal.norm() == 0.0)
      refuse(half.key("normal"), shown(normal), "three numbers, not all 0", "give the direction out of the half-space");
    limits.half_spaces.push_back({*half.vector("point", any_number("m")), normal});
  }
}

}  // namespace

bool says_free(const TomlValue& value) { return value.kind == TomlValue::Kind::string && value.text == "free"; }

std::array<std::optional<double>, 3> read_move(const TableReader& table) {
  std::array<std::optional<double>, 3> move;
  const TomlValue* value = table.find("move");
  if (!value) return move;
  const std::string allowed = "three entries, each a number (m) or \"free\"";
  if (value->kind != TomlValue::Kind::array || value->items.size() != 3)
    refuse(table.key("move"), shown(*value), allowed, "as in [2.0, \"free\", \"free\"]");
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!says_free(value->items[axis]))
      move[axis] = table.number_in(value->items[axis], "move", any_number("m"), *value, allowed);
  return move;
}

void read_limits(const TableReader& table, Problem& problem) {
  table.allow_only({"torque", "torque_component", "angular_velocity", "swing", "twist", "angle", "clearance", "sphere",
                    "half_space"});
  std::vector<std::string> names;
  for (const model::JointDescription& joint : problem.swimmer.joints) names.push_back(joint.name);
  Limits& limits = problem.limits;
  read_for_joints(table, "torque", names, positive("N m"), limits.torque, limits.joint_torque);
  read_for_joints(table, "torque_component", names, positive("N m"), limits.torque_component,
                  limits.joint_torque_component);
  read_for_joints(table, "angular_velocity", names, positive("rad/s"), limits.angular_velocity,
                  limits.joint_angular_velocity);
  const Range angles{.low = 0.0, .high = half_turn, .unit = "rad"};
  limits.swing = read_by_joint(table.table("swing"), names, angles);
  limits.twist = read_by_joint(table.table("twist"), names, angles);
  read_angles(table.table("angle"), names, limits);
  limits.clearance = table.number("clearance", not_negative("m"));
  read_keep_out(table, limits);
}

void read_waypoints(const TableReader& document, Problem& problem) {
  std::vector<std::string> names;
  for (const model::BodyDescription& body : problem.swimmer.bodies) names.push_back(body.name);
  for (const TableReader& table : document.tables("waypoint")) {
    table.allow_only({"time", "move", "turn", "rotation"});
    table.require("time", "a number > 0 (s), a whole number of steps");
    maneuver::Waypoint waypoint;
    waypoint.time = *table.number("time", positive("s"));
    waypoint.move = read_move(table);
    waypoint.turn = table.vector("turn", turn());
    const TableReader rotation = table.table("rotation");
    rotation.allow_only(names);
    for (const TomlValue& member : rotation.members())
      waypoint.rotation[member.key] = *rotation.vector(member.key, turn());
    problem.waypoints.push_back(waypoint);
  }
}

}  // namespace lamprey::file
