#include "file/problem_start.hpp"

#include <map>

#include <fmt/format.h>

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

using Bodies = std::map<std::string, std::size_t>;

Bodies numbered(const model::SwimmerDescription& swimmer) {
  Bodies index;
  for (std::size_t i = 0; i < swimmer.bodies.size(); ++i) index[swimmer.bodies[i].name] = i;
  return index;
}

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

std::vector<Vector3d> read_by_body(const TableReader& table, const Bodies& bodies, const Range& range) {
  std::vector<std::string> names(bodies.size());
  for (const auto& [name, body] : bodies) names[body] = name;
  table.allow_only(names);
  std::vector<Vector3d> values;
  for (const std::string& name : names) values.push_back(table.vector(name, range).value_or(Vector3d::Zero()));
  return values;
}

// rad, of a hinge or of a universal joint's two axes.
std::optional<std::array<double, 2>> stated_angles(const TableReader& table, const JointDescription& joint) {
  const TomlValue* value = table.find(joint.name);
  if (!value) return std::nullopt;
  if (joint.kind == JointKind::hinge) return {{*table.number(joint.name, turn()), 0.0}};
  if (joint.kind != JointKind::universal)
    refuse(table.key(joint.name), fmt::format("an angle of a {} joint", word(joint.kind)),
           "angles of hinges and universal joints",
           fmt::format("state start.{} instead", key_path("rotation", joint.child)));
  const std::string allowed = "two angles (rad), one about each axis";
  if (value->kind != TomlValue::Kind::array || value->items.size() != 2)
    refuse(table.key(joint.name), shown(*value), allowed, "write them in brackets, as in [0.1, 0.0]");
  return {{table.number_in(value->items[0], joint.name, turn(), *value, allowed),
           table.number_in(value->items[1], joint.name, turn(), *value, allowed)}};
}

// Child → parent at these angles.
Matrix3d turned(const JointDescription& joint, const std::array<double, 2>& angles) {
  const Matrix3d zero = lie::exp(joint.reference_rotation);
  if (joint.kind == JointKind::hinge) return zero * lie::exp(angles[0] * joint.axis->stableNormalized());
  if (joint.kind != JointKind::universal) return zero;
  return lie::exp(angles[0] * (*joint.axes)[0].stableNormalized()) * zero *
         lie::exp(angles[1] * (*joint.axes)[1].stableNormalized());
}

// Bodies of which nothing is stated are turned as the world is, or where their joints do not allow that, as these have it at zero angle.
void read_shape(const TableReader& table, const Bodies& bodies, Problem& problem) {
  const TableReader rotation = table.table("rotation"), angle = table.table("angle");
  std::vector<Vector3d>& start = problem.start.rotation;
  start = read_by_body(rotation, bodies, turn());
  std::vector<std::string> joints;
  for (const JointDescription& joint : problem.swimmer.joints) joints.push_back(joint.name);
  angle.allow_only(joints);
  for (const JointDescription* joint : from_the_root(problem.swimmer)) {
    const std::size_t child = bodies.at(joint->child);
    const Matrix3d parent = lie::exp(start[bodies.at(joint->parent)]);
    const auto angles = stated_angles(angle, *joint);
    const bool stated = rotation.find(joint->child) != nullptr;
    if (angles && stated)
      refuse(angle.key(joint->name), fmt::format("an angle beside {}", rotation.key(joint->child)), "one of the two",
             "remove one");
    const bool fits = misfit(*joint, parent.transpose() * lie::exp(start[child])) <= angle_tolerance;
    if (angles || (!stated && !fits))
      start[child] = lie::log(parent * turned(*joint, angles.value_or(std::array<double, 2>{})));
  }
}

// A body that its joint leads and whose angular velocity the file does not state moves with its parent.
void read_velocities(const TableReader& table, const Bodies& bodies, Problem& problem) {
  const TableReader angular_velocity = table.table("angular_velocity");
  maneuver::Start& start = problem.start;
  start.angular_velocity = read_by_body(angular_velocity, bodies, any_number("rad/s"));
  for (const JointDescription* joint : from_the_root(problem.swimmer)) {
    if (joint->kind == JointKind::ball || angular_velocity.find(joint->child)) continue;
    const std::size_t child = bodies.at(joint->child), parent = bodies.at(joint->parent);
    start.angular_velocity[child] = lie::exp(start.rotation[child]).transpose() *
                                    (lie::exp(start.rotation[parent]) * start.angular_velocity[parent]);
  }
  start.linear_velocity = table.vector("linear_velocity", any_number("m/s")).value_or(Vector3d::Zero());
}

}  // namespace

void read_start(const TableReader& table, Problem& problem) {
  table.allow_only(
      {"position", "rotation", "angle", "angular_velocity", "linear_velocity", "zero_momentum", "free_shape"});
  const Bodies bodies = numbered(problem.swimmer);
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
