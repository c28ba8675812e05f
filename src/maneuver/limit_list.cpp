// Which rows the limits and waypoints of a problem make.
#include "maneuver/limit_rows.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>

namespace lamprey::maneuver {

namespace {

using model::at;
using model::Joint;
using model::System;
using Kind = LimitRow::Kind;

constexpr double narrow_cone = 0.5;  // rad

long node_at(double time, int steps, double duration) { return std::lround(time / duration * steps); }

void add_joint_rows(const System& system, const Problem& problem, std::vector<LimitRow>& rows) {
  const Limits& limits = problem.limits;
  const auto add = [&](Kind kind, int j, const std::string& key, double bound, int component = -1) {
    LimitRow row;
    row.kind = kind;
    row.key = "limits." + key;
    row.joint = j;
    row.bound = bound;
    row.component = component;
    // of a cosine: a little beyond a narrow cone is little of it
    if (kind == Kind::swing) row.unit = bound < narrow_cone ? std::sin(bound) / std::sin(narrow_cone) : 1.0;
    rows.push_back(row);
  };
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    const auto of_joint = [&](const std::optional<double>& all, const std::map<std::string, double>& named,
                              const std::string& key, const auto& use) {
      const auto own = named.find(joint.name);
      if (own != named.end())
        use(own->second, key + "." + joint.name);
      else if (all)
        use(*all, key);
    };
    const int moments = static_cast<int>(joint.actuation.cols());
    if (moments > 0) {
      of_joint(limits.torque, limits.joint_torque, "torque",
               [&](double bound, const std::string& key) { add(Kind::torque, j, key, bound); });
      of_joint(limits.torque_component, limits.joint_torque_component, "torque_component",
               [&](double bound, const std::string& key) {
                 for (int c = 0; c < moments; ++c) add(Kind::torque_component, j, key, bound, c);
               });
    }
    if (joint.kind == model::JointKind::fixed) continue;
    of_joint({}, limits.swing, "swing", [&](double bound, const std::string& key) { add(Kind::swing, j, key, bound); });
    of_joint({}, limits.twist, "twist", [&](double bound, const std::string& key) { add(Kind::twist, j, key, bound); });
    of_joint(limits.angular_velocity, limits.joint_angular_velocity, "angular_velocity",
             [&](double bound, const std::string& key) { add(Kind::speed, j, key, bound); });
    const bool two = joint.kind == model::JointKind::universal;
    if (two || joint.kind == model::JointKind::hinge)
      of_joint(limits.angular_velocity_component, limits.joint_angular_velocity_component, "angular_velocity_component",
               [&](double bound, const std::string& key) {
                 for (int axis = 0; axis < (two ? 2 : 1); ++axis)
                   for (const Kind kind : {Kind::rate_above, Kind::rate_below})
                     add(kind, j, key, bound, two ? axis : -1);
               });
    if (const auto own = limits.angle.find(joint.name); own != limits.angle.end()) {
      for (int axis = 0; axis < static_cast<int>(own->second.size()); ++axis) {
        const auto& [least, most] = own->second[at(axis)];
        add(Kind::angle_above, j, "angle." + joint.name, least, two ? axis : -1);
        add(Kind::angle_below, j, "angle." + joint.name, most, two ? axis : -1);
      }
    }
  }
}

void add_body_rows(const System& system, const Problem& problem, std::vector<LimitRow>& rows) {
  const Limits& limits = problem.limits;
  for (int i = 0; i < system.body_count(); ++i) {
    LimitRow row;
    row.body = i;
    row.unit = system.body(i).semi_axes.maxCoeff();
    if (limits.clearance)
      for (int other = i + 1; other < system.body_count(); ++other) {
        if (system.move_as_one(i, other)) continue;
        row.kind = Kind::clearance;
        row.key = "limits.clearance";
        row.other_body = other;
        row.bound = *limits.clearance;
        rows.push_back(row);
      }
    row.other_body = -1;
    row.component = 0;
    for (const KeepOutSphere& sphere : limits.spheres) {
      row.kind = Kind::sphere;
      row.key = "limits.sphere";
      row.centre = sphere.centre;
      row.bound = sphere.radius;
      rows.push_back(row);
      ++row.component;
    }
    row.component = 0;
    for (const KeepOutHalfSpace& half : limits.half_spaces) {
      row.kind = Kind::half_space;
      row.key = "limits.half_space";
      row.centre = half.point;
      row.normal = half.normal.stableNormalized();
      row.bound = 0.0;
      rows.push_back(row);
      ++row.component;
    }
  }
}

void add_waypoint_rows(const System& system, const Problem& problem, std::vector<LimitRow>& rows) {
  std::map<long, double> times;  // one for each node: what is asked there holds together
  for (const Waypoint& waypoint : problem.waypoints)
    times.try_emplace(node_at(waypoint.time, problem.steps, problem.duration.value), waypoint.time);
  for (const Waypoint& waypoint : problem.waypoints) {
    LimitRow row;
    row.key = "waypoint";
    const auto here = times.find(node_at(waypoint.time, problem.steps, problem.duration.value));
    row.time = here->second;
    if (here != times.begin()) row.time_before = std::prev(here)->second;
    row.kind = Kind::pass_position;
    row.unit = system.length_unit();
    for (int c = 0; c < 3; ++c)
      if (waypoint.move[at(c)]) {
        row.component = c;
        row.bound = problem.start.position[c] + *waypoint.move[at(c)];
        rows.push_back(row);
      }
    row.kind = Kind::pass_turn;
    row.unit = 1.0;
    for (int i = 0; i < system.body_count(); ++i) {
      if (!waypoint.turns(system.body(i).name, system.body(i).parent < 0, problem.start.free_shape)) continue;
      const auto own = waypoint.rotation.find(system.body(i).name);
      row.asked = own != waypoint.rotation.end()
                      ? lie::exp(own->second)
                      : Matrix3d(lie::exp(*waypoint.turn) * lie::exp(problem.start.rotation[at(i)]));
      row.body = i;
      for (row.component = 0; row.component < 3; ++row.component) rows.push_back(row);
    }
  }
}

}  // namespace

