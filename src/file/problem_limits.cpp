#include "file/problem_limits.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "file/problem_checks.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using maneuver::Limits;
using maneuver::Problem;
using model::JointDescription;

constexpr double half_turn = 3.14159265358979323846;

using Joints = std::vector<JointDescription>;

// A joint that has a name of its own goes by it, not by its child's.
void allow_only_joints(const TableReader& table, const Joints& joints) {
  std::vector<std::string> names;
  for (const JointDescription& joint : joints) names.push_back(joint.name);
  for (const document::TomlValue& member : table.members()) {
    if (std::find(names.begin(), names.end(), member.key) != names.end()) continue;
    const auto led = std::find_if(joints.begin(), joints.end(),
                                  [&](const JointDescription& joint) { return joint.child == member.key; });
    if (led != joints.end())
      refuse(table.key(member.key), "a body", fmt::format("joints: {}", fmt::join(names, ", ")),
             fmt::format("write {}, the joint that leads it", led->name));
  }
  table.allow_only(names);
}

std::map<std::string, double> read_by_joint(const TableReader& table, const Joints& joints, const Range& range) {
  allow_only_joints(table, joints);
  std::map<std::string, double> values;
  for (const document::TomlValue& member : table.members()) values[member.key] = *table.number(member.key, range);
  return values;
}

// One number for every joint, or a table by joint.
void read_for_joints(const TableReader& table, const char* key, const Joints& joints, const Range& range,
                     std::optional<double>& all, std::map<std::string, double>& by_joint) {
  const document::TomlValue* value = table.find(key);
  if (value && value->kind == document::TomlValue::Kind::table)
    by_joint = read_by_joint(table.table(key), joints, range);
  else
    all = table.number(key, range);
}

// Of a hinge [min, max], of a universal joint one such pair for each of its axes.
void read_angles(const TableReader& angle, const Joints& joints, Limits& limits) {
  allow_only_joints(angle, joints);
  const Range angles{.low = -half_turn, .high = half_turn, .low_included = true, .unit = "rad"};
  for (const document::TomlValue& member : angle.members()) {
    const auto joint = std::find_if(joints.begin(), joints.end(),
                                    [&](const JointDescription& each) { return each.name == member.key; });
    const bool two = joint->kind == JointKind::universal;
    const std::string pair = "[min, max] with -π <= min < max <= π (rad)",
                      allowed = two ? "two of " + pair + ", about its first and its second axis" : pair;
    const auto wrong_shape = [&] {
      refuse(angle.key(member.key), shown(member), allowed, two ? "as in [[-0.5, 0.5], [-1, 1]]" : "as in [-0.5, 0.5]");
    };
    const auto read_pair = [&](const document::TomlValue& value) {
      if (value.kind != document::TomlValue::Kind::array || value.items.size() != 2) wrong_shape();
      for (const document::TomlValue& item : value.items)
        if (item.kind == document::TomlValue::Kind::array) wrong_shape();
      std::array<double, 2> bounds{};
      for (std::size_t i = 0; i < 2; ++i)
        bounds[i] = angle.number_in(value.items[i], member.key, angles, member, allowed);
      if (!(bounds[0] < bounds[1]))
        refuse(angle.key(member.key), shown(member), allowed, "exchange or widen the bounds");
      limits.angle[member.key].push_back(bounds);
    };
    if (!two) {
      read_pair(member);
      continue;
    }
    if (member.kind != document::TomlValue::Kind::array || member.items.size() != 2) wrong_shape();
    for (const document::TomlValue& axis : member.items) read_pair(axis);
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
    if (normal.isZero(0.0))
      refuse(half.key("normal"), shown(normal), "three numbers, not all 0", "give the direction out of the half-space");
    limits.half_spaces.push_back({*half.vector("point", any_number("m")), normal.stableNormalized()});
  }
}

bool has_axes(const JointDescription& joint) {
  return joint.kind == JointKind::hinge || joint.kind == JointKind::universal;
}

template <typename ByJoint>
void refuse_without_axes(const JointDescription& joint, const ByJoint& limited, const char* limit,
                         const std::string& cure) {
  if (!limited.contains(joint.name) || has_axes(joint)) return;
  const std::string key = document::key_path(limit, joint.name);
  if (joint.kind == JointKind::fixed) refuse(key, "a limit on a fixed joint", "on joints that move", "remove it");
  refuse(key, fmt::format("a {} joint", word(joint.kind)), "on hinges and universal joints", cure);
}

