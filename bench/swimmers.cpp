#include "swimmers.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "lie/so3.hpp"
#include "maneuver/simulate.hpp"
#include "search/solve.hpp"

namespace lamprey::bench {

namespace {

using Eigen::Vector3d;

constexpr double density = 0.00994718394324346;  // kg/m³
const Vector3d e3(0.0, 0.0, 1.0);

model::BodyDescription body(const std::string& name, const Vector3d& axes, const Vector3d& M, const Vector3d& J) {
  model::BodyDescription described;
  described.name = name;
  described.semi_axes = axes;
  described.mass_matrix = M.asDiagonal();
  described.inertia_matrix = J.asDiagonal();
  return described;
}

model::BodyDescription outer_body(const std::string& name) {
  return body(name, {5.0, 0.8, 1.5}, {0.2664, 0.6551, 0.3677}, {0.1961, 1.7889, 2.9210});
}

model::JointDescription joint(const std::string& parent, const std::string& child, double parent_x, double child_x) {
  model::JointDescription described;
  described.name = child;
  described.parent = parent;
  described.child = child;
  described.parent_offset = Vector3d(parent_x, 0.0, 0.0);
  described.child_offset = Vector3d(child_x, 0.0, 0.0);
  return described;
}

maneuver::Problem maneuver_of_the_paper(bool planar, int steps) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain(planar);
  problem.start.rotation = {Vector3d::Zero(), Vector3d::Zero(), 0.25 * std::numbers::pi * e3};
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.goal = maneuver::Goal();
  problem.steps = steps;
  return problem;
}

// Moments of a few hundred N m about e_3 and some out of the plane, each joint in its own phase.
mechanics::Moments moments_at(const model::System& system, double t) {
  mechanics::Moments u;
  for (int j = 0; j < system.joint_count(); ++j) {
    const double phase = 2.0 * std::numbers::pi * t + j;
    u.emplace_back(Vector3d(5.0 * std::sin(3.0 * phase), 100.0 * std::cos(2.0 * phase), 300.0 * std::sin(phase)));
  }
  return u;
}

}  // namespace

model::SwimmerDescription paper_chain(bool planar) {
  model::SwimmerDescription chain;
  chain.density = density;
  chain.bodies = {body("middle", {8.0, 1.5, 2.0}, {1.0659, 2.1696, 1.6641}, {1.3480, 20.15, 25.3276}),
                  outer_body("front"), outer_body("back")};
  chain.joints = {joint("middle", "front", 8.8, -5.5), joint("middle", "back", -8.8, 5.5)};
  if (planar)
    for (model::JointDescription& j : chain.joints) j.control_axes = {e3};
  return chain;
}

model::SwimmerDescription outer_body_chain(int bodies) {
  model::SwimmerDescription chain;
  chain.density = density;
  for (int i = 0; i < bodies; ++i) {
    chain.bodies.push_back(outer_body(std::to_string(i)));
    if (i > 0) chain.joints.push_back(joint(std::to_string(i - 1), std::to_string(i), 5.5, -5.5));
  }
  return chain;
}

maneuver::Problem translation(int steps, bool planar) {
  maneuver::Problem problem = maneuver_of_the_paper(planar, steps);
  problem.goal->move[0] = 2.0;
  problem.goal->turn = Vector3d::Zero();
  return problem;
}

maneuver::Problem rotation(int steps) {
  maneuver::Problem problem = maneuver_of_the_paper(false, steps);
  problem.goal->turn = Vector3d(std::numbers::pi, 0.0, 0.0);
  return problem;
}

integrator::State rest(const model::System& system) {
  mechanics::Rotations R(static_cast<std::size_t>(system.body_count()), Eigen::Matrix3d::Identity());
  if (system.body_count() == 3) R[2] = lie::exp(0.25 * std::numbers::pi * e3);
  return integrator::state_of_velocity(system, R, Vector3d::Zero(), Eigen::VectorXd::Zero(system.velocity_count()));
}

March::March(const model::SwimmerDescription& swimmer, mechanics::DiscreteLagrangian lagrangian_, int steps)
    : system(swimmer), lagrangian(lagrangian_), start(rest(system)) {
  for (int k = 0; k <= steps; ++k) moments.push_back(moments_at(system, k * time_step));
}

March rotation_march() {
  March march(paper_chain(), mechanics::DiscreteLagrangian::trapezoid);
  march.moments = search::solve(march.system, rotation(1000), search::SolveOptions()).front().control;
  return march;
}

maneuver::Solution marched(const model::System& system, const maneuver::Problem& problem) {
  maneuver::Solution solution = maneuver::simulate(
      system, problem, [&system](double t) { return moments_at(system, t); }, [] { return false; });
  solution.status = maneuver::Status::feasible;
  return solution;
}

}  // namespace lamprey::bench
