#include "report/shape_loop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "file/resolve.hpp"
#include "lie/so3.hpp"
#include "model/system.hpp"

namespace lamprey::report {
namespace {

using mechanics::Planar;

constexpr double still = 1e-7;        // rad: less is round-off of an angle that is held
constexpr double closed = 1e-6;       // rad, between the first shape and the last
constexpr double at_rest = 1e-8;      // total momentum beside what the bodies carry
constexpr double reach_margin = 1.25;       // of the angles' reach, how far the rectangle goes
constexpr double least_reach = 0.05;  // rad

// The angles that turn at all.
std::vector<ShapeLoop::Angle> turning_angles(const file::Results& results) {
  std::vector<ShapeLoop::Angle> turning;
  const auto& angles = results.solution.joint_angle;
  for (std::size_t j = 0; j < results.problem.joints.size() && !angles.empty(); ++j)
    for (int axis = 0; axis < 3; ++axis)
      if (std::any_of(angles.begin(), angles.end(), [&](const auto& node) { return std::abs(node[j][axis]) > still; }))
        turning.push_back({j, axis});
  return turning;
}

// An angle along the nodes, without the jumps of whole turns.
std::vector<double> run_of(const file::Results& results, const ShapeLoop::Angle& angle) {
  std::vector<double> run;
  for (const auto& node : results.solution.joint_angle) {
    double value = node[angle.joint][angle.axis];
    if (!run.empty()) value += 2.0 * std::numbers::pi * std::round((run.back() - value) / (2.0 * std::numbers::pi));
    run.push_back(value);
  }
  return run;
}

// One rectangle for both with the same scale along its sides.
mechanics::ShapePlane plane_around(const std::array<ShapeLoop::Angle, 2>& angle,
                                   const std::array<std::vector<double>, 2>& run) {
  mechanics::ShapePlane plane;
  double reach = least_reach;
  std::array<double, 2> middle{};
  for (std::size_t n = 0; n < 2; ++n) {
    const auto [low, high] = std::minmax_element(run[n].begin(), run[n].end());
    middle[n] = 0.5 * (*low + *high);
    reach = std::max(reach, 0.5 * reach_margin * (*high - *low));
  }
  for (std::size_t n = 0; n < 2; ++n)
    plane.angle[n] = {static_cast<int>(angle[n].joint), angle[n].axis, middle[n] - reach, middle[n] + reach};
  plane.points = 31;
  return plane;
}

double largest_norm(const maneuver::Vectors& vectors) {
  double most = 0.0;
  for (const Eigen::Vector3d& v : vectors) most = std::max(most, v.norm());
  return most;
}

// Nothing is carried along but by shapes.
bool without_momentum(const maneuver::Solution& solution) {
  return largest_norm(solution.linear_momentum.total) <= at_rest * largest_norm(solution.linear_momentum.bodies) &&
         largest_norm(solution.angular_momentum.total) <= at_rest * largest_norm(solution.angular_momentum.bodies);
}

// The root's, seen from where it began; its heading without the jumps of whole turns.
Planar displacement_of_root(const maneuver::Solution& solution, int normal) {
  const Eigen::Matrix3d first = solution.rotation.front()[0];
  double heading = 0.0;
  for (std::size_t k = 1; k < solution.rotation.size(); ++k)
    heading += lie::log(Eigen::Matrix3d(solution.rotation[k - 1][0].transpose() * solution.rotation[k][0]))[normal];
  const Eigen::Vector3d shift = first.transpose() * (solution.position.back() - solution.position.front());
  return {shift[(normal + 1) % 3], shift[(normal + 2) % 3], heading};
}

}  // namespace

std::optional<ShapeLoop> shape_loop(const file::Results& results) {
  const std::vector<ShapeLoop::Angle> turning = turning_angles(results);
  if (turning.size() != 2) return std::nullopt;
  ShapeLoop loop;
  std::array<std::vector<double>, 2> run;
  for (std::size_t n = 0; n < 2; ++n) {
    loop.angle[n] = turning[n];
    run[n] = run_of(results, turning[n]);
  }
  const model::System system(file::problem_of(results).swimmer);
  std::optional<mechanics::HeightFunctions> heights =
      mechanics::height_functions(system, plane_around(loop.angle, run));
  if (!heights) return std::nullopt;
  loop.heights = std::move(*heights);
  const bool closes =
      std::abs(run[0].back() - run[0].front()) <= closed && std::abs(run[1].back() - run[1].front()) <= closed;
  if (!closes || !without_momentum(results.solution)) return loop;
  std::vector<std::array<double, 2>> polygon;
  for (std::size_t k = 0; k < run[0].size(); ++k) polygon.push_back({run[0][k], run[1][k]});
  loop.displacement = ShapeLoop::Displacement{
      mechanics::volume_over(loop.heights, polygon),
      mechanics::displacement_of_frame(mechanics::frame_at(loop.heights, run[0].front(), run[1].front()),
                                       displacement_of_root(results.solution, loop.heights.normal))};
  return loop;
}

}  // namespace lamprey::report
