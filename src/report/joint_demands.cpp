#include "report/joint_demands.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "lie/so3.hpp"
#include "model/system.hpp"
#include "report/joint_rates.hpp"
#include "report/work_within_step.hpp"
#include "shape/node_work.hpp"

namespace lamprey::report {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::at;

// Before and after a node a joint's rates over the steps, or what it has at either end, rad/s.
std::pair<Vector3d, Vector3d> rates_about(const result::Results& results, std::size_t node, std::size_t j) {
  const result::ResolvedJoint& joint = results.problem.joints[j];
  const auto& angles = results.solution.joint_angle;
  const bool by_angles = joint.kind == model::JointKind::universal && !angles.empty();
  const Vector3d own = joint_rate(results, node, joint);
  const Matrix3d axes = axes_at(results, node, joint);
  const auto over = [&](std::size_t step) -> Vector3d {
    if (by_angles) return axes * (angles[step + 1][j] - angles[step][j]) / results.problem.time_step;
    return step_rate(results, step, joint);
  };
  const std::size_t last = results.solution.time.size() - 1;
  return {node > 0 ? over(node - 1) : own, node < last ? over(node) : own};
}

// What of a joint one drive moves: everything, or what lies along one of its axes.
struct Driven {
  std::size_t joint;
  std::optional<int> axis;  // of a universal joint

  Vector3d part(const Matrix3d& axes, const Vector3d& vector) const {
    return axis ? Vector3d(axes.col(*axis).dot(vector) * axes.col(*axis)) : vector;
  }
};

std::vector<Driven> drives_of(const result::ResolvedProblem& problem) {
  std::vector<Driven> drives;
  for (std::size_t j = 0; j < problem.joints.size(); ++j)
    if (result::drive_count(problem.joints[j]) == 1)
      drives.push_back({j, std::nullopt});
    else
      drives.insert(drives.end(), {{j, 0}, {j, 1}});
  return drives;
}

// What a node asks for, and the work of its moment, constant about it, against the rates from step to step, J.
double take_node(const result::Results& results, std::size_t node, const Driven& drive, JointDemand& demand) {
  const result::ResolvedJoint& joint = results.problem.joints[drive.joint];
  const Matrix3d axes = axes_at(results, node, joint);
  const auto rates = rates_about(results, node, drive.joint);
  const Vector3d before = drive.part(axes, rates.first), after = drive.part(axes, rates.second),
                 own = drive.part(axes, joint_rate(results, node, joint)),
                 u = drive.part(axes, results.solution.control[node][drive.joint]);
  const double share = node == 0 || node + 1 == results.solution.time.size() ? 0.5 : 1.0;
  demand.largest_rate = std::max({demand.largest_rate, before.norm(), after.norm(), own.norm()});
  demand.largest_power = std::max(demand.largest_power, std::abs(u.dot(own)));
  return share * results.problem.time_step *
         shape::mean_work({0.5 * u.dot(after + before), 0.5 * u.dot(after - before)});
}

// Of a universal joint's axes the first does not move in the parent's frame, the second stays orthogonal to it.
double largest_moment(const result::Results& results, const Driven& drive) {
  const std::optional<std::array<Vector3d, 2>>& axes = results.problem.joints[drive.joint].axes;
  const auto size = [&](const Vector3d& moment) {
    if (!drive.axis) return moment.norm();
    const Vector3d along = (*axes)[0].normalized().dot(moment) * (*axes)[0].normalized();
    return (*drive.axis == 0 ? along : Vector3d(moment - along)).norm();
  };
  double largest = 0.0;
  for (const maneuver::Vectors& moments : results.solution.control)
    largest = std::max(largest, size(moments[drive.joint]));
  for (const auto& step : results.solution.control_stages)
    for (const maneuver::Vectors& moments : step) largest = std::max(largest, size(moments[drive.joint]));
  return largest;
}

std::vector<std::pair<double, double>> swept(const result::Results& results, const Driven& drive) {
  const maneuver::Solution& solution = results.solution;
  const std::size_t joint = drive.joint;
  const model::JointKind kind = results.problem.joints[joint].kind;
  if (solution.joint_angle.empty() || kind == model::JointKind::fixed) return {};
  const bool ball = kind == model::JointKind::ball;
  constexpr double most = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, double>> angles(kind == model::JointKind::universal ? 2 : 1, {most, -most});
  for (const maneuver::Vectors& turns : solution.joint_angle) {
    for (std::size_t axis = 0; axis < angles.size(); ++axis) {
      const double angle =
          ball ? std::abs(lie::shorter_way(turns[joint].norm())) : turns[joint][static_cast<Eigen::Index>(axis)];
      angles[axis] = {std::min(angles[axis].first, angle), std::max(angles[axis].second, angle)};
    }
  }
  if (drive.axis) return {angles[at(*drive.axis)]};
  return angles;
}

}  // namespace

std::optional<std::vector<JointDemand>> joint_demands(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const std::size_t nodes = solution.time.size();
  if (nodes < 2 || solution.control.size() != nodes || solution.angular_velocity.size() != nodes) return std::nullopt;
  const bool within = tells_stages(results);
  std::vector<JointDemand> demands;
  for (const Driven& drive : drives_of(results.problem)) {
    const std::string& name = results.problem.joints[drive.joint].name;
    JointDemand demand{.joint = drive.axis ? fmt::format("{} {}", name, *drive.axis + 1) : name,
                       .largest_moment = largest_moment(results, drive),
                       .ball = results.problem.joints[drive.joint].kind == model::JointKind::ball,
                       .angles = swept(results, drive)};
    for (std::size_t k = 0; k < nodes; ++k) {
      const double about_node = take_node(results, k, drive, demand);
      if (!within) demand.work += about_node;
      if (within && k + 1 < nodes) demand.work += work_within_step(results, k, drive.joint, drive.axis);
    }
    demands.push_back(std::move(demand));
  }
  return demands;
}

}  // namespace lamprey::report
