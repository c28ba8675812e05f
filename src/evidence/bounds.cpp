#include "evidence/bounds.hpp"

#include <cmath>

namespace lamprey::evidence {

namespace {

using model::at;
using model::System;
using Kind = Bound::Kind;

void add_joint_bounds(const System& system, const maneuver::Limits& limits, std::vector<Bound>& bounds) {
  const auto own_or_all = [](const std::optional<double>& all, const std::map<std::string, double>& by_joint,
                             const std::string& name, const std::string& key, const auto& use) {
    if (const auto own = by_joint.find(name); own != by_joint.end())
      use(own->second, "limits." + key + "." + name);
    else if (all)
      use(*all, "limits." + key);
  };
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const auto add = [&](Kind kind, int component, bool upper) {
      return [&bounds, kind, component, upper, j](double value, const std::string& key) {
        bounds.push_back({kind, key, j, -1, -1, component, upper, value, -1});
      };
    };
    if (joint.actuation.cols() > 0) {
      own_or_all(limits.torque, limits.joint_torque, joint.name, "torque", add(Kind::torque, -1, false));
      for (int c = 0; c < static_cast<int>(joint.actuation.cols()); ++c)
        own_or_all(limits.torque_component, limits.joint_torque_component, joint.name, "torque_component",
                   add(Kind::torque_component, c, false));
    }
    own_or_all({}, limits.swing, joint.name, "swing", add(Kind::swing, -1, false));
    own_or_all({}, limits.twist, joint.name, "twist", add(Kind::twist, -1, false));
    own_or_all(limits.angular_velocity, limits.joint_angular_velocity, joint.name, "angular_velocity",
               add(Kind::angular_velocity, -1, false));
    const bool two = joint.kind == model::JointKind::universal;
    const int angles = two ? 2 : joint.kind == model::JointKind::hinge ? 1 : 0;
    for (int axis = 0; axis < angles; ++axis)
      for (const bool upper : {false, true})
        own_or_all(limits.angular_velocity_component, limits.joint_angular_velocity_component, joint.name,
                   "angular_velocity_component", add(Kind::angle_rate, two ? axis : -1, upper));
    if (const auto own = limits.angle.find(joint.name); own != limits.angle.end())
      for (std::size_t axis = 0; axis < own->second.size(); ++axis)
        for (const bool upper : {false, true})
          add(Kind::angle, two ? static_cast<int>(axis) : -1, upper)(own->second[axis][upper ? 1 : 0],
                                                                     "limits.angle." + joint.name);
  }
}

}  // namespace

std::vector<Bound> bounds_of(const StoredMotion& motion) {
  const System& system = motion.system;
  const maneuver::Problem& problem = motion.problem;
  std::vector<Bound> bounds;
  add_joint_bounds(system, problem.limits, bounds);
  for (int i = 0; i < system.body_count(); ++i) {
    if (problem.limits.clearance)
      for (int other = i + 1; other < system.body_count(); ++other)
        if (!system.move_as_one(i, other))
          bounds.push_back(
              {Kind::clearance, "limits.clearance", -1, i, other, -1, false, *problem.limits.clearance, -1});
    for (std::size_t n = 0; n < problem.limits.spheres.size(); ++n)
      bounds.push_back({Kind::sphere, "limits.sphere", -1, i, -1, static_cast<int>(n), false, 0.0, -1});
    for (std::size_t n = 0; n < problem.limits.half_spaces.size(); ++n)
      bounds.push_back({Kind::half_space, "limits.half_space", -1, i, -1, static_cast<int>(n), false, 0.0, -1});
  }
  for (std::size_t w = 0; w < problem.waypoints.size(); ++w) {
    const maneuver::Waypoint& waypoint = problem.waypoints[w];
    const int node = static_cast<int>(std::lround(waypoint.time / motion.time_step));
    for (int c = 0; c < 3; ++c)
      if (waypoint.move[at(c)])
        bounds.push_back({Kind::pass_position, "waypoint", -1, -1, -1, c, false,
                          problem.start.position[c] + *waypoint.move[at(c)], node});
    for (int i = 0; i < system.body_count(); ++i)
      if (waypoint.turns(system.body(i).name, system.body(i).parent < 0, problem.start.free_shape))
        for (int c = 0; c < 3; ++c)
          bounds.push_back({Kind::pass_turn, "waypoint", -1, i, -1, c, false, 0.0, node, static_cast<int>(w)});
  }
  if (problem.duration.free) {
    bounds.push_back({Kind::duration, "time.min", -1, -1, -1, -1, false, problem.duration.min, motion.steps});
    bounds.push_back({Kind::duration, "time.max", -1, -1, -1, -1, true, problem.duration.max, motion.steps});
  }
  return bounds;
}

bool applies(const StoredMotion& motion, const Bound& bound, int node) {
  if (bound.node >= 0) return node == bound.node;
  const bool of_moments = bound.kind == Kind::torque || bound.kind == Kind::torque_component;
  return of_moments ? !motion.solution.control.empty() : node > 0;
}

double node_time(const StoredMotion& motion, const Bound& bound, int node) {
  if (bound.node >= 0) return 1.0;
  const bool of_moments = bound.kind == Kind::torque || bound.kind == Kind::torque_component;
  return (of_moments && (node == 0 || node == motion.steps) ? 0.5 : 1.0) * motion.time_step;
}

namespace {

bool names(const maneuver::LimitMultiplier& own, const Bound& bound) {
  if (own.key != bound.key || own.body != bound.body || own.component != bound.component) return false;
  return bound.equality() ||
         (own.joint == bound.joint && own.other_body == bound.other_body && own.upper == bound.upper);
}

}  // namespace

const std::vector<double>* multipliers_of(const StoredMotion& motion, const Bound& bound) {
  for (const maneuver::LimitMultiplier& own : motion.solution.limit_multipliers) {
    if (!names(own, bound) || own.multiplier.size() != motion.solution.time.size()) continue;
    if (!bound.equality() || own.multiplier[at(bound.node)] != 0.0) return &own.multiplier;
  }
  return nullptr;
}

double density(const StoredMotion& motion, const Bound& bound, double multiplier) {
  return bound.node >= 0 ? multiplier / (motion.time_step * motion.steps) : multiplier;
}

std::optional<IdlePull> idle_pull(const StoredMotion& motion) {
  const std::vector<Bound> bounds = bounds_of(motion);
  for (std::size_t m = 0; m < motion.solution.limit_multipliers.size(); ++m) {
    const maneuver::LimitMultiplier& own = motion.solution.limit_multipliers[m];
    for (std::size_t k = 0; k < own.multiplier.size(); ++k) {
      const auto asks = [&](const Bound& bound) {
        return names(own, bound) && applies(motion, bound, static_cast<int>(k));
      };
      if (own.multiplier[k] != 0.0 && std::none_of(bounds.begin(), bounds.end(), asks))
        return IdlePull{m, k, own.multiplier[k]};
    }
  }
  return std::nullopt;
}

double unit_of(const Bound& bound) {
  const bool relative = bound.kind == Kind::torque || bound.kind == Kind::torque_component || bound.of_rate() ||
                        bound.kind == Kind::duration;
  return relative ? bound.value : 1.0;
}

double scale_of(const StoredMotion& motion, const Bound& bound) {
  const bool length = bound.kind == Kind::clearance || bound.kind == Kind::sphere || bound.kind == Kind::half_space ||
                      bound.kind == Kind::pass_position;
  return length ? motion.system.length_unit() : unit_of(bound);
}

}  // namespace lamprey::evidence
