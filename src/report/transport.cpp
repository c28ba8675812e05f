#include "report/transport.hpp"

#include <cmath>

namespace lamprey::report {

std::optional<Transport> transport(const file::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const std::size_t nodes = solution.time.size();
  if (nodes < 2 || solution.control.size() != nodes || solution.angular_velocity.size() != nodes) return std::nullopt;
  Transport sum{0.0, (solution.position.back() - solution.position.front()).norm()};
  for (std::size_t k = 0; k < nodes; ++k) {
    double power = 0.0;
    for (std::size_t j = 0; j < results.problem.joints.size(); ++j) {
      const auto parent = static_cast<std::size_t>(results.problem.joints[j].parent);
      const auto child = static_cast<std::size_t>(results.problem.joints[j].child);
      const auto& R = solution.rotation[k];
      const Eigen::Vector3d rate =
          R[parent].transpose() * R[child] * solution.angular_velocity[k][child] - solution.angular_velocity[k][parent];
      power += std::abs(solution.control[k][j].dot(rate));
    }
    const bool end = k == 0 || k + 1 == nodes;
    sum.work += (end ? 0.5 : 1.0) * power * results.problem.time_step;
  }
  return sum;
}

}  // namespace lamprey::report
