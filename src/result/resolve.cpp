#include "result/resolve.hpp"

#include <fstream>
#include <thread>

#include "lie/so3.hpp"
#include "result/followed_file.hpp"

namespace lamprey::result {

namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  std::string line;
  while (std::getline(info, line))
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

ResolvedJoint resolve(const model::Joint& joint, const model::JointDescription& described) {
  ResolvedJoint entry{joint.name, joint.kind, joint.parent, joint.child, joint.parent_offset, joint.child_offset, {}};
  Eigen::Matrix3d parent_axes = Eigen::Matrix3d::Identity();  // of the moments, at zero angle
  if (!joint.free())
    parent_axes << joint.parent_axis, joint.reference_rotation * joint.child_axis, Eigen::Vector3d::Zero();
  for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c)
    entry.control_axes.emplace_back(parent_axes * joint.actuation.col(c));
  entry.reference_rotation = described.reference_rotation;
  entry.axis = described.axis;
  entry.axes = described.axes;
  entry.actuated = !entry.control_axes.empty();
  entry.stiffness = joint.stiffness;
  entry.damping = joint.damping;
  return entry;
}

// Whether the moments are all those that the joint's kind leaves free; a description then need not name them.
bool unconfined(const ResolvedJoint& joint) {
  const std::size_t free = joint.kind == model::JointKind::universal ? 2
                           : joint.kind == model::JointKind::hinge   ? 1
                                                                     : 3;
  return joint.kind != model::JointKind::ball && joint.control_axes.size() == free;
}

}  // namespace

ResolvedProblem resolve(const model::System& system, const maneuver::Problem& problem) {
  ResolvedProblem resolved;
  static_cast<maneuver::ProblemStatement&>(resolved) = problem;
  for (const model::Body& body : system.bodies())
    resolved.bodies.push_back({body.name, body.semi_axes, body.mass, body.body_inertia, body.mass_matrix,
                               body.inertia_matrix, body.coupling_matrix, body.ellipse});
  for (int j = 0; j < system.joint_count(); ++j)
    resolved.joints.push_back(resolve(system.joint(j), problem.swimmer.joints[model::at(j)]));
  resolved.density = system.density();
  resolved.time_step = problem.time_step();
  resolved.duration = problem.duration.value;
  resolved.cost_rule = problem.cost_rule();
  resolved.free_duration = problem.duration.free;
  if (problem.duration.free) resolved.between = {problem.duration.min, problem.duration.max};
  resolved.free_shape = problem.start.free_shape;
  if (problem.start.rotation.size() == resolved.bodies.size()) {
    resolved.start = {{}, problem.start.position, problem.start.linear_velocity, problem.start.angular_velocity};
    for (const Eigen::Vector3d& rotation : problem.start.rotation)
      resolved.start->rotation.push_back(lie::exp(rotation));
  }
  resolved.tolerance = problem.search.tolerance;
  return resolved;
}

model::SwimmerDescription swimmer_of(const ResolvedProblem& resolved) {
  model::SwimmerDescription swimmer;
  swimmer.density = resolved.density.value_or(0.0);
  for (const ResolvedBody& body : resolved.bodies)
    swimmer.bodies.push_back({body.name, body.semi_axes, body.mass, body.body_inertia, body.mass_matrix,
                              body.inertia_matrix, body.coupling_matrix, body.ellipse});
  for (const ResolvedJoint& joint : resolved.joints) {
    model::JointDescription described;
    described.name = joint.name;
    described.kind = joint.kind;
    described.parent = resolved.bodies[static_cast<std::size_t>(joint.parent)].name;
    described.child = resolved.bodies[static_cast<std::size_t>(joint.child)].name;
    described.parent_offset = joint.parent_offset;
    described.child_offset = joint.child_offset;
    described.reference_rotation = joint.reference_rotation;
    described.axis = joint.axis;
    described.axes = joint.axes;
    described.actuated = joint.actuated;
    if (!joint.control_axes.empty() && !unconfined(joint)) described.control_axes = joint.control_axes;
    described.stiffness = joint.stiffness;
    described.damping = joint.damping;
    swimmer.joints.push_back(described);
  }
  return swimmer;
}

namespace {

// As asked for; of files of early versions, which do not tell, what the first node shows if there is one.
maneuver::Start start_of(const Results& results) {
  const std::optional<ResolvedStart>& asked = results.problem.start;
  if (!asked) return results.solution.rotation.empty() ? maneuver::Start() : first_node(results.solution);
  maneuver::Start start;
  for (const Eigen::Matrix3d& R : asked->rotation) start.rotation.push_back(lie::log(R));
  start.position = asked->position;
  start.angular_velocity = asked->angular_velocity;
  start.linear_velocity = asked->linear_velocity;
  return start;
}

}  // namespace

maneuver::Problem problem_of(const Results& results) {
  maneuver::Problem problem;
  static_cast<maneuver::ProblemStatement&>(problem) = results.problem;
  problem.name = results.name;
  problem.source = results.source;
  problem.swimmer = swimmer_of(results.problem);
  problem.start = start_of(results);
  problem.duration.value = results.problem.duration;
  problem.rule = results.problem.cost_rule;
  problem.duration.free = results.problem.free_duration;
  problem.duration.min = results.problem.between[0];
  problem.duration.max = results.problem.between[1];
  problem.start.free_shape = results.problem.free_shape;
  problem.search.tolerance = results.problem.tolerance;
  return problem;
}

Provenance provenance_here() {
  Provenance here;
  here.version = LAMPREY_VERSION;
  here.build_type = LAMPREY_BUILD_TYPE;
  here.compiler = LAMPREY_COMPILER;
  here.machine = processor() + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores";
  return here;
}

}  // namespace lamprey::result
