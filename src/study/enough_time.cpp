#include "study/enough_time.hpp"

#include <algorithm>
#include <cmath>

#include "integrator/scheme.hpp"
#include "maneuver/limit_rows.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::study {

namespace {

using maneuver::LimitedNode;
using maneuver::LimitRow;
using maneuver::Problem;
using maneuver::Solution;

constexpr double kept = 1e-3;  // units of the rows, of limits that time does not ease

// Whether it has all that limits look at, at each node.
bool has_all_nodes(const Solution& solution) {
  const std::size_t nodes = solution.time.size();
  return nodes > 1 && solution.rotation.size() == nodes && solution.position.size() == nodes &&
         solution.control.size() == nodes;
}

// Whether only time stands between the motion's shapes and how they get the swimmer along.
bool moves_alike_at_any_speed(const Problem& problem) {
  const auto moves = [](const std::vector<Eigen::Vector3d>& velocities) {
    return std::any_of(velocities.begin(), velocities.end(), [](const auto& w) { return !w.isZero(0.0); });
  };
  const maneuver::Start& start = problem.start;
  return !problem.swimmer.compliant() && problem.waypoints.empty() && integrator::single_step(problem.scheme) &&
         start.linear_velocity.isZero(0.0) && !moves(start.angular_velocity);
}

}  // namespace

std::optional<double> enough_time(const model::System& system, const Problem& problem, const Solution& solution,
                                  bool roughly) {
  if (!moves_alike_at_any_speed(problem) || !has_all_nodes(solution)) return std::nullopt;
  const double duration = solution.time.back() - solution.time.front();
  const auto steps = static_cast<int>(solution.time.size()) - 1;
  double stretch = 1.0;
  for (const LimitRow& row : maneuver::limit_rows(system, problem)) {
    if (row.of_duration()) continue;
    for (int k = 0; k <= steps; ++k) {
      if (!maneuver::applies(row, k, steps, duration)) continue;
      const auto node = static_cast<std::size_t>(k);
      const Eigen::VectorXd moment = mechanics::along_actuation(
          system, mechanics::moments_of_applied(system, solution.rotation[node], solution.control[node]));
      const LimitedNode at{solution.rotation[node], solution.rotation[k > 0 ? node - 1 : 0],
                           solution.position[node], moment,
                           duration / steps,        duration};
      const double missing = -maneuver::limit_value(system, row, at, 0.0);
      if (!(missing > 0.0)) continue;
      const double over = 1.0 + row.excess(missing, duration / steps) / row.bound;
      if (row.of_moments())
        stretch = std::max(stretch, std::sqrt(over));
      else if (row.of_rate())
        stretch = std::max(stretch, over);
      else if (!roughly && missing > kept)
        return std::nullopt;
    }
  }
  return stretch > 1.0 ? std::optional(stretch * duration) : std::nullopt;
}

}  // namespace lamprey::study
