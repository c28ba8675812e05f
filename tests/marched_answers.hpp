// Answers made by marching under given moments: they satisfy the discrete equations by construction, and reach no goal
// by plan.
#pragma once

#include <gtest/gtest.h>

#include "chains.hpp"
#include "evidence/stored_motion.hpp"
#include "integrator/march.hpp"
#include "maneuver/simulate.hpp"
#include "maneuver/step_polynomial.hpp"
#include "mechanics/connection.hpp"

namespace lamprey::tests {

// A chain with a hinge that has a spring and a damper, a universal joint, a ball joint with a spring.
inline model::SwimmerDescription swimmer_of_mixed_joints() {
  Random random(3);
  model::SwimmerDescription swimmer = random_tree(random, 4);
  for (std::size_t j = 0; j < 3; ++j) swimmer.joints[j].parent = "body" + std::to_string(j);
  model::JointDescription& hinge = swimmer.joints[0];
  hinge.kind = model::JointKind::hinge;
  hinge.axis = random.vector();
  hinge.stiffness = 3.0;
  hinge.damping = 0.5;
  model::JointDescription& universal = swimmer.joints[1];
  universal.kind = model::JointKind::universal;
  universal.axes = {Vector3d(0, 1, 0), Vector3d(0, 0, 1)};
  swimmer.joints[2].stiffness = 2.0;
  return swimmer;
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct MarchedAnswer {
  maneuver::Problem problem;
  maneuver::Solution solution;
};

/// A problem for the paper's chain in its start shape, with every end rotation and a displacement asked for.
inline maneuver::Problem chain_problem(int steps, double duration) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain();
  problem.start.rotation = {Vector3d::Zero(), Vector3d::Zero(), Vector3d(0, 0, M_PI / 4)};
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.steps = steps;
  problem.duration.value = duration;
  problem.goal = maneuver::Goal{};
  problem.goal->turn = Vector3d(0.3, -0.2, 0.5);
  problem.goal->move = {0.4, std::nullopt, std::nullopt};
  return problem;
}

using NodeMoments = std::vector<mechanics::Moments>;

/// A tree with joints of every kind, springs, dampers and coupled inertia, in motion under smooth moments.
inline MarchedAnswer any_tree(unsigned seed, integrator::Scheme scheme, int steps = 100, bool adaptive = false) {
  Random random(seed);
  MarchedAnswer answer;
  maneuver::Problem& problem = answer.problem;
  problem.swimmer = random_swimmer(random, 6);
  problem.steps = steps;
  problem.duration.value = 0.5;
  problem.scheme = scheme;
  const model::System system(problem.swimmer);
  const mechanics::Rotations rotation = random_rotations(random, system);
  for (const Matrix3d& R : rotation) problem.start.rotation.push_back(lie::log(R));
  VectorXd velocity;
  mechanics::pack(system, random_freedoms(random, system, 0.5), random.vector(0.3), velocity);
  problem.start.angular_velocity = mechanics::angular_velocities(system, rotation, velocity);
  problem.start.linear_velocity = velocity.tail<3>();
  problem.start.position = random.vector(0.2);
  const mechanics::Moments even = random_moments(random, system, 1.0), odd = random_moments(random, system, 1.0);
  const auto control = [&](double t) {
    mechanics::Moments u = even;
    for (std::size_t j = 0; j < u.size(); ++j) u[j] = std::cos(6.0 * t) * even[j] + std::sin(5.0 * t) * odd[j];
    return u;
  };
  answer.solution = maneuver::simulate(system, problem, control, maneuver::SimulateOptions{adaptive, {}});
  return answer;
}

/// Smooth moments of about `size` N m at the nodes; about e_3 alone when `planar`.
inline NodeMoments smooth_moments(int steps, double size, bool planar = false) {
  NodeMoments moments;
  for (int k = 0; k <= steps; ++k) {
    const double t = double(k) / steps;
    mechanics::Moments u(2);
    for (std::size_t j = 0; j < 2; ++j) {
      const double phase = 1.3 * double(j);
      u[j] =
          size * Vector3d(0.05 * std::sin(7.0 * t + phase), std::cos(5.0 * t - phase), std::sin(6.0 * t + 2.0 * phase));
      if (planar) u[j].head<2>().setZero();
    }
    moments.push_back(u);
  }
  return moments;
}

/// Moments along the joints at nodes 0 … last from those along Joint::actuation, [controls · (last + 1)].
inline NodeMoments moments_along_joints(const model::System& system, const VectorXd& value, int last) {
  NodeMoments moments;
  Eigen::Index first = 0;
  for (int k = 0; k <= last; ++k) {
    moments.emplace_back();
    for (const model::Joint& joint : system.joints()) {
      moments.back().push_back(joint.actuation * value.segment(first, joint.actuation.cols()));
      first += joint.actuation.cols();
    }
  }
  return moments;
}

inline MarchedAnswer march(const maneuver::Problem& problem, const NodeMoments& moments) {
  const model::System system(problem.swimmer);
  MarchedAnswer answer{problem, {}};
  maneuver::Solution& solution = answer.solution;
  solution.status = maneuver::Status::optimal;
  integrator::State state = evidence::start_of(system, problem.start);
  integrator::StepWorkspace work(system);
  for (int k = 0; k <= problem.steps; ++k) {
    const auto n = static_cast<std::size_t>(k);
    solution.time.push_back(k * problem.time_step());
    solution.position.push_back(state.position);
    solution.rotation.push_back(state.rotation);
    solution.control.push_back(mechanics::applied_moments(system, state.rotation, moments[n]));
    if (k == problem.steps) break;
    const auto report = integrator::advance(system, integrator::lagrangian_of(problem.scheme), problem.time_step(),
                                            moments[n], moments[n + 1], state, work);
    EXPECT_TRUE(report.converged) << "step " << k;
  }
  return answer;
}

/// By a scheme above order 2, from the coefficients of the steps' polynomials, [terms · controls · N].
inline MarchedAnswer march_stages(const maneuver::Problem& problem, const VectorXd& coefficients) {
  const model::System system(problem.swimmer);
  MarchedAnswer answer{problem, {}};
  maneuver::Solution& solution = answer.solution;
  solution.status = maneuver::Status::optimal;
  integrator::State state = evidence::start_of(system, problem.start);
  integrator::March march(system, problem.scheme);
  const int terms = maneuver::polynomial_terms(problem.scheme);
  const Eigen::Index inputs = terms * system.control_count();
  for (int k = 0; k <= problem.steps; ++k) {
    const VectorXd velocity = integrator::velocity_of_state(system, state);
    solution.time.push_back(k * problem.time_step());
    solution.position.push_back(state.position);
    solution.rotation.push_back(state.rotation);
    solution.angular_velocity.push_back(mechanics::angular_velocities(system, state.rotation, velocity));
    solution.linear_velocity.emplace_back(state.rotation[0].transpose() * velocity.tail<3>());
    solution.control.emplace_back(static_cast<std::size_t>(system.joint_count()), Vector3d::Zero());
    if (k == problem.steps) break;
    NodeMoments moments;
    for (double fraction : maneuver::stage_fractions(problem.scheme))
      moments.push_back(moments_along_joints(
          system, maneuver::moments_at(coefficients.segment(inputs * k, inputs), fraction, terms), 0)[0]);
    auto& applied = solution.control_stages.emplace_back();
    applied.push_back(mechanics::applied_moments(system, state.rotation, moments[0]));
    const auto report = march.advance(
        problem.time_step(),
        [&](int node) -> const mechanics::Moments& { return moments[static_cast<std::size_t>(node)]; }, state,
        [&](const mechanics::Interval&, const integrator::State& there) {
          applied.push_back(mechanics::applied_moments(system, there.rotation, moments[applied.size()]));
        });
    EXPECT_TRUE(report.converged) << "step " << k;
  }
  return answer;
}

/// Joints that turn at the start, rad/s, and no total momentum.
inline void bend_at_start(maneuver::Problem& problem, const mechanics::Vectors& rates) {
  const model::System system(problem.swimmer);
  const integrator::State start = evidence::start_of(system, problem.start);
  const Eigen::VectorXd velocity = mechanics::velocity_of_rates(system, start.rotation, start.position, rates, {});
  problem.start.angular_velocity = mechanics::angular_velocities(system, start.rotation, velocity);
  problem.start.linear_velocity = velocity.tail<3>();
}

}  // namespace lamprey::tests
