#include "file/problem_start.hpp"

#include <fmt/format.h>

#include "file/joint_numbers.hpp"
#include "file/problem_checks.hpp"
#include "file/words.hpp"
#include "integrator/step.hpp"
#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::file {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using maneuver::Problem;
using model::at;
using model::JointDescription;
using model::System;

std::vector<Vector3d> read_by_body(const TableReader& table, const BodyIndex& bodies, const Range& range) {
  std::vector<std::string> names(bodies.size());
  for (const auto& [name, body] : bodies) names[body] = name;
  table.allow_only(names);
  std::vector<Vector3d> values;
  for (const std::string& name : names) values.push_back(table.vector(name, range).value_or(Vector3d::Zero()));
  return values;
}

// Bodies of which nothing is stated are turned as the world is, or where their joints do not allow that, as these have it at zero angle.
void read_shape(const TableReader& table, const BodyIndex& bodies, const System& system, Problem& problem) {
  const TableReader rotation = table.table("rotation"), angle = table_of_joints(table, "angle", problem.swimmer);
  std::vector<Vector3d>& start = problem.start.rotation;
  start = read_by_body(rotation, bodies, turn());
  for (int i : system.root_to_leaves()) {
    if (system.body(i).parent < 0) continue;
    const model::Joint& own = system.joint(system.body(i).joint);
    const JointDescription& joint = problem.swimmer.joints[at(system.body(i).joint)];
    const Matrix3d parent = lie::exp(start[at(own.parent)]);
    const auto angles = read_angles(angle, joint);
    if (angles) refuse_both(angle, rotation, joint);
    const bool stated = rotation.find(joint.child) != nullptr;
    const bool fits = misfit(joint, parent.transpose() * lie::exp(start[at(i)])) <= angle_tolerance;
    if (angles || (!stated && !fits))
      start[at(i)] = lie::log(
          parent * mechanics::rotation_at_turn(own, maneuver::about_axes(angles.value_or(std::vector<double>()))));
  }
}

// A body that its joint leads and of which nothing is stated moves with its parent.
void read_velocities(const TableReader& table, const BodyIndex& bodies, const System& system, Problem& problem) {
  const TableReader angular_velocity = table.table("angular_velocity"),
                    rate = table_of_joints(table, "angle_rate", problem.swimmer);
  maneuver::Start& start = problem.start;
  start.angular_velocity = read_by_body(angular_velocity, bodies, any_number("rad/s"));
  for (int i : system.root_to_leaves()) {
    if (system.body(i).parent < 0) continue;
    const model::Joint& own = system.joint(system.body(i).joint);
    const JointDescription& joint = problem.swimmer.joints[at(system.body(i).joint)];
    const auto rates = read_angle_rates(rate, joint, "start.angular_velocity");
    if (rates) refuse_both(rate, angular_velocity, joint);
    if (own.free() || angular_velocity.find(joint.child)) continue;
    const mechanics::JointFrame frame =
        mechanics::joint_frame(own, lie::exp(start.rotation[at(own.parent)]), lie::exp(start.rotation[at(i)]));
    start.angular_velocity[at(i)] = frame.child_to_parent.transpose() * start.angular_velocity[at(own.parent)];
    if (rates) start.angular_velocity[at(i)] += frame.axes * maneuver::about_axes(*rates);
  }
  start.linear_velocity = table.vector("linear_velocity", any_number("m/s")).value_or(Vector3d::Zero());
}

}  // namespace

void read_start(const TableReader& table, Problem& problem) {
  table.allow_only({"position", "rotation", "angle", "angular_velocity", "angle_rate", "linear_velocity",
                    "zero_momentum", "free_shape"});
  const BodyIndex bodies = index_bodies(problem.swimmer);
  problem.start.position = table.vector("position", any_number("m")).value_or(Vector3d::Zero());
  const System system(problem.swimmer);
  read_shape(table, bodies, system, problem);
  read_velocities(table, bodies, system, problem);
  problem.start.free_shape = table.boolean("free_shape").value_or(false);
}

void balance_start(const TableReader& table, Problem& problem) {
  if (!table.boolean("zero_momentum").value_or(false)) return;
  if (const document::TomlValue* stated = table.find("linear_velocity"))
    refuse(table.key("linear_velocity"), shown(*stated) + " beside zero_momentum = true", "one of the two",
           "remove it: the whole moves as zero momentum demands");
  const System system(problem.swimmer);
  maneuver::Start& start = problem.start;
  const integrator::State balanced = maneuver::start_without_momentum(system, start);
  const Eigen::VectorXd velocity = integrator::velocity_of_state(system, balanced);
  start.angular_velocity = mechanics::angular_velocities(system, balanced.rotation, velocity);
  start.linear_velocity = velocity.tail<3>();
}

}  // namespace lamprey::file
