#include "file/problem_start.hpp"

#include <map>

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
using model::JointDescription;
using model::JointKind;

// Joints from the root on, so that a parent comes before its children.
std::vector<const JointDescription*> from_the_root(const model::SwimmerDescription& swimmer) {
  std::multimap<std::string, const JointDescription*> below;
  for (const JointDescription& joint : swimmer.joints) below.emplace(joint.parent, &joint);
  std::vector<const JointDescription*> order;
  const auto add_below = [&](const std::string& parent) {
    const auto [first, last] = below.equal_range(parent);
    for (auto own = first; own != last; ++own) order.push_back(own->second);
  };
  add_below(swimmer.bodies.front().name);
  for (std::size_t n = 0; n < order.size(); ++n) add_below(order[n]->child);
  return order;
}

std::vector<Vector3d> read_by_body(const TableReader& table, const BodyIndex& bodies, const Range& range) {
  std::vector<std::string> names(bodies.size());
  for (const auto& [name, body] : bodies) names[body] = name;
  table.allow_only(names);
  std::vector<Vector3d> values;
  for (const std::string& name : names) values.push_back(table.vector(name, range).value_or(Vector3d::Zero()));
  return values;
}

// Child → parent at these angles.
Matrix3d turned(const JointDescription& joint, const std::vector<double>& angles) {
  const Matrix3d zero = lie::exp(joint.reference_rotation);
  if (angles.empty()) return zero;
  if (joint.kind == JointKind::hinge) return zero * lie::exp(angles[0] * joint.axis->stableNormalized());
  if (joint.kind == JointKind::ball) return lie::exp(Vector3d(angles[0], angles[1], angles[2])) * zero;
  return lie::exp(angles[0] * (*joint.axes)[0].stableNormalized()) * zero *
         lie::exp(angles[1] * (*joint.axes)[1].stableNormalized());
}

// Bodies of which nothing is stated are turned as the world is, or where their joints do not allow that, as these have it at zero angle.
void read_shape(const TableReader& table, const BodyIndex& bodies, Problem& problem) {
  const TableReader rotation = table.table("rotation"), angle = table_of_joints(table, "angle", problem.swimmer);
  std::vector<Vector3d>& start = problem.start.rotation;
  start = read_by_body(rotation, bodies, turn());
  for (const JointDescription* joint : from_the_root(problem.swimmer)) {
    const std::size_t child = bodies.at(joint->child);
    const Matrix3d parent = lie::exp(start[bodies.at(joint->parent)]);
    const auto angles = read_angles(angle, *joint);
    if (angles) refuse_both(angle, rotation, *joint);
    const bool stated = rotation.find(joint->child) != nullptr;
    const bool fits = misfit(*joint, parent.transpose() * lie::exp(start[child])) <= angle_tolerance;
    if (angles || (!stated && !fits))
      start[child] = lie::log(parent * turned(*joint, angles.value_or(std::vector<double>())));
  }
}

// Of a child seen from its parent, in its own frame, rad/s: its joint's angles change at these rates.
Vector3d turning(const JointDescription& joint, const Matrix3d& child_to_parent, const std::vector<double>& rates) {
  if (joint.kind == JointKind::hinge) return rates[0] * joint.axis->stableNormalized();
  return rates[0] * (child_to_parent.transpose() * (*joint.axes)[0].stableNormalized()) +
         rates[1] * (*joint.axes)[1].stableNormalized();
}

// A body that its joint leads and of which nothing is stated moves with its parent.
void read_velocities(const TableReader& table, const BodyIndex& bodies, Problem& problem) {
  const TableReader angular_velocity = table.table("angular_velocity"),
                    rate = table_of_joints(table, "angle_rate", problem.swimmer);
  maneuver::Start& start = problem.start;
  start.angular_velocity = read_by_body(angular_velocity, bodies, any_number("rad/s"));
  for (const JointDescription* joint : from_the_root(problem.swimmer)) {
    const auto rates = read_angle_rates(rate, *joint, "start.angular_velocity");
    if (rates) refuse_both(rate, angular_velocity, *joint);
    if (joint->kind == JointKind::ball || angular_velocity.find(joint->child)) continue;
    const std::size_t child = bodies.at(joint->child), parent = bodies.at(joint->parent);
    const Matrix3d Q = lie::exp(start.rotation[parent]).transpose() * lie::exp(start.rotation[child]);
    start.angular_velocity[child] = Q.transpose() * start.angular_velocity[parent];
    if (rates) start.angular_velocity[child] += turning(*joint, Q, *rates);
  }
  start.linear_velocity = table.vector("linear_velocity", any_number("m/s")).value_or(Vector3d::Zero());
}

}  // namespace

void read_start(const TableReader& table, Problem& problem) {
  table.allow_only({"position", "rotation", "angle", "angular_velocity", "angle_rate", "linear_velocity",
                    "zero_momentum", "free_shape"});
  const BodyIndex bodies = index_bodies(problem.swimmer);
  problem.start.position = table.vector("position", any_number("m")).value_or(Vector3d::Zero());
  read_shape(table, bodies, problem);
  read_velocities(table, bodies, problem);
  problem.start.free_shape = table.boolean("free_shape").value_or(false);
}

void balance_start(const TableReader& table, Problem& problem) {
  if (!table.boolean("zero_momentum").value_or(false)) return;
  if (const TomlValue* stated = table.find("linear_velocity"))
    refuse(table.key("linear_velocity"), shown(*stated) + " beside zero_momentum = true", "one of the two",
           "remove it: the whole moves as zero momentum demands");
  const model::System system(problem.swimmer);
  maneuver::Start& start = problem.start;
  const integrator::State balanced = maneuver::start_without_momentum(system, start);
  const Eigen::VectorXd velocity = integrator::velocity_of_state(system, balanced);
  start.angular_velocity = mechanics::angular_velocities(system, balanced.rotation, velocity);
  start.linear_velocity = velocity.tail<3>();
}

}  // namespace lamprey::file
