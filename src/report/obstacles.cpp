#include "report/obstacles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamprey::report {

std::vector<PassedPoint> passed_points(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const Eigen::Vector3d start =
      results.problem.start ? results.problem.start->position : Eigen::Vector3d(solution.position.front());
  std::vector<PassedPoint> points;
  for (const maneuver::Waypoint& waypoint : results.problem.waypoints) {
    if (std::none_of(waypoint.move.begin(), waypoint.move.end(), [](const auto& move) { return move.has_value(); }))
      continue;
    const auto nearest = std::min_element(solution.time.begin(), solution.time.end(), [&](double a, double b) {
      return std::abs(a - waypoint.time) < std::abs(b - waypoint.time);
    });
    Eigen::Vector3d position = solution.position[static_cast<std::size_t>(nearest - solution.time.begin())];
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      if (const auto& move = waypoint.move[static_cast<std::size_t>(axis)]) position[axis] = start[axis] + *move;
    points.push_back({waypoint.time, position});
  }
  return points;
}

std::optional<PaperHalfPlane> cut(const maneuver::KeepOutHalfSpace& half, const View& view,
                                  const Eigen::Vector3d& point) {
  constexpr double across = 0.3;  // of the normal, on paper
  const Eigen::Vector3d normal = half.normal.stableNormalized();
  const Eigen::Vector2d on_paper = view * normal;
  const double share = on_paper.norm();
  if (!(share > across)) return std::nullopt;
  // n·(x − p) = 0 with what x has along the eye's direction that of the point
  const Eigen::Vector3d at_depth = point - view.transpose() * (view * point);
  return PaperHalfPlane{on_paper / share, normal.dot(half.point - at_depth) / share};
}

std::optional<std::array<Eigen::Vector2d, 2>> line_in_box(const PaperHalfPlane& line, const Eigen::Vector2d& low,
                                                          const Eigen::Vector2d& high) {
  const Eigen::Vector2d along(-line.normal.y(), line.normal.x()), foot = line.offset * line.normal;
  double first = -std::numeric_limits<double>::infinity(), last = -first;
  for (Eigen::Index k = 0; k < 2; ++k) {
    if (along[k] == 0.0) {
      if (foot[k] < low[k] || foot[k] > high[k]) return std::nullopt;
      continue;
    }
    const double a = (low[k] - foot[k]) / along[k], b = (high[k] - foot[k]) / along[k];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  if (!(first < last)) return std::nullopt;
  return std::array<Eigen::Vector2d, 2>{foot + first * along, foot + last * along};
}

}  // namespace lamprey::report
