#include "result/limits_json.hpp"

#include <fmt/format.h>

#include "document/json_text.hpp"

namespace lamprey::result {

namespace {

using Eigen::Vector3d;
using maneuver::LimitMultiplier;
using maneuver::Limits;
using maneuver::Waypoint;

constexpr int most_index = 1'000'000;

// Members of an object on one line.
class Members {
 public:
  void add(const std::string& name, const std::string& value) {
    text_ += fmt::format("{}{}: {}", text_.empty() ? "" : ", ", document::json(name), value);
  }
  std::string finished() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

template <typename Values, typename Writer>
std::string one_line_each(const Values& values, const std::string& indent, const Writer& writer) {
  std::string text;
  for (const auto& value : values) text += (text.empty() ? "\n" : ",\n") + indent + writer(value);
  return text.empty() ? "[]" : "[" + text + "\n" + indent.substr(2) + "]";
}

std::string by_name(const std::map<std::string, double>& values) {
  Members members;
  for (const auto& [name, value] : values) members.add(name, document::json_number(value));
  return members.finished();
}

void add_for_joints(const char* key, const std::optional<double>& all, const std::map<std::string, double>& by_joint,
                    Members& members) {
  if (all) members.add(key, document::json_number(*all));
  if (!by_joint.empty()) members.add(key, by_name(by_joint));
}

Vector3d vector_of(const document::JsonReader& reader) {
  reader.require_array(3);
  return {reader.at(std::size_t{0}).number(), reader.at(std::size_t{1}).number(), reader.at(std::size_t{2}).number()};
}

std::map<std::string, double> numbers_by_name(const document::JsonReader& reader) {
  std::map<std::string, double> values;
  for (const std::string& name : reader.keys()) values[name] = reader.at(name.c_str()).number();
  return values;
}

void read_for_joints(const document::JsonReader& reader, const char* key, std::optional<double>& all,
                     std::map<std::string, double>& by_joint) {
  if (!reader.has(key)) return;
  const document::JsonReader value = reader.at(key);
  if (value.is_object())
    by_joint = numbers_by_name(value);
  else
    all = value.number();
}

}  // namespace

std::string limits_text(const Limits& limits) {
  Members members;
  add_for_joints("torque", limits.torque, limits.joint_torque, members);
  add_for_joints("torque_component", limits.torque_component, limits.joint_torque_component, members);
  add_for_joints("angular_velocity", limits.angular_velocity, limits.joint_angular_velocity, members);
  add_for_joints("angular_velocity_component", limits.angular_velocity_component,
                 limits.joint_angular_velocity_component, members);
  add_for_joints("swing", {}, limits.swing, members);
  add_for_joints("twist", {}, limits.twist, members);
  if (!limits.angle.empty()) {
    Members angles;
    for (const auto& [name, bounds] : limits.angle) {
      std::vector<std::string> pairs;
      for (const std::array<double, 2>& range : bounds)
        pairs.push_back(fmt::format("[{}, {}]", document::json_number(range[0]), document::json_number(range[1])));
      angles.add(name, pairs.size() == 1 ? pairs.front() : fmt::format("[{}]", fmt::join(pairs, ", ")));
    }
    members.add("angle", angles.finished());
  }
  if (limits.clearance) members.add("clearance", document::json_number(*limits.clearance));
  std::string list;
  for (const maneuver::KeepOutSphere& sphere : limits.spheres)
    list += fmt::format("{}{{\"centre\": {}, \"radius\": {}}}", list.empty() ? "" : ", ", document::json(sphere.centre),
                        document::json_number(sphere.radius));
  if (!list.empty()) members.add("sphere", "[" + list + "]");
  list.clear();
  for (const maneuver::KeepOutHalfSpace& half : limits.half_spaces)
    list += fmt::format("{}{{\"point\": {}, \"normal\": {}}}", list.empty() ? "" : ", ", document::json(half.point),
                        document::json(half.normal));
  if (!list.empty()) members.add("half_space", "[" + list + "]");
  return members.finished();
}

Limits read_limits(const document::JsonReader& reader) {
  reader.allow_only({"torque", "torque_component", "angular_velocity", "angular_velocity_component", "swing", "twist",
                     "angle", "clearance", "sphere", "half_space"});
  Limits limits;
  read_for_joints(reader, "torque", limits.torque, limits.joint_torque);
  read_for_joints(reader, "torque_component", limits.torque_component, limits.joint_torque_component);
  read_for_joints(reader, "angular_velocity", limits.angular_velocity, limits.joint_angular_velocity);
  read_for_joints(reader, "angular_velocity_component", limits.angular_velocity_component,
                  limits.joint_angular_velocity_component);
  if (reader.has("swing")) limits.swing = numbers_by_name(reader.at("swing"));
  if (reader.has("twist")) limits.twist = numbers_by_name(reader.at("twist"));
  if (reader.has("angle")) {
    const document::JsonReader angle = reader.at("angle");
    for (const std::string& name : angle.keys()) {
      const document::JsonReader bounds = angle.at(name.c_str());
      bounds.require_array(2);
      const auto add = [&](const document::JsonReader& range) {
        range.require_array(2);
        limits.angle[name].push_back({range.at(std::size_t{0}).number(), range.at(std::size_t{1}).number()});
      };
      if (!bounds.at(std::size_t{0}).is_array())
        add(bounds);  // of a hinge
      else
        for (std::size_t axis = 0; axis < 2; ++axis) add(bounds.at(axis));
    }
  }
  if (reader.has("clearance")) limits.clearance = reader.at("clearance").number();
  const auto each = [&](const char* key, const auto& use) {
    if (!reader.has(key)) return;
    const document::JsonReader list = reader.at(key);
    list.require_array();
    for (std::size_t i = 0; i < list.size(); ++i) use(list.at(i));
  };
  each("sphere", [&](const document::JsonReader& sphere) {
    sphere.allow_only({"centre", "radius"});
    limits.spheres.push_back({vector_of(sphere.at("centre")), sphere.at("radius").number()});
  });
  each("half_space", [&](const document::JsonReader& half) {
    half.allow_only({"point", "normal"});
    limits.half_spaces.push_back({vector_of(half.at("point")), vector_of(half.at("normal"))});
  });
  return limits;
}

std::string move_text(const std::array<std::optional<double>, 3>& move) {
  std::string text;
  for (const auto& entry : move)
    text += (text.empty() ? "" : ", ") + (entry ? document::json_number(*entry) : std::string("\"free\""));
  return "[" + text + "]";
}

std::array<std::optional<double>, 3> read_move(const document::JsonReader& reader) {
  std::array<std::optional<double>, 3> move;
  reader.require_array(3);
  for (std::size_t c = 0; c < 3; ++c)
    if (!reader.at(c).is_text("free")) move[c] = reader.at(c).number();
  return move;
}

std::string waypoints_text(const std::vector<Waypoint>& waypoints) {
  return one_line_each(waypoints, "      ", [](const Waypoint& waypoint) {
    Members members, rotation;
    members.add("time", document::json_number(waypoint.time));
    members.add("move", move_text(waypoint.move));
    members.add("turn", waypoint.turn ? document::json(*waypoint.turn) : "null");
    for (const auto& [name, value] : waypoint.rotation) rotation.add(name, document::json(value));
    members.add("rotation", rotation.finished());
    return members.finished();
  });
}

std::vector<Waypoint> read_waypoints(const document::JsonReader& reader) {
  std::vector<Waypoint> waypoints;
  reader.require_array();
  for (std::size_t n = 0; n < reader.size(); ++n) {
    const document::JsonReader own = reader.at(n);
    own.allow_only({"time", "move", "turn", "rotation"});
    Waypoint waypoint;
    waypoint.time = own.at("time").number();
    waypoint.move = read_move(own.at("move"));
    if (!own.at("turn").is_null()) waypoint.turn = vector_of(own.at("turn"));
    for (const std::string& name : own.at("rotation").keys())
      waypoint.rotation[name] = vector_of(own.at("rotation").at(name.c_str()));
    waypoints.push_back(waypoint);
  }
  return waypoints;
}

std::string limit_multipliers_text(const std::vector<LimitMultiplier>& multipliers) {
  return one_line_each(multipliers, "    ", [](const LimitMultiplier& own) {
    Members members;
    members.add("key", document::json(own.key));
    members.add("joint", fmt::format("{}", own.joint));
    members.add("bodies", fmt::format("[{}, {}]", own.body, own.other_body));
    members.add("component", fmt::format("{}", own.component));
    members.add("upper", own.upper ? "true" : "false");
    std::string values;
    for (double value : own.multiplier) values += (values.empty() ? "" : ", ") + document::json_number(value);
    members.add("multiplier", "[" + values + "]");
    return members.finished();
  });
}

std::vector<LimitMultiplier> read_limit_multipliers(const document::JsonReader& reader, std::size_t nodes) {
  std::vector<LimitMultiplier> multipliers;
  reader.require_array();
  for (std::size_t n = 0; n < reader.size(); ++n) {
    const document::JsonReader own = reader.at(n);
    LimitMultiplier entry;
    entry.key = own.at("key").text();
    entry.joint = own.at("joint").integer(-1, most_index);
    own.at("bodies").require_array(2);
    entry.body = own.at("bodies").at(std::size_t{0}).integer(-1, most_index);
    entry.other_body = own.at("bodies").at(std::size_t{1}).integer(-1, most_index);
    entry.component = own.at("component").integer(-1, most_index);
    entry.upper = own.at("upper").boolean();
    const document::JsonReader values = own.at("multiplier");
    values.require_array(nodes);
    for (std::size_t k = 0; k < nodes; ++k) entry.multiplier.push_back(values.at(k).number());
    multipliers.push_back(entry);
  }
  return multipliers;
}

}  // namespace lamprey::result
