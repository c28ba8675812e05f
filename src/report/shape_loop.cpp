#include "report/shape_loop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "lie/so3.hpp"
#include "model/system.hpp"
#include "model/world_axes.hpp"
#include "result/resolve.hpp"

namespace lamprey::report {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mechanics::Planar;

constexpr double held_still = 1e-7;                   // rad: less is round-off of an angle that is held
constexpr double most_turn = 0.9 * std::numbers::pi;  // rad, of the root in a loop
constexpr double closed = 1e-6;                       // rad, between the first shape and the last
constexpr double at_rest = 1e-8;                      // total momentum beside what the bodies carry
constexpr double plane_margin = 1.25;                 // of the motion's reach, how far the rectangle goes
constexpr double least_reach = 0.05;                  // rad
constexpr double apart = 0.2;                         // rad, the most between two nodes
constexpr int least_points = 31, most_points = 91;
constexpr std::size_t most_bodies = 100;  // of more the picture would take longer than the rest of the page

struct Angle {
  std::size_t joint;
  int axis;
};

// An angle along the nodes, without the jumps of whole turns.
VectorXd run_of(const result::Results& results, const Angle& angle) {
  const auto& nodes = results.solution.joint_angle;
  VectorXd run(static_cast<Eigen::Index>(nodes.size()));
  for (Eigen::Index k = 0; k < run.size(); ++k) {
    const double value = nodes[static_cast<std::size_t>(k)][angle.joint][angle.axis];
    const double turns = k == 0 ? 0.0 : std::round((run[k - 1] - value) / (2.0 * std::numbers::pi));
    run[k] = value + 2.0 * std::numbers::pi * turns;
  }
  return run;
}

// The angles that change, along the nodes, and where all the others stand.
struct Shapes {
  std::vector<Angle> angle;
  MatrixXd run;            // [N + 1][angles] rad
  maneuver::Vectors held;  // [joints][3] rad, zero of those that change
};

Shapes shapes_of(const result::Results& results) {
  Shapes shapes;
  const std::size_t joints = results.problem.joints.size();
  shapes.held.assign(joints, Eigen::Vector3d::Zero());
  if (results.solution.joint_angle.empty()) return shapes;
  std::vector<VectorXd> runs;
  for (std::size_t j = 0; j < joints; ++j)
    for (int axis = 0; axis < model::freedoms_of(results.problem.joints[j].kind); ++axis) {
      const VectorXd run = run_of(results, {j, axis});
      if (!run.allFinite()) return {};
      if (!(run.maxCoeff() - run.minCoeff() > held_still)) {
        shapes.held[j][axis] = std::abs(run.mean()) > held_still ? run.mean() : 0.0;
        continue;
      }
      shapes.angle.push_back({j, axis});
      runs.push_back(run);
    }
  shapes.run.resize(static_cast<Eigen::Index>(results.solution.joint_angle.size()),
                    static_cast<Eigen::Index>(runs.size()));
  for (std::size_t a = 0; a < runs.size(); ++a) shapes.run.col(static_cast<Eigen::Index>(a)) = runs[a];
  return shapes;
}

std::string name_of(const result::Results& results, const Angle& angle) {
  const result::ResolvedJoint& joint = results.problem.joints[angle.joint];
  if (joint.kind == model::JointKind::ball)
    return joint.name + " about " + model::world_axes[static_cast<std::size_t>(angle.axis)];
  if (joint.kind == model::JointKind::universal)
    return joint.name + " " + std::array{"θ₁", "θ₂", ""}[static_cast<std::size_t>(angle.axis)];
  return joint.name;
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

void add_turns(const std::vector<Angle>& angles, const VectorXd& value, mechanics::Vectors& turns) {
  for (std::size_t a = 0; a < angles.size(); ++a)
    turns[angles[a].joint][angles[a].axis] += value[static_cast<Eigen::Index>(a)];
}

// One rectangle with the same scale along its sides.
mechanics::ShapePlane rectangle_around(const Shapes& shapes, const NearestPlane& nearest,
                                       const std::array<std::vector<double>, 2>& run) {
  mechanics::ShapePlane plane;
  plane.middle = shapes.held;
  add_turns(shapes.angle, nearest.middle, plane.middle);
  double reach = least_reach;
  std::array<double, 2> middle{};
  for (std::size_t n = 0; n < 2; ++n) {
    plane.direction[n].assign(shapes.held.size(), Eigen::Vector3d::Zero());
    add_turns(shapes.angle, nearest.direction.col(static_cast<Eigen::Index>(n)), plane.direction[n]);
    const auto [low, high] = std::minmax_element(run[n].begin(), run[n].end());
    middle[n] = 0.5 * (*low + *high);
    reach = std::max(reach, 0.5 * plane_margin * (*high - *low));
  }
  for (std::size_t n = 0; n < 2; ++n) {
    plane.low[n] = middle[n] - reach;
    plane.high[n] = middle[n] + reach;
  }
  plane.points = std::max(least_points, static_cast<int>(std::min(2.0 * reach / apart, 1e6)) + 2);
  return plane;
}

double largest_norm(const maneuver::Vectors& vectors) {
  double most = 0.0;
  for (const Eigen::Vector3d& v : vectors) most = std::max(most, v.norm());
  return most;
}

// Nothing is carried along but by shapes: total momentum is none beside what all bodies would have at the largest velocities.
bool without_momentum(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  double mass = 0.0, reach = largest_norm(solution.position), turning = 0.0;
  for (const result::ResolvedBody& body : results.problem.bodies) {
    mass += body.mass_matrix.trace();
    reach += 2.0 * body.semi_axes.maxCoeff();
  }
  for (const auto& node : solution.angular_velocity) turning = std::max(turning, largest_norm(node));
  const double momentum = mass * (largest_norm(solution.linear_velocity) + reach * turning);
  return largest_norm(solution.linear_momentum.total) <= at_rest * momentum &&
         largest_norm(solution.angular_momentum.total) <= at_rest * momentum * reach;
}

// The root's at each node, seen from where it began; its heading without the jumps of whole turns.
std::vector<Planar> displacement_of_root(const maneuver::Solution& solution, int normal) {
  const Eigen::Matrix3d first = solution.rotation.front()[0];
  std::vector<Planar> moved;
  double heading = 0.0;
  for (std::size_t k = 0; k < solution.rotation.size(); ++k) {
    if (k > 0)
      heading += lie::log(Eigen::Matrix3d(solution.rotation[k - 1][0].transpose() * solution.rotation[k][0]))[normal];
    const Eigen::Vector3d shift = first.transpose() * (solution.position[k] - solution.position.front());
    moved.emplace_back(shift[(normal + 1) % 3], shift[(normal + 2) % 3], heading);
  }
  return moved;
}

ShapeLoop::Displacement displacement_of(const std::vector<Planar>& root, const ShapeLoop& loop) {
  std::vector<std::array<double, 2>> polygon;
  for (std::size_t k = 0; k < loop.run[0].size(); ++k) polygon.push_back({loop.run[0][k], loop.run[1][k]});
  const auto frame = [&](std::size_t k) { return mechanics::frame_at(loop.heights, polygon[k][0], polygon[k][1]); };
  const Planar first = frame(0), twist = mechanics::twist_of_frame(first, root.back());
  Planar sum = Planar::Zero();  // begun at each node but the last, which is the first again
  for (std::size_t k = 0; k + 1 < root.size(); ++k)
    sum += mechanics::seen_along(twist, mechanics::frame_moved(first, root[k], frame(k)));
  return {mechanics::volume_over(loop.heights, polygon), sum / static_cast<double>(root.size() - 1)};
}

// What would be there in some frame or other: heights far below it are round-off.
Planar scale_of(const mechanics::HeightFunctions& heights) {
  double shift = 0.0, turn = 0.0;
  for (Eigen::Index i = 0; i < heights.height[0].rows(); ++i)
    for (Eigen::Index j = 0; j < heights.height[0].cols(); ++j) {
      const double own = std::hypot(heights.height[0](i, j), heights.height[1](i, j));
      const double lever = std::hypot(heights.frame[0](i, j), heights.frame[1](i, j));
      turn = std::max(turn, std::abs(heights.height[2](i, j)));
      shift = std::max(shift, own + std::abs(heights.height[2](i, j)) * lever);
    }
  return {shift, shift, std::max(turn, 1.0)};
}

// Heights that are round-off beside those are none.
void clear_round_off(mechanics::HeightFunctions& heights) {
  constexpr double round_off = 1e-4;  // with what the grid leaves of the frame
  const Planar scale = scale_of(heights);
  for (std::size_t k = 0; k < 3; ++k)
    if (heights.height[k].cwiseAbs().maxCoeff() <= round_off * scale[static_cast<Eigen::Index>(k)])
      heights.height[k].setZero();
}

// Why a run of shapes goes round no area; empty: it does.
std::string why_open(const result::Results& results, const Shapes& shapes) {
  std::string round;
  for (std::size_t n = 0; n < shapes.angle.size(); ++n) {
    const auto run = shapes.run.col(static_cast<Eigen::Index>(n));
    const double turned = run[run.size() - 1] - run[0];
    if (std::abs(std::remainder(turned, 2.0 * std::numbers::pi)) > closed) return "the shape does not end as it began";
    if (std::abs(turned) > closed && round.empty()) round = name_of(results, shapes.angle[n]);
  }
  if (round.empty()) return "";
  return "the shape ends as it began, but " + round + " goes right round, and such a loop bounds no area";
}

}  // namespace

std::optional<ShapeLoop> shape_loop(const result::Results& results) {
  if (results.problem.bodies.size() > most_bodies) return std::nullopt;
  const Shapes shapes = shapes_of(results);
  if (shapes.angle.size() < 2) return std::nullopt;
  const NearestPlane plane = nearest_plane(shapes.run);
  ShapeLoop loop;
  const Eigen::MatrixX2d variables = (shapes.run.rowwise() - plane.middle.transpose()) * plane.direction;
  for (std::size_t n = 0; n < 2; ++n) {
    const auto column = variables.col(static_cast<Eigen::Index>(n));
    loop.run[n].assign(column.begin(), column.end());
    loop.variable[n] = shapes.angle.size() == 2 ? name_of(results, shapes.angle[n]) : std::array{"s₁", "s₂"}[n];
  }
  const model::System system(result::problem_of(results).swimmer);
  const mechanics::ShapePlane rectangle = rectangle_around(shapes, plane, loop.run);
  if (rectangle.points > most_points) return std::nullopt;
  std::optional<mechanics::HeightFunctions> heights = mechanics::height_functions(system, rectangle);
  if (!heights) return std::nullopt;
  clear_round_off(*heights);
  loop.heights = std::move(*heights);
  if (shapes.angle.size() > 2) {
    loop.modes = ShapeLoop::Modes{{}, plane.direction, plane.beside};
    for (const Angle& angle : shapes.angle) loop.modes->angle.push_back(name_of(results, angle));
  }
  const std::vector<Planar> root = displacement_of_root(results.solution, loop.heights.normal);
  loop.lacking = why_open(results, shapes);
  if (!loop.lacking.empty()) return loop;
  if (!without_momentum(results))
    loop.lacking = "total momentum carries the swimmer on";
  else if (std::abs(root.back()[2]) > most_turn)
    loop.lacking = "the swimmer turns too far for one twist";
  else
    loop.displacement = displacement_of(root, loop);
  return loop;
}

}  // namespace lamprey::report
