#include "result/stored_question.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "file/problem_checks.hpp"
#include "file/problem_file.hpp"
#include "file/problem_limits.hpp"
#include "file/words.hpp"
#include "maneuver/limit_rows.hpp"
#include "model/system.hpp"

namespace lamprey::result {

namespace {

using maneuver::Problem;

void require_number(bool allowed, const char* key, double value, const char* range) {
  if (!allowed) throw model::InputError(key, fmt::format("found {}; allowed: {}", value, range));
}

// What the reader of problem files asks of each number by itself.
void check_numbers(const Problem& problem) {
  const auto weight = [](const char* key, double value) {
    require_number(std::isfinite(value) && value >= 0.0, key, value, "a number >= 0");
  };
  require_number(std::isfinite(problem.effort) && problem.effort > 0.0, "cost.effort", problem.effort, "a number > 0");
  weight("cost.time", problem.time_weight);
  weight("cost.work", problem.cost_weights.work);
  weight("cost.power", problem.cost_weights.power);
  weight("cost.smoothness", problem.cost_weights.smoothness);
  weight("cost.angular_velocity", problem.cost_weights.angular_velocity);
  weight("cost.transport", problem.cost_weights.transport);
  const double tolerance = problem.search.tolerance;
  require_number(tolerance > 0.0 && tolerance <= file::loosest_tolerance, "search.tolerance", tolerance,
                 "a number > 0, at most 0.1");
  if (!problem.duration.free) return;
  require_number(problem.duration.min > 0.0, "time.min", problem.duration.min, "a number > 0 (s)");
  require_number(problem.duration.max >= problem.duration.min, "time.max", problem.duration.max, "at least time.min");
}

void check_limit_numbers(const maneuver::Limits& limits) {
  const auto positive = [](const std::string& key, double value) {
    require_number(std::isfinite(value) && value > 0.0, key.c_str(), value, "a number > 0");
  };
  const auto for_joints = [&](const char* key, const std::optional<double>& all,
                              const std::map<std::string, double>& named) {
    if (all) positive(key, *all);
    for (const auto& [joint, value] : named) positive(document::key_path(key, joint), value);
  };
  for_joints("limits.torque", limits.torque, limits.joint_torque);
  for_joints("limits.torque_component", limits.torque_component, limits.joint_torque_component);
  for_joints("limits.angular_velocity", limits.angular_velocity, limits.joint_angular_velocity);
  for_joints("limits.angular_velocity_component", limits.angular_velocity_component,
             limits.joint_angular_velocity_component);
  for (const auto& [key, named] : {std::pair("limits.swing", &limits.swing), std::pair("limits.twist", &limits.twist)})
    for (const auto& [joint, value] : *named)
      require_number(value > 0.0 && value <= std::numbers::pi, document::key_path(key, joint).c_str(), value,
                     "between 0 and π (rad)");
  for (const auto& [joint, pairs] : limits.angle)
    for (const auto& [least, most] : pairs)
      require_number(-std::numbers::pi <= least && least < most && most <= std::numbers::pi,
                     document::key_path("limits.angle", joint).c_str(), least,
                     "[min, max] with -π <= min < max <= π (rad)");
  if (limits.clearance)
    require_number(*limits.clearance >= 0.0, "limits.clearance", *limits.clearance, "a number >= 0 (m)");
  for (const maneuver::KeepOutSphere& sphere : limits.spheres) positive("limits.sphere.radius", sphere.radius);
  for (const maneuver::KeepOutHalfSpace& half : limits.half_spaces)
    require_number(std::isfinite(half.normal.stableNorm()) && !half.normal.isZero(0.0), "limits.half_space.normal",
                   half.normal.stableNorm(), "three numbers, not all 0");
}

void check_inertia(const model::SwimmerDescription& swimmer) {
  for (std::size_t i = 0; i < swimmer.bodies.size(); ++i)
    if (const auto& inertia = swimmer.bodies[i].body_inertia; inertia && !model::positive_definite(*inertia))
      throw model::InputError(file::body_key(i, "body_inertia"), "found a matrix that is not positive definite");
}

template <typename Part>
void require_name(const std::vector<Part>& known, const std::string& name, const char* key, const char* what) {
  for (const Part& part : known)
    if (part.name == name) return;
  throw model::InputError(document::key_path(key, name),
                          fmt::format("found a {} that the swimmer does not have", what));
}

void require_one_angle_for_each_axis(const model::SwimmerDescription& swimmer,
                                     const std::map<std::string, std::vector<double>>& angle) {
  for (const model::JointDescription& joint : swimmer.joints) {
    const auto angles = angle.find(joint.name);
    if (angles == angle.end()) continue;
    const auto axes = static_cast<std::size_t>(model::freedoms_of(joint.kind));
    if (angles->second.size() != axes || axes == 0)
      throw model::InputError(
          document::key_path("goal.angle", joint.name),
          fmt::format("found {} angles; allowed: one about each axis, three of a ball joint", angles->second.size()));
    for (double value : angles->second)
      require_number(std::abs(value) <= 2.0 * std::numbers::pi, document::key_path("goal.angle", joint.name).c_str(),
                     value, "between -2π and 2π (rad)");
  }
}

void check_names(const Problem& problem) {
  const model::SwimmerDescription& swimmer = problem.swimmer;
  const auto joints = [&](const auto& by_joint, const char* key) {
    for (const auto& entry : by_joint) require_name(swimmer.joints, entry.first, key, "joint");
  };
  const auto bodies = [&](const auto& by_body, const char* key) {
    for (const auto& entry : by_body) require_name(swimmer.bodies, entry.first, key, "body");
  };
  const maneuver::Limits& limits = problem.limits;
  joints(limits.joint_torque, "limits.torque");
  joints(limits.joint_torque_component, "limits.torque_component");
  joints(limits.joint_angular_velocity, "limits.angular_velocity");
  joints(limits.joint_angular_velocity_component, "limits.angular_velocity_component");
  joints(limits.swing, "limits.swing");
  joints(limits.twist, "limits.twist");
  joints(limits.angle, "limits.angle");
  if (problem.goal) {
    bodies(problem.goal->rotation, "goal.rotation");
    joints(problem.goal->angle, "goal.angle");
    require_one_angle_for_each_axis(swimmer, problem.goal->angle);
  }
  for (const maneuver::Waypoint& waypoint : problem.waypoints) bodies(waypoint.rotation, "waypoint.rotation");
}

}  // namespace

std::string foreign_multiplier(const model::System& system, const Problem& problem,
                               const std::vector<maneuver::LimitMultiplier>& multipliers) {
  using Identity = std::tuple<std::string, int, int, int, int, bool>;
  std::map<Identity, int> limited;
  for (const maneuver::LimitRow& row : maneuver::limit_rows(system, problem))
    ++limited[{row.key, row.joint, row.body, row.other_body, row.component, row.upper()}];
  for (std::size_t m = 0; m < multipliers.size(); ++m) {
    const maneuver::LimitMultiplier& own = multipliers[m];
    if (--limited[{own.key, own.joint, own.body, own.other_body, own.component, own.upper}] < 0)
      return fmt::format("limit_multipliers[{}]: found \"{}\", which limits nothing else of this problem", m, own.key);
  }
  return "";
}

std::string refusal_of(const Problem& problem) {
  file::ProblemFile file;
  file.problem = problem;
  // files tell the rule of all schemes, the reader takes it below order 4
  if (!integrator::single_step(problem.scheme)) file.problem.rule.reset();
  try {
    check_numbers(file.problem);
    check_limit_numbers(file.problem.limits);
    check_inertia(file.problem.swimmer);
    check_names(file.problem);
    file::check_statement(file.problem);
    file::require_supported(file, file::Purpose::solve);
  } catch (const model::InputError& error) {
    return error.key + ": " + error.message;
  }
  return "";
}

}  // namespace lamprey::result
