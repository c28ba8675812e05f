#include "file/plane_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "file/problem_checks.hpp"
#include "file/toml_reader.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using maneuver::Problem;

constexpr double in_plane = 1e-9;  // of a vector's length
constexpr const char* reason = "ellipses move in the plane of e₁ and e₂";

// A direction in the plane, such as an offset.
void require_within(const std::string& key, const Vector3d& v) {
  if (std::abs(v[2]) <= in_plane * v.stableNorm()) return;
  refuse(key, shown(v), fmt::format("0 along e₃: {}", reason), "set its third number to 0");
}

// A turn in the plane, such as a rotation vector or an axis.
void require_about_normal(const std::string& key, const Vector3d& v, const char* cure = "write [0.0, 0.0, angle]") {
  if (v.head<2>().stableNorm() <= in_plane * v.stableNorm()) return;
  refuse(key, shown(v), fmt::format("a turn about e₃: {}", reason), cure);
}

void require_plane_joint(const model::JointDescription& joint, std::size_t j) {
  if (joint.kind == model::JointKind::ball || joint.kind == model::JointKind::universal)
    refuse(joint_key(j, "kind"), fmt::format("a {} joint", word(joint.kind)),
           fmt::format("hinge or fixed between ellipses: {}", reason), "write kind = \"hinge\", axis = [0, 0, 1]");
  if (joint.axis) require_about_normal(joint_key(j, "axis"), *joint.axis, "write [0.0, 0.0, 1.0]");
  require_about_normal(joint_key(j, "reference_rotation"), joint.reference_rotation);
  require_within(joint_key(j, "parent_offset"), joint.parent_offset);
  require_within(joint_key(j, "child_offset"), joint.child_offset);
}

// Entries that couple the plane with what lies out of it: of velocities (V, Ω) those of V_3, Ω_1 and Ω_2 with the others.
void require_plane_body(const model::BodyDescription& body, std::size_t i) {
  const auto require = [&](const char* name, const std::optional<Eigen::Matrix3d>& matrix,
                           std::initializer_list<std::pair<int, int>> entries) {
    if (!matrix) return;
    for (const auto& [row, column] : entries)
      if (std::abs((*matrix)(row, column)) > in_plane * matrix->norm())
        refuse(body_key(i, name), fmt::format("{} in row {}, column {}", (*matrix)(row, column), row + 1, column + 1),
               fmt::format("0 there, which would drive it out of its plane: {}", reason), "set that entry to 0");
  };
  for (const auto& [name, matrix] :
       {std::pair("mass_matrix", &body.mass_matrix), std::pair("inertia_matrix", &body.inertia_matrix),
        std::pair("body_inertia", &body.body_inertia)})
    require(name, *matrix, {{0, 2}, {1, 2}, {2, 0}, {2, 1}});
  require("coupling_matrix", body.coupling_matrix, {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 2}});
}

void require_plane_end(const std::string& path, const std::array<std::optional<double>, 3>& move,
                       const std::optional<Vector3d>& turn) {
  if (move[2] && *move[2] != 0.0)
    refuse(document::key_path(path, "move"), fmt::format("{} along e₃", *move[2]),
           fmt::format("0 or \"free\" there: {}", reason), "set its third number to 0");
  if (turn) require_about_normal(document::key_path(path, "turn"), *turn);
}

void require_plane_goal(const maneuver::Goal& goal) {
  require_plane_end("goal", goal.move, goal.turn);
  for (const auto& [body, rotation] : goal.rotation)
    if (rotation) require_about_normal(document::key_path("goal.rotation", body), *rotation);
  for (const auto& [joint, turn] : goal.angle)
    if (turn.size() == 3) require_about_normal(document::key_path("goal.angle", joint), *goal.turn_of_joint(joint));
}

void require_plane_waypoint(const maneuver::Waypoint& waypoint, std::size_t n) {
  const std::string path = fmt::format("waypoint[{}]", n);
  require_plane_end(path, waypoint.move, waypoint.turn);
  for (const auto& [body, rotation] : waypoint.rotation)
    require_about_normal(document::key_path(path + ".rotation", body), rotation);
}

// Gaps are those in the plane only where it cuts obstacles in half.
void require_plane_obstacles(const maneuver::Limits& limits, double height) {
  for (std::size_t n = 0; n < limits.spheres.size(); ++n)
    if (std::abs(limits.spheres[n].centre[2] - height) > in_plane * limits.spheres[n].radius)
      refuse(fmt::format("limits.sphere[{}].centre", n), shown(limits.spheres[n].centre),
             fmt::format("{} along e₃, as start.position has it: {}", height, reason), "put it into the plane");
  for (std::size_t n = 0; n < limits.half_spaces.size(); ++n)
    require_within(fmt::format("limits.half_space[{}].normal", n), limits.half_spaces[n].normal);
}

}  // namespace

