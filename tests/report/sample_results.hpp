// A made-up result in the shape of a solved maneuver: the three-body chain folds, turns and straightens. Its numbers are
// smooth and consistent in shape, but obey no equation of motion.
#pragma once

#include <cmath>
#include <numbers>

#include "lie/so3.hpp"
#include "result/results.hpp"

namespace lamprey::tests {

inline result::ResolvedBody sample_body(const std::string& name, const Eigen::Vector3d& semi_axes, double mass) {
  const Eigen::Vector3d squares = semi_axes.cwiseProduct(semi_axes);
  const Eigen::Vector3d inertia = mass / 5.0 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
  const Eigen::Matrix3d body_inertia = inertia.asDiagonal();
  const Eigen::Matrix3d mass_matrix = Eigen::Vector3d(1.07 * mass, 2.17 * mass, 1.66 * mass).asDiagonal();
  return {name, semi_axes, mass, body_inertia, mass_matrix, 1.7 * body_inertia};
}

inline result::ResolvedProblem sample_problem(int steps) {
  result::ResolvedProblem problem;
  problem.bodies = {sample_body("middle", {8.0, 1.5, 2.0}, 1.0), sample_body("front", {5.0, 0.8, 1.5}, 0.25),
                    sample_body("rear", {5.0, 0.8, 1.5}, 0.25)};
  const std::vector<Eigen::Vector3d> all = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                            Eigen::Vector3d::UnitZ()};
  problem.joints = {{"front", model::JointKind::ball, 0, 1, {8.8, 0.0, 0.0}, {-5.5, 0.0, 0.0}, all},
                    {"rear", model::JointKind::ball, 0, 2, {-8.8, 0.0, 0.0}, {5.5, 0.0, 0.0}, all}};
  problem.density = 0.00994718394324346;
  problem.duration = 1.0;
  problem.steps = steps;
  problem.time_step = 1.0 / steps;
  problem.goal = maneuver::Goal{};
  problem.goal->turn = Eigen::Vector3d(std::numbers::pi, 0.0, 0.0);
  problem.goal->move[0] = 2.0;
  return problem;
}

inline void add_sample_node(maneuver::Solution& solution, double t) {
  constexpr double pi = std::numbers::pi;
  const double ramp = t - std::sin(2.0 * pi * t) / (2.0 * pi), bump = 1.0 - std::cos(2.0 * pi * t),
               wave = std::sin(2.0 * pi * t);
  const Eigen::Matrix3d root = lie::exp({pi * ramp, 0.0, 0.0}) * lie::exp({0.0, 0.12 * bump, 0.2 * wave});
  solution.time.push_back(t);
  solution.position.emplace_back(2.0 * ramp, 0.9 * wave, 0.4 * bump);
  solution.joint_angle.push_back(
      {{0.4 * wave, -0.35 * bump, 0.55 * bump + 0.2 * wave}, {-0.4 * wave, 0.3 * bump, 0.6 * bump - 0.3 * wave}});
  solution.rotation.push_back(
      {root, root * lie::exp(solution.joint_angle.back()[0]), root * lie::exp(solution.joint_angle.back()[1])});
  const Eigen::Vector3d moment(40.0 * std::cos(3.0 * pi * t), -120.0 * std::sin(4.0 * pi * t),
                               267.0 * std::cos(2.0 * pi * t));
  solution.control.push_back({moment, Eigen::Vector3d(0.3 * moment.y(), moment.z(), -0.8 * moment.x())});
  solution.linear_velocity.emplace_back(2.0 * bump, 4.0 * wave, -1.5 * wave * bump);
  const Eigen::Vector3d spin(pi * bump, 1.2 * wave, -2.0 * wave * bump);
  solution.angular_velocity.push_back(
      {spin, spin + Eigen::Vector3d(2.0 * wave, 1.0, 3.0 * wave), spin - Eigen::Vector3d(wave, 2.0 * bump, 0.0)});
  const Eigen::Vector3d linear(3.0 * bump, 2.0 * wave, 0.5 * wave * bump),
      angular(1.25 * bump, -6.0 * wave, 9.0 * wave * bump);
  const Eigen::Vector3d noise = 1e-14 * Eigen::Vector3d(std::sin(900.0 * t), std::cos(700.0 * t), std::sin(500.0 * t));
  solution.linear_momentum.bodies.push_back(linear);
  solution.linear_momentum.fluid.push_back(noise - linear);
  solution.linear_momentum.total.push_back(noise);
  solution.angular_momentum.bodies.push_back(angular);
  solution.angular_momentum.fluid.push_back(noise - angular);
  solution.angular_momentum.total.push_back(noise);
}

inline void add_sample_search(maneuver::Solution& solution) {
  solution.search = {60, 0, 0, 59, {{13355.11, 5}, {13385.8, 3}, {13558.0, 4}, {14043.6, 2}, {28315.5, 1}}};
  solution.solver = {"structured interior point", 18, 41, 0.934, 1.2, 0.9, {}, {}, {}};
  for (int k = 0; k <= 18; ++k) {
    solution.solver.history.push_back({k, 13396.4 * (1.0 + 40.0 * std::exp(-0.6 * k)), 3.0 * std::exp(-0.08 * k * k),
                                       0.8 * std::exp(-0.065 * k * k), k == 0 ? 0.0 : 1.0, 1e-14});
  }
}

inline certificate::Certificate sample_certificate() {
  certificate::Certificate proof;
  proof.goal_error = 3.1e-12;
  proof.rest_error = 4.4e-13;
  proof.momentum_drift = 2.2e-14;
  proof.rotation_drift = 8.9e-16;
  proof.clearance = evidence::Clearance{0.519, 0.42, 0, 1};
  proof.kkt = 6.3e-10;
  proof.second_order = optimality::SecondOrder{0.0312, true};
  proof.replay = certificate::Replay{"order 8 Runge–Kutta", 0.05, 8.4e-5, 3.9e-4, 1.2, 3.1, 29.2};
  return proof;
}

inline result::Results sample_results(int steps = 1000) {
  result::Results results;
  results.name = "Rotation about the long axis";
  results.source = "Lee, Leok, McClamroch 2009, maneuver (ii)";
  results.problem = sample_problem(steps);
  results.solution.status = maneuver::Status::optimal;
  results.solution.message = "The maneuver reaches its goal and no nearby maneuver is cheaper.";
  results.solution.cost = 213396.4012345;
  for (int k = 0; k <= steps; ++k) add_sample_node(results.solution, static_cast<double>(k) / steps);
  add_sample_search(results.solution);
  results.certificate = sample_certificate();
  results.provenance = {"0.1.0",
                        "Release",
                        "GCC 12.2.0",
                        "a processor, 2 cores",
                        "lamprey solve rotation.toml --out runs/rotation",
                        "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
                        1};
  return results;
}

inline result::Results simulated_results(int steps = 200) {
  result::Results results = sample_results(steps);
  results.name = "Free tumbling";
  results.problem.goal.reset();
  results.certificate.reset();
  results.solution.status = maneuver::Status::simulated;
  results.solution.message = "Marched 200 steps with no control.";
  results.solution.cost = std::numeric_limits<double>::quiet_NaN();
  results.solution.search = {};
  results.solution.solver = {};
  return results;
}

}  // namespace lamprey::tests