void refuse_moments_of(const JointDescription& joint, const Limits& limits) {
  for (const auto& [quantity, by_joint] :
       {std::pair("torque", &limits.joint_torque), std::pair("torque_component", &limits.joint_torque_component)})
    if (by_joint->contains(joint.name))
      refuse(document::key_path(fmt::format("limits.{}", quantity), joint.name),
             joint.kind == JointKind::fixed ? "a limit on a fixed joint" : "a limit on a joint with actuated = false",
             "on joints that exert moments", "remove it");
}

// Of which body one waypoint's turn and the other's rotation say otherwise; empty: of none.
std::string turned_otherwise(const Problem& problem, const maneuver::Waypoint& turned, const maneuver::Waypoint& told) {
  for (std::size_t i = 0; turned.turn && i < problem.start.rotation.size(); ++i) {
    const std::string& body = problem.swimmer.bodies[i].name;
    const auto own = told.rotation.find(body);
    if (own == told.rotation.end() || turned.rotation.contains(body) ||
        !turned.turns(body, i == 0, problem.start.free_shape))
      continue;
    const Eigen::Matrix3d R = lie::exp(*turned.turn) * lie::exp(problem.start.rotation[i]);
    if (lie::rotation_angle(R.transpose() * lie::exp(own->second)) > angle_tolerance) return body;
  }
  return "";
}

// What two waypoints at one time ask for differently, as a key; empty: nothing.
std::string contradiction(const Problem& problem, const maneuver::Waypoint& first, const maneuver::Waypoint& second) {
  for (std::size_t c = 0; c < 3; ++c)
    if (first.move[c] && second.move[c] && *first.move[c] != *second.move[c]) return "move";
  if (first.turn && second.turn && *first.turn != *second.turn) return "turn";
  for (const auto& [body, rotation] : first.rotation)
    if (const auto other = second.rotation.find(body); other != second.rotation.end() && other->second != rotation)
      return document::key_path("rotation", body);
  if (const std::string body = turned_otherwise(problem, first, second); !body.empty())
    return document::key_path("rotation", body);
  return turned_otherwise(problem, second, first).empty() ? "" : "turn";
}

void check_waypoints_agree(const Problem& problem) {
  std::vector<std::size_t> order(problem.waypoints.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto time = [&](std::size_t n) { return problem.waypoints[n].time; };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return time(a) < time(b); });
  for (auto one = order.begin(); one != order.end(); ++one)
    for (auto next = one + 1; next != order.end() && time(*next) - time(*one) < 0.5 * problem.time_step(); ++next) {
      const auto [m, n] = std::minmax(*one, *next);
      const std::string what = contradiction(problem, problem.waypoints[m], problem.waypoints[n]);
      if (!what.empty())
        refuse(fmt::format("waypoint[{}].{}", n, what),
               fmt::format("another {} than that of waypoint[{}], at the same time", what, m),
               "waypoints that can be met together", "change one of them, or its time");
    }
}

}  // namespace

bool says_free(const document::TomlValue& value) {
  return value.kind == document::TomlValue::Kind::string && value.text == "free";
}

std::array<std::optional<double>, 3> read_move(const TableReader& table) {
  std::array<std::optional<double>, 3> move;
  const document::TomlValue* value = table.find("move");
  if (!value) return move;
  const std::string allowed = "three entries, each a number (m) or \"free\"";
  if (value->kind != document::TomlValue::Kind::array || value->items.size() != 3)
    refuse(table.key("move"), shown(*value), allowed, "as in [2.0, \"free\", \"free\"]");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const document::TomlValue& entry = value->items[axis];
    if (entry.kind == document::TomlValue::Kind::string && !says_free(entry))
      refuse(table.key("move"), shown(*value), allowed, "write a number without quotes, or \"free\" in small letters");
    if (!says_free(entry)) move[axis] = table.number_in(entry, "move", any_number("m"), *value, allowed);
  }
  return move;
}

std::optional<Eigen::Vector3d> read_turn(const TableReader& table) {
  const document::TomlValue* asked = table.find("turn");
  return asked && says_free(*asked) ? std::nullopt : table.vector("turn", turn());
}

