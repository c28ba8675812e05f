#include "report/joint_demands.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lie/so3.hpp"
#include "maneuver/node_work.hpp"
#include "model/system.hpp"

namespace lamprey::report {

namespace {

using Eigen::Vector3d;
using model::at;

// rad/s, of the child against the parent, parent's frame.
Vector3d joint_rate(const file::Results& results, std::size_t node, const file::ResolvedJoint& joint) {
  const auto& R = results.solution.rotation[node];
  const auto& rate = results.solution.angular_velocity[node];
  return R[at(joint.parent)].transpose() * R[at(joint.child)] * rate[at(joint.child)] - rate[at(joint.parent)];
}

// The same over the step after a node.
Vector3d step_rate(const file::Results& results, std::size_t node, const file::ResolvedJoint& joint) {
  const auto relative = [&](std::size_t k) -> Eigen::Matrix3d {
    const auto& R = results.solution.rotation[k];
    return R[at(joint.parent)].transpose() * R[at(joint.child)];
  };
  return lie::log(relative(node + 1) * relative(node).transpose()) / results.problem.time_step;
}

// Before and after a node a joint's rates over the steps, or what it has at either end, rad/s.
std::pair<Vector3d, Vector3d> rates_about(const file::Results& results, std::size_t node,
                                          const file::ResolvedJoint& joint) {
  const std::size_t last = results.solution.time.size() - 1;
  return {node > 0 ? step_rate(results, node - 1, joint) : joint_rate(results, node, joint),
          node < last ? step_rate(results, node, joint) : joint_rate(results, node, joint)};
}

// A node's moment, constant about it, against the rates from step to step.
void add_node(const file::Results& results, std::size_t node, std::size_t j, JointDemand& demand) {
  const auto [before, after] = rates_about(results, node, results.problem.joints[j]);
  const Vector3d& u = results.solution.control[node][j];
  const double share = node == 0 || node + 1 == results.solution.time.size() ? 0.5 : 1.0;
  demand.largest_rate = std::max({demand.largest_rate, before.norm(), after.norm()});
  demand.largest_power = std::max({demand.largest_power, std::abs(u.dot(before)), std::abs(u.dot(after))});
  demand.work += share * results.problem.time_step *
                 maneuver::mean_work({0.5 * u.dot(after + before), 0.5 * u.dot(after - before)});
}

double largest_moment(const maneuver::Solution& solution, std::size_t joint) {
  double largest = 0.0;
  for (const maneuver::Vectors& moments : solution.control) largest = std::max(largest, moments[joint].norm());
  for (const auto& step : solution.control_stages)
    for (const maneuver::Vectors& moments : step) largest = std::max(largest, moments[joint].norm());
  return largest;
}

std::vector<std::pair<double, double>> swept(const maneuver::Solution& solution, std::size_t joint,
                                             model::JointKind kind) {
  if (solution.joint_angle.empty() || kind == model::JointKind::fixed) return {};
  const bool ball = kind == model::JointKind::ball;
  constexpr double most = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, double>> angles(kind == model::JointKind::universal ? 2 : 1, {most, -most});
  for (const maneuver::Vectors& turns : solution.joint_angle) {
    for (std::size_t axis = 0; axis < angles.size(); ++axis) {
      const double angle = ball ? std::abs(std::remainder(turns[joint].norm(), 2.0 * std::numbers::pi))
                                : turns[joint][static_cast<Eigen::Index>(axis)];
      angles[axis] = {std::min(angles[axis].first, angle), std::max(angles[axis].second, angle)};
    }
  }
  return angles;
}

}  // namespace

Eigen::VectorXd joint_powers(const file::Results& results, std::size_t node) {
  const auto& joints = results.problem.joints;
  Eigen::VectorXd power(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j)  // on the parent, against the child
    power[static_cast<Eigen::Index>(j)] = -results.solution.control[node][j].dot(joint_rate(results, node, joints[j]));
  return power;
}

std::optional<std::vector<JointDemand>> joint_demands(const file::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const std::size_t nodes = solution.time.size();
  if (nodes < 2 || solution.control.size() != nodes || solution.angular_velocity.size() != nodes) return std::nullopt;
  std::vector<JointDemand> demands;
  for (std::size_t j = 0; j < results.problem.joints.size(); ++j) {
    const file::ResolvedJoint& joint = results.problem.joints[j];
    demands.push_back(
        {.joint = joint.name, .largest_moment = largest_moment(solution, j), .angles = swept(solution, j, joint.kind)});
    for (std::size_t k = 0; k < nodes; ++k) add_node(results, k, j, demands[j]);
  }
  return demands;
}

}  // namespace lamprey::report