std::string LimitRow::listed_key() const {
  const bool listed = kind == Kind::sphere || kind == Kind::half_space;
  return listed ? key + "[" + std::to_string(component) + "]" : key;
}

std::string LimitRow::bearer(const model::System& system) const {
  std::string words;
  if (joint >= 0) words = " at joint " + system.joint(joint).name;
  if (body >= 0) words = " of " + system.body(body).name;
  if (other_body >= 0) words += " and " + system.body(other_body).name;
  return words;
}

const char* LimitRow::unit_name() const {
  switch (kind) {
    case Kind::torque:
    case Kind::torque_component:
      return "N m";
    case Kind::swing:
    case Kind::twist:
    case Kind::angle_above:
    case Kind::angle_below:
    case Kind::pass_turn:
      return "rad";
    case Kind::speed:
    case Kind::rate_above:
    case Kind::rate_below:
      return "rad/s";
    case Kind::not_shorter:
    case Kind::not_longer:
      return "s";
    case Kind::clearance:
    case Kind::sphere:
    case Kind::half_space:
    case Kind::pass_position:
      break;
  }
  return "m";
}

double LimitRow::excess(double missing, double time_step) const {
  const double broken = missing * unit;
  const auto angle_of = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
  switch (kind) {
    case Kind::torque:
    case Kind::torque_component:
    case Kind::rate_above:
    case Kind::rate_below:
    case Kind::not_shorter:
    case Kind::not_longer:
      return broken * bound;
    case Kind::swing:
      return angle_of(std::cos(bound) - broken) - bound;
    case Kind::speed: {
      const double allowed = std::min(bound * time_step, std::numbers::pi);  // no step shows more
      return (angle_of(std::cos(allowed) - 0.5 * broken * std::pow(bound * time_step, 2)) - allowed) / time_step;
    }
    default:
      return broken;
  }
}

bool applies(const LimitRow& row, int node, int steps, double duration) {
  if (row.time >= 0.0) {
    const auto node_of = [&](double time) { return static_cast<int>(node_at(time, steps, duration)); };
    const bool alone = row.time_before < 0.0 || node_of(row.time_before) < node;
    return node == node_of(row.time) && node > 0 && node < steps && alone;
  }
  if (row.of_duration()) return node == steps;
  return node > 0 || row.of_moments();
}

double counted_time(const LimitRow& row, int node, int steps, double duration) {
  if (row.time >= 0.0 || row.of_duration()) return 1.0;
  return (row.of_moments() && (node == 0 || node == steps) ? 0.5 : 1.0) * duration / steps;
}

std::vector<LimitRow> limit_rows(const System& system, const Problem& problem) {
  std::vector<LimitRow> rows;
  add_joint_rows(system, problem, rows);
  add_body_rows(system, problem, rows);
  add_waypoint_rows(system, problem, rows);
  if (problem.duration.free) {
    LimitRow row;
    row.kind = Kind::not_shorter;
    row.key = "time.min";
    row.bound = problem.duration.min;
    rows.push_back(row);
    row.kind = Kind::not_longer;
    row.key = "time.max";
    row.bound = problem.duration.max;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace lamprey::maneuver