void require_plane(const Problem& problem) {
  const auto& bodies = problem.swimmer.bodies;
  const auto ellipses = static_cast<std::size_t>(
      std::count_if(bodies.begin(), bodies.end(), [](const auto& body) { return body.ellipse; }));
  if (ellipses == 0) return;
  const bool few = 2 * ellipses < bodies.size();  // the odd ones are what to mend
  for (std::size_t i = 0; i < bodies.size() && ellipses < bodies.size(); ++i) {
    if (bodies[i].ellipse != few) continue;
    refuse(body_key(i, "semi_axes"), few ? "two numbers beside bodies of three" : "three numbers beside bodies of two",
           "two for every body (ellipses in the plane) or three for every body (ellipsoids)",
           few ? "add the third number here, or leave it out of the others"
               : "leave the third number out here, or add one to the others");
  }
  for (std::size_t j = 0; j < problem.swimmer.joints.size(); ++j) require_plane_joint(problem.swimmer.joints[j], j);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    require_plane_body(bodies[i], i);
    require_about_normal(document::key_path("start.rotation", bodies[i].name), problem.start.rotation[i]);
    require_about_normal(document::key_path("start.angular_velocity", bodies[i].name),
                         problem.start.angular_velocity[i]);
  }
  require_within("start.linear_velocity", problem.start.linear_velocity);
  if (problem.goal) require_plane_goal(*problem.goal);
  for (std::size_t n = 0; n < problem.waypoints.size(); ++n) require_plane_waypoint(problem.waypoints[n], n);
  require_plane_obstacles(problem.limits, problem.start.position[2]);
  require_within("cost.displacement", problem.cost_weights.displacement);
}

namespace {

bool along(const Vector3d& v, const Vector3d& normal) { return v.cross(normal).norm() <= in_plane * v.norm(); }
bool across(const Vector3d& v, const Vector3d& normal) { return std::abs(v.dot(normal)) <= in_plane * v.norm(); }

// In the energy velocities V are mirrored and turn rates Ω are so with the opposite sign.
bool mirrored_body(const model::Body& body, const Vector3d& normal) {
  const Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity() - 2.0 * normal * normal.transpose();
  const auto unlike = [&](const Eigen::Matrix3d& m, double sign) {
    return (mirror * m * mirror - sign * m).norm() > in_plane * m.norm();
  };
  return !unlike(body.mass_matrix, 1.0) && !unlike(body.inertia_matrix, 1.0) && !unlike(body.coupling_matrix, -1.0);
}

bool mirrored_joint(const model::Joint& joint, const Vector3d& of_parent, const Vector3d& of_child, bool free_shape) {
  if (!across(joint.parent_offset, of_parent) || !across(joint.child_offset, of_child)) return false;
  switch (joint.kind) {
    case model::JointKind::fixed:
      return true;
    case model::JointKind::hinge:
      return along(joint.child_axis, of_child);
    case model::JointKind::universal:
      return false;
    case model::JointKind::ball:
      break;
  }
  for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c)
    if (!along(joint.actuation.col(c), of_parent)) return false;
  return !free_shape && (joint.stiffness == 0.0 || along(joint.reference_rotation * of_child, of_parent));
}

}  // namespace

bool stays_in_plane(const model::System& system, const maneuver::Start& start, int axis) {
  const Vector3d normal = Vector3d::Unit(axis);
  std::vector<Vector3d> seen;  // from the bodies
  for (int i = 0; i < system.body_count(); ++i) {
    const std::size_t body = model::at(i);
    seen.emplace_back(lie::exp(start.rotation[body]).transpose() * normal);
    if (!mirrored_body(system.body(i), seen[body]) || !along(start.angular_velocity[body], seen[body])) return false;
  }
  return across(start.linear_velocity, normal) &&
         std::all_of(system.joints().begin(), system.joints().end(), [&](const model::Joint& joint) {
           return mirrored_joint(joint, seen[model::at(joint.parent)], seen[model::at(joint.child)], start.free_shape);
         });
}

Problem with_plane_told(const model::System& system, Problem problem) {
  const auto tell = [](std::optional<double>& move) {
    if (!move) move = 0.0;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (!stays_in_plane(system, problem.start, axis)) continue;
    if (problem.goal) tell(problem.goal->move[model::at(axis)]);
    for (maneuver::Waypoint& waypoint : problem.waypoints) tell(waypoint.move[model::at(axis)]);
  }
  return problem;
}

}  // namespace lamprey::file
