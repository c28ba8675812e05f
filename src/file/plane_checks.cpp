#include "file/plane_checks.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "file/problem_checks.hpp"
#include "file/toml_reader.hpp"
#include "file/words.hpp"

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using maneuver::Problem;

constexpr double in_plane = 1e-9;  // of a vector's length
constexpr const char* reason = "ellipses move in the plane of e_1 and e_2";

// A direction in the plane, such as an offset.
void require_within(const std::string& key, const Vector3d& v) {
  if (std::abs(v[2]) <= in_plane * v.norm()) return;
  refuse(key, shown(v), fmt::format("0 along e_3: {}", reason), "set its third number to 0");
}

// A turn in the plane, such as a rotation vector or an axis.
void require_about_normal(const std::string& key, const Vector3d& v) {
  if (v.head<2>().norm() <= in_plane * v.norm()) return;
  refuse(key, shown(v), fmt::format("a turn about e_3: {}", reason), "write [0.0, 0.0, angle]");
}

void require_plane_joint(const model::JointDescription& joint, std::size_t j) {
  if (joint.kind == model::JointKind::ball || joint.kind == model::JointKind::universal)
    refuse(joint_key(j, "kind"), fmt::format("a {} joint", word(joint.kind)),
           fmt::format("hinge or fixed between ellipses: {}", reason), "write kind = \"hinge\", axis = [0, 0, 1]");
  if (joint.axis) require_about_normal(joint_key(j, "axis"), *joint.axis);
  require_about_normal(joint_key(j, "reference_rotation"), joint.reference_rotation);
  require_within(joint_key(j, "parent_offset"), joint.parent_offset);
  require_within(joint_key(j, "child_offset"), joint.child_offset);
}

void require_plane_goal(const maneuver::Goal& goal) {
  if (goal.move[2] && *goal.move[2] != 0.0)
    refuse("goal.move", fmt::format("{} along e_3", *goal.move[2]), fmt::format("0 or \"free\" there: {}", reason),
           "set its third number to 0");
  if (goal.turn) require_about_normal("goal.turn", *goal.turn);
  for (const auto& [body, rotation] : goal.rotation)
    if (rotation) require_about_normal(key_path("goal.rotation", body), *rotation);
}

}  // namespace

void require_plane(const Problem& problem) {
  const auto& bodies = problem.swimmer.bodies;
  if (std::none_of(bodies.begin(), bodies.end(), [](const auto& body) { return body.ellipse; })) return;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].ellipse)
      refuse(body_key(i, "semi_axes"), "three numbers beside bodies of two",
             "two for every body (ellipses in the plane) or three for every body (ellipsoids)",
             "leave the third number out here, or add one to the others");
  }
  for (std::size_t j = 0; j < problem.swimmer.joints.size(); ++j) require_plane_joint(problem.swimmer.joints[j], j);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    require_about_normal(key_path("start.rotation", bodies[i].name), problem.start.rotation[i]);
    require_about_normal(key_path("start.angular_velocity", bodies[i].name), problem.start.angular_velocity[i]);
  }
  require_within("start.linear_velocity", problem.start.linear_velocity);
  if (problem.goal) require_plane_goal(*problem.goal);
}

}  // namespace lamprey::file
