#include "maneuver/asked_attitudes.hpp"

#include <sstream>

#include "lie/so3.hpp"
#include "mechanics/tree_motion.hpp"
#include "model/input_error.hpp"

namespace lamprey::maneuver {

namespace {

using Eigen::Matrix3d;
using model::at;
using model::System;

// Of bodies as the goal states them, and of joints, those included that keep their start's angles below others that do not.
AskedAttitudes stated_attitudes(const System& system, const Goal& goal, const mechanics::Rotations& start) {
  AskedAttitudes asked{std::vector<std::optional<Matrix3d>>(start.size()),
                       std::vector<std::optional<Matrix3d>>(at(system.joint_count()))};
  std::vector<char> led(start.size());  // below a joint of goal.angle
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    const auto named = goal.rotation.find(body.name);
    const bool stated = named != goal.rotation.end();
    if (stated && named->second) asked.rotation[at(i)] = lie::exp(*named->second);
    if (body.parent >= 0) {
      const model::Joint& joint = system.joint(body.joint);
      const std::optional<Eigen::Vector3d> turn = goal.turn_of_joint(joint.name);
      led[at(i)] = turn || (led[at(body.parent)] && !stated);
      const bool as_begun = goal.shape_of_start || (goal.turn && led[at(i)]) || joint.kind == model::JointKind::fixed;
      if (turn)
        asked.joint[at(body.joint)] = mechanics::rotation_at_turn(joint, *turn);
      else if (as_begun)
        asked.joint[at(body.joint)] = mechanics::child_to_parent(start, joint);
    }
    if (!stated && goal.turn && !led[at(i)]) asked.rotation[at(i)] = lie::exp(*goal.turn) * start[at(i)];
  }
  return asked;
}

// Of a joint that is told how to end and both of whose bodies are.
void refuse_contradiction(const model::Joint& joint, double off) {
  constexpr double round_off = 1e-9;  // rad
  if (off <= round_off || joint.kind == model::JointKind::fixed) return;
  std::ostringstream text;
  text << "found an end of joint " << joint.name << " " << off
       << " rad beside the one that the rotations of its two bodies make; state one of them";
  throw model::InputError("goal", text.str());
}

}  // namespace

AskedAttitudes asked_attitudes(const System& system, const Goal& goal, const mechanics::Rotations& start) {
  AskedAttitudes asked = stated_attitudes(system, goal, start);
  bool more = goal.of_joints();
  while (more) {
    more = false;
    for (int j = 0; j < system.joint_count(); ++j) {
      auto& joint = asked.joint[at(j)];
      auto &parent = asked.rotation[at(system.joint(j).parent)], &child = asked.rotation[at(system.joint(j).child)];
      if (!joint || (!parent && !child)) continue;
      if (!child)
        child = *parent * *joint;
      else if (!parent)
        parent = *child * joint->transpose();
      else
        refuse_contradiction(system.joint(j), lie::rotation_angle(joint->transpose() * (parent->transpose() * *child)));
      joint.reset();
      more = true;
    }
  }
  for (int j = 0; j < system.joint_count(); ++j)
    if (system.joint(j).kind == model::JointKind::fixed) asked.joint[at(j)].reset();  // which end as they begin
  return asked;
}

}  // namespace lamprey::maneuver
