#include "report/shape_loop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "file/resolve.hpp"
#include "lie/so3.hpp"
#include "model/system.hpp"

namespace lamprey::report {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mechanics::Planar;

constexpr double held_still = 1e-7;    // rad: less is round-off of an angle that is held
constexpr double closed = 1e-6;        // rad, between the first shape and the last
constexpr double at_rest = 1e-8;       // total momentum beside what the bodies carry
constexpr double plane_margin = 1.25;  // of the motion's reach, how far the rectangle goes
constexpr double least_reach = 0.05;   // rad
constexpr int plane_points = 31;
constexpr std::size_t most_bodies = 100;  // of more the picture would take longer than the rest of the page

struct Angle {
  std::size_t joint;
  int axis;
};

// The angles that turn at all.
std::vector<Angle> turning_angles(const file::Results& results) {
  std::vector<Angle> turning;
  const auto& angles = results.solution.joint_angle;
  for (std::size_t j = 0; j < results.problem.joints.size() && !angles.empty(); ++j)
    for (int axis = 0; axis < 3; ++axis)
      if (std::any_of(angles.begin(), angles.end(),
                      [&](const auto& node) { return std::abs(node[j][axis]) > held_still; }))
        turning.push_back({j, axis});
  return turning;
}

std::string name_of(const file::Results& results, const Angle& angle) {
  const file::ResolvedJoint& joint = results.problem.joints[angle.joint];
  if (joint.kind == model::JointKind::ball)
    return joint.name + " about " + std::array{"e₁", "e₂", "e₃"}[static_cast<std::size_t>(angle.axis)];
  if (joint.kind == model::JointKind::universal)
    return joint.name + " " + std::array{"θ₁", "θ₂", ""}[static_cast<std::size_t>(angle.axis)];
  return joint.name;
}

// Angles along the nodes, without the jumps of whole turns: [N + 1][angles] rad.
MatrixXd runs_of(const file::Results& results, const std::vector<Angle>& angles) {
  const auto& nodes = results.solution.joint_angle;
  MatrixXd runs(static_cast<Eigen::Index>(nodes.size()), static_cast<Eigen::Index>(angles.size()));
  for (Eigen::Index a = 0; a < runs.cols(); ++a)
    for (Eigen::Index k = 0; k < runs.rows(); ++k) {
      const Angle& angle = angles[static_cast<std::size_t>(a)];
      const double value = nodes[static_cast<std::size_t>(k)][angle.joint][angle.axis];
      const double turns = k == 0 ? 0.0 : std::round((runs(k - 1, a) - value) / (2.0 * std::numbers::pi));
      runs(k, a) = value + 2.0 * std::numbers::pi * turns;
    }
  return runs;
}

// A plane of shapes, angles = middle + directions · variables, and where the motion is beside it.
struct NearestPlane {
  VectorXd middle;             // [angles]
  Eigen::MatrixX2d direction;  // [angles][2]
  double beside = 0.0;         // rad
};

// Of two angles themselves; of more the directions in which the shapes vary most.
NearestPlane nearest_plane(const MatrixXd& runs) {
  const Eigen::Index angles = runs.cols();
  NearestPlane plane{VectorXd::Zero(angles), Eigen::MatrixX2d::Identity(angles, 2)};
  if (angles == 2) return plane;
  plane.middle = runs.colwise().mean().transpose();
  const MatrixXd about = runs.rowwise() - plane.middle.transpose();
  const MatrixXd spread = about.transpose() * about;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> main(spread);
  for (Eigen::Index n = 0; n < 2; ++n) {
    plane.direction.col(n) = main.eigenvectors().col(angles - 1 - n);
    Eigen::Index most = 0;
    plane.direction.col(n).cwiseAbs().maxCoeff(&most);
    if (plane.direction(most, n) < 0.0) plane.direction.col(n) *= -1.0;
  }
  const MatrixXd left = about - about * plane.direction * plane.direction.transpose();
  plane.beside = left.cwiseAbs().maxCoeff();
  return plane;
}

mechanics::Vectors turns_of(std::size_t joints, const std::vector<Angle>& angles, const VectorXd& value) {
  mechanics::Vectors turns(joints, Eigen::Vector3d::Zero());
  for (std::size_t a = 0; a < angles.size(); ++a)
    turns[angles[a].joint][angles[a].axis] = value[static_cast<Eigen::Index>(a)];
  return turns;
}

// One rectangle with the same scale along its sides.
mechanics::ShapePlane rectangle_around(std::size_t joints, const std::vector<Angle>& angles,
                                       const NearestPlane& nearest, const std::array<std::vector<double>, 2>& run) {
  mechanics::ShapePlane plane;
  plane.middle = turns_of(joints, angles, nearest.middle);
  double reach = least_reach;
  std::array<double, 2> middle{};
  for (std::size_t n = 0; n < 2; ++n) {
    plane.direction[n] = turns_of(joints, angles, nearest.direction.col(static_cast<Eigen::Index>(n)));
    const auto [low, high] = std::minmax_element(run[n].begin(), run[n].end());
    middle[n] = 0.5 * (*low + *high);
    reach = std::max(reach, 0.5 * plane_margin * (*high - *low));
  }
  for (std::size_t n = 0; n < 2; ++n) {
    plane.low[n] = middle[n] - reach;
    plane.high[n] = middle[n] + reach;
  }
  plane.points = plane_points;
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

ShapeLoop::Displacement displacement_of(const maneuver::Solution& solution, const ShapeLoop& loop) {
  std::vector<std::array<double, 2>> polygon;
  for (std::size_t k = 0; k < loop.run[0].size(); ++k) polygon.push_back({loop.run[0][k], loop.run[1][k]});
  return {mechanics::volume_over(loop.heights, polygon),
          mechanics::displacement_of_frame(mechanics::frame_at(loop.heights, polygon.front()[0], polygon.front()[1]),
                                           displacement_of_root(solution, loop.heights.normal))};
}

}  // namespace

std::optional<ShapeLoop> shape_loop(const file::Results& results) {
  const std::vector<Angle> angles = turning_angles(results);
  if (angles.size() < 2 || results.problem.bodies.size() > most_bodies) return std::nullopt;
  const MatrixXd runs = runs_of(results, angles);
  const NearestPlane plane = nearest_plane(runs);
  ShapeLoop loop;
  const Eigen::MatrixX2d variables = (runs.rowwise() - plane.middle.transpose()) * plane.direction;
  for (std::size_t n = 0; n < 2; ++n) {
    const auto column = variables.col(static_cast<Eigen::Index>(n));
    loop.run[n].assign(column.begin(), column.end());
    loop.variable[n] = angles.size() == 2 ? name_of(results, angles[n]) : std::array{"s₁", "s₂"}[n];
  }
  const model::System system(file::problem_of(results).swimmer);
  std::optional<mechanics::HeightFunctions> heights =
      mechanics::height_functions(system, rectangle_around(results.problem.joints.size(), angles, plane, loop.run));
  if (!heights) return std::nullopt;
  loop.heights = std::move(*heights);
  if (angles.size() > 2) {
    loop.modes = ShapeLoop::Modes{{}, plane.direction, plane.beside};
    for (const Angle& angle : angles) loop.modes->angle.push_back(name_of(results, angle));
  }
  const bool closes = (runs.bottomRows<1>() - runs.topRows<1>()).cwiseAbs().maxCoeff() <= closed;
  if (closes && without_momentum(results.solution)) loop.displacement = displacement_of(results.solution, loop);
  return loop;
}

}  // namespace lamprey::report