void read_limits(const TableReader& table, Problem& problem) {
  table.allow_only({"torque", "torque_component", "angular_velocity", "angular_velocity_component", "swing", "twist",
                    "angle", "clearance", "sphere", "half_space"});
  const Joints& joints = problem.swimmer.joints;
  Limits& limits = problem.limits;
  read_for_joints(table, "torque", joints, positive("N m"), limits.torque, limits.joint_torque);
  read_for_joints(table, "torque_component", joints, positive("N m"), limits.torque_component,
                  limits.joint_torque_component);
  read_for_joints(table, "angular_velocity", joints, positive("rad/s"), limits.angular_velocity,
                  limits.joint_angular_velocity);
  read_for_joints(table, "angular_velocity_component", joints, positive("rad/s"), limits.angular_velocity_component,
                  limits.joint_angular_velocity_component);
  const Range angles{.low = 0.0, .high = half_turn, .unit = "rad"};
  limits.swing = read_by_joint(table.table("swing"), joints, angles);
  limits.twist = read_by_joint(table.table("twist"), joints, angles);
  read_angles(table.table("angle"), joints, limits);
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
    waypoint.turn = read_turn(table);
    const TableReader rotation = table.table("rotation");
    rotation.allow_only(names);
    for (const document::TomlValue& member : rotation.members())
      waypoint.rotation[member.key] = *rotation.vector(member.key, turn());
    problem.waypoints.push_back(waypoint);
  }
}

void check_limits(const Problem& problem) {
  for (const JointDescription& joint : problem.swimmer.joints) {
    const bool no_arms = joint.parent_offset.isZero(0.0) || joint.child_offset.isZero(0.0);
    for (const auto& [quantity, limits] :
         {std::pair("swing", &problem.limits.swing), std::pair("twist", &problem.limits.twist)}) {
      if (!limits->contains(joint.name)) continue;
      const std::string key = document::key_path(fmt::format("limits.{}", quantity), joint.name);
      if (joint.kind == JointKind::fixed) refuse(key, "a limit on a fixed joint", "on joints that move", "remove it");
      if (no_arms)
        refuse(key, "a joint at a mass centre", "only with parent_offset and child_offset that are not zero",
               "remove it: the angle has no meaning there");
    }
    if (joint.kind == JointKind::fixed || !joint.actuated) refuse_moments_of(joint, problem.limits);
    refuse_without_axes(joint, problem.limits.angle, "limits.angle", "use limits.swing and limits.twist instead");
    refuse_without_axes(
        joint, problem.limits.joint_angular_velocity_component, "limits.angular_velocity_component",
        fmt::format("limit all of its rate: {}", document::key_path("limits.angular_velocity", joint.name)));
  }
  const auto& joints = problem.swimmer.joints;
  if (problem.limits.angular_velocity_component && std::none_of(joints.begin(), joints.end(), has_axes))
    refuse("limits.angular_velocity_component", "a swimmer without hinges and universal joints",
           "on these, each of whose angles has a rate", "limit all of the joints' rates: limits.angular_velocity");
}

void check_waypoints(const Problem& problem) {
  for (std::size_t n = 0; n < problem.waypoints.size(); ++n) {
    const maneuver::Waypoint& waypoint = problem.waypoints[n];
    const std::string key = fmt::format("waypoint[{}]", n);
    if (!problem.goal)
      refuse(key, "a waypoint without [goal]", "waypoints of a maneuver", "add a [goal], or remove it");
    const double step = waypoint.time / problem.time_step();
    const bool on_node = std::abs(step - std::round(step)) < 1e-6;
    if (!problem.duration.free && (!on_node || std::round(step) < 1.0 || std::round(step) >= problem.steps))
      refuse(key + ".time", fmt::format("{} s", waypoint.time),
             fmt::format("a whole number of steps of {} s, after the start and before the end at {} s",
                         problem.time_step(), problem.duration.value),
             problem.steps < 2 ? "take more time.steps"
                               : fmt::format("as in {:.12g}", problem.time_step() * std::clamp(std::round(step), 1.0,
                                                                                               problem.steps - 1.0)));
    if (problem.duration.free)
      refuse(key, "a waypoint with a free duration", "waypoints at fixed times", "fix time.duration");
    bool moves = false;
    for (const auto& entry : waypoint.move) moves = moves || entry.has_value();
    if (!moves && !waypoint.turn && waypoint.rotation.empty())
      refuse(key, "nothing asked for", "at least one of move, turn, rotation.NAME", "add one, or remove the waypoint");
  }
  check_waypoints_agree(problem);
}

}  // namespace lamprey::file
