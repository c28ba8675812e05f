#include "file/goal_checks.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "file/problem_checks.hpp"
#include "file/toml_reader.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "maneuver/asked_attitudes.hpp"
#include "model/system.hpp"

namespace lamprey::file {

namespace {

using Eigen::Matrix3d;
using maneuver::Goal;
using maneuver::Problem;

std::string end_key(const Goal& goal, const std::string& body) {
  return goal.rotation.contains(body) ? document::key_path("goal.rotation", body) : "goal.turn";
}

// Where joints are told how to end, rotations tell no more than how the whole is turned.
void check_joints_of_goal(const Problem& problem) {
  const Goal& goal = *problem.goal;
  if (!goal.of_joints()) return;
  const std::string key = goal.shape_of_start ? "goal.shape" : "goal.angle";
  if (goal.periodic)
    refuse(key, "it with goal.periodic = true", "one of the two",
           "remove it: the shape at the end of a periodic motion is that at its start");
  if (!goal.shape_of_start) return;
  if (goal.turn && !goal.rotation.empty())
    refuse(key, "\"start\" with goal.turn and goal.rotation", "at most one of the two beside it",
           "remove it: goal.turn keeps the start's shape but for bodies whose rotation is stated");
  const bool freed = std::any_of(goal.rotation.begin(), goal.rotation.end(),
                                 [](const auto& entry) { return !entry.second.has_value(); });
  if (freed || goal.rotation.size() > 1)
    refuse(key, fmt::format("\"start\" with {}", freed ? "a free rotation" : "rotations of more than one body"),
           "at most one body's rotation beside it, with which all others turn", "remove the others, or this key");
}

void check_goal_against_joints(const Problem& problem) {
  const Goal& goal = *problem.goal;
  const model::System system(problem.swimmer);
  mechanics::Rotations start;
  for (const Eigen::Vector3d& vector : problem.start.rotation) start.push_back(lie::exp(vector));
  const auto ends = maneuver::asked_attitudes(system, goal, start).rotation;
  for (std::size_t j = 0; j < problem.swimmer.joints.size(); ++j) {
    const model::JointDescription& joint = problem.swimmer.joints[j];
    const model::Joint& own = system.joint(static_cast<int>(j));
    const auto &parent = ends[model::at(own.parent)], &child = ends[model::at(own.child)];
    if (!parent || !child) continue;
    const std::string key =
        goal.rotation.contains(joint.child) ? end_key(goal, joint.child) : end_key(goal, joint.parent);
    const Matrix3d end = parent->transpose() * *child;
    const double off = misfit(joint, end);
    if (off > angle_tolerance)
      refuse(key,
             fmt::format("end rotations that are {:.4g} rad outside what the {} joint {} allows", off, word(joint.kind),
                         document::in_quotes(joint.name)),
             "end rotations that fit the joints", "change this rotation or set one of the two bodies \"free\"");
    const Matrix3d begins = start[model::at(own.parent)].transpose() * start[model::at(own.child)];
    const double change = lie::rotation_angle(begins.transpose() * end);
    if (goal.periodic && !problem.start.free_shape && change > angle_tolerance)
      refuse(key,
             fmt::format("end rotations that change joint {} by {} rad in a periodic goal",
                         document::in_quotes(joint.name), change),
             "the start's shape at the end", "remove periodic, free one rotation, or set start.free_shape = true");
  }
}

// The bodies of a gait turn alike: its root as goal.turn has it, the others with it.
void check_turn_of_gait(const Problem& problem) {
  const maneuver::Goal& goal = *problem.goal;
  if (!goal.periodic) return;
  const BodyIndex index = index_bodies(problem.swimmer);
  for (const model::BodyDescription& body : problem.swimmer.bodies) {
    const auto& joints = problem.swimmer.joints;
    const auto own = goal.rotation.find(body.name);
    if (own == goal.rotation.end() || !own->second) continue;
    if (std::any_of(joints.begin(), joints.end(), [&](const auto& joint) { return joint.child == body.name; }))
      refuse(end_key(goal, body.name), "the end of a body that a joint leads, in a periodic goal",
             "goal.turn or the rotation of the root, with which the bodies of a gait turn alike",
             "say where the root ends, or remove periodic");
    if (!goal.turn) continue;
    const double beside =
        lie::rotation_angle((lie::exp(*goal.turn) * lie::exp(problem.start.rotation[index.at(body.name)])).transpose() *
                            lie::exp(*own->second));
    if (beside > angle_tolerance)
      refuse(end_key(goal, body.name),
             fmt::format("an end {:.4g} rad beside goal.turn in a periodic goal, whose bodies turn alike", beside),
             "the rotation that goal.turn leads to", "remove this key or goal.turn");
  }
}

}  // namespace

void check_goal(const Problem& problem) {
  if (!problem.goal) return;
  const maneuver::Goal& goal = *problem.goal;
  const bool moves =
      std::any_of(goal.move.begin(), goal.move.end(), [](const auto& entry) { return entry.has_value(); });
  const bool rotates = std::any_of(goal.rotation.begin(), goal.rotation.end(),
                                   [](const auto& entry) { return entry.second.has_value(); });
  const bool wins = problem.cost_weights.of_displacement();
  if (!moves && !rotates && !goal.turn && !goal.of_joints() && !goal.stills_joints() && !goal.periodic && !wins)
    refuse("goal", "nothing asked for",
           "at least one of move, turn, rotation.NAME, angle.NAME, shape, rest or periodic",
           "add one, or remove [goal] to simulate");
  const bool asks = moves || rotates || goal.turn || !problem.waypoints.empty();
  if (goal.periodic && problem.start.free_shape && !asks && !wins && problem.cost_weights.transport == 0.0)
    refuse("goal", "a gait of any displacement, of which the cheapest is to stay at rest",
           "move, turn or rotation.NAME with numbers, a [[waypoint]], or a cost.displacement or cost.transport that "
           "pays for a way",
           "say how far a cycle is to go, as in move = [0.05, \"free\", \"free\"]");
  if (goal.stills_joints() && goal.periodic)
    refuse("goal.rest", fmt::format("{} with goal.periodic = true", goal.rest ? "true" : "\"joints\""),
           "one of the two", "remove rest: a periodic motion ends as it begins, and goes on");
  check_joints_of_goal(problem);
  check_goal_against_joints(problem);
  check_turn_of_gait(problem);
}

}  // namespace lamprey::file
