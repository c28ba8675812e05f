#include "file/stored_question.hpp"

#include <cmath>

#include <fmt/format.h>

#include "file/problem_checks.hpp"
#include "file/problem_file.hpp"
#include "file/problem_limits.hpp"
#include "file/words.hpp"

namespace lamprey::file {

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
  weight("cost.transport", problem.cost_weights.transport);
  const double tolerance = problem.search.tolerance;
  require_number(tolerance > 0.0 && tolerance <= loosest_tolerance, "search.tolerance", tolerance,
                 "a number > 0, at most 0.1");
  for (const maneuver::KeepOutSphere& sphere : problem.limits.spheres)
    require_number(sphere.radius > 0.0, "limits.sphere.radius", sphere.radius, "a number > 0 (m)");
}

template <typename Part>
void require_name(const std::vector<Part>& known, const std::string& name, const char* key, const char* what) {
  for (const Part& part : known)
    if (part.name == name) return;
  throw model::InputError(key_path(key, name), fmt::format("found a {} that the swimmer does not have", what));
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
  joints(limits.swing, "limits.swing");
  joints(limits.twist, "limits.twist");
  joints(limits.angle, "limits.angle");
  if (problem.goal) bodies(problem.goal->rotation, "goal.rotation");
  for (const maneuver::Waypoint& waypoint : problem.waypoints) bodies(waypoint.rotation, "waypoint.rotation");
}

}  // namespace

std::string refusal_of(const Problem& problem) {
  ProblemFile file;
  file.problem = problem;
  // files tell the rule of all schemes, the reader takes it below order 4
  if (!integrator::single_step(problem.scheme)) file.problem.rule.reset();
  try {
    check_numbers(file.problem);
    check_names(file.problem);
    check_statement(file.problem);
    require_supported(file, Purpose::solve);
  } catch (const model::InputError& error) {
    return error.key + ": " + error.message;
  }
  return "";
}

}  // namespace lamprey::file
