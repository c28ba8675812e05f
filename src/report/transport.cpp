#include "report/transport.hpp"

#include <cmath>

namespace lamprey::report {

namespace {

// W of each joint's moment at a node.
Eigen::VectorXd powers_at(const file::Results& results, std::size_t node) {
  const maneuver::Solution& solution = results.solution;
  const auto& R = solution.rotation[node];
  const auto& joints = results.problem.joints;
  Eigen::VectorXd power(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto parent = static_cast<std::size_t>(joints[j].parent), child = static_cast<std::size_t>(joints[j].child);
    const Eigen::Vector3d rate = R[parent].transpose() * R[child] * solution.angular_velocity[node][child] -
                                 solution.angular_velocity[node][parent];
    power[static_cast<Eigen::Index>(j)] = -solution.control[node][j].dot(rate);  // on the parent, against the child
  }
  return power;
}

}  // namespace

double power_at(const file::Results& results, std::size_t node) { return powers_at(results, node).sum(); }

std::optional<Transport> transport(const file::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const std::size_t nodes = solution.time.size();
  if (nodes < 2 || solution.control.size() != nodes || solution.angular_velocity.size() != nodes) return std::nullopt;
  Transport sum{0.0, (solution.position.back() - solution.position.front()).norm()};
  for (std::size_t k = 0; k < nodes; ++k) {
    const double power = powers_at(results, k).lpNorm<1>();
    const bool end = k == 0 || k + 1 == nodes;
    sum.work += (end ? 0.5 : 1.0) * power * results.problem.time_step;
  }
  return sum;
}

}  // namespace lamprey::report
