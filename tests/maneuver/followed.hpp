// Motions to follow, with what a test needs to know of them.
#pragma once

#include <gtest/gtest.h>

#include "chains.hpp"
#include "maneuver/feedback.hpp"
#include "maneuver/simulate.hpp"

namespace lamprey::tests {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using integrator::ReferenceState;

/// A swimmer in motion under moments in time.
struct Plan {
  maneuver::Problem problem;
  model::System system;
  maneuver::ControlFunction control;
  maneuver::Solution solution;

  explicit Plan(const maneuver::Problem& asked, maneuver::ControlFunction moments)
      : problem(asked), system(asked.swimmer), control(std::move(moments)) {
    solution = maneuver::simulate(system, problem, control, maneuver::SimulateOptions{});
    EXPECT_EQ(solution.status, maneuver::Status::simulated) << solution.message;
  }

  integrator::FeedbackLaw law() const { return maneuver::feedback_law(system, solution, control); }
  double time(int k) const { return solution.time[static_cast<std::size_t>(k)]; }
};

/// How a march ends under a law.
inline maneuver::Solution follow(const model::System& system, const maneuver::Problem& problem,
                                 const integrator::FeedbackLaw& law, bool reference = false,
                                 const integrator::MotorFunction& given = {}) {
  maneuver::SimulateOptions options;
  options.given = given;
  options.feedback = [&](double t, const ReferenceState& state) { return law.moments(t, state); };
  const maneuver::ControlFunction planned = [&](double t) { return law.planned(t); };
  maneuver::Solution solution = reference ? maneuver::simulate_by_reference(system, problem, planned, options)
                                          : maneuver::simulate(system, problem, planned, options);
  EXPECT_EQ(solution.status, maneuver::Status::simulated) << solution.message;
  return solution;
}

/// State of a solution's node.
inline ReferenceState node_state(const model::System& system, const maneuver::Solution& solution, int k) {
  return maneuver::node_motion(system, solution).state[static_cast<std::size_t>(k)];
}

/// A state with deviations added: turns and angles, shift, then velocities' numbers.
inline ReferenceState deviated(const model::System& system, const ReferenceState& state, const VectorXd& off) {
  const int half = system.velocity_count();
  mechanics::Freedoms turn(state.rotation.size());
  mechanics::unpack(system, off.head(half), turn);
  return {turned(system, state.rotation, turn), state.position + off.segment<3>(half - 3),
          state.velocity + off.tail(half)};
}

/// The start of a problem at a state.
inline maneuver::Start start_at(const model::System& system, const ReferenceState& state) {
  maneuver::Start start;
  start.position = state.position;
  for (const Matrix3d& R : state.rotation) start.rotation.push_back(lie::log(R));
  start.angular_velocity = mechanics::angular_velocities(system, state.rotation, state.velocity);
  start.linear_velocity = state.velocity.tail<3>();
  return start;
}

/// Moments that run as waves, within what the joints exert.
inline maneuver::ControlFunction waves(Random& random, const model::System& system, double size) {
  const mechanics::Moments even = random_moments(random, system, size), odd = random_moments(random, system, size);
  return [even, odd](double t) {
    mechanics::Moments u = even;
    for (std::size_t j = 0; j < u.size(); ++j) u[j] = std::cos(6.0 * t) * even[j] + std::sin(5.0 * t) * odd[j];
    return u;
  };
}

/// A random tree with joints of every kind in motion, total momentum and all.
inline Plan tree_in_motion(unsigned seed, int bodies, integrator::Scheme scheme, int steps, double duration) {
  Random random(seed);
  maneuver::Problem problem;
  problem.swimmer = random_swimmer(random, bodies);
  for (model::JointDescription& joint : problem.swimmer.joints) joint.actuated = true;
  problem.steps = steps;
  problem.duration.value = duration;
  problem.scheme = scheme;
  const model::System system(problem.swimmer);
  ReferenceState state{random_rotations(random, system), random.vector(0.2), VectorXd()};
  mechanics::pack(system, random_freedoms(random, system, 0.5), random.vector(0.3), state.velocity);
  problem.start = start_at(system, state);
  return Plan(problem, waves(random, system, 1.0));
}

/// The paper's chain from rest in its start shape, waves of `size` N m; about e_3 alone when `planar`.
inline Plan chain_in_motion(double size, int steps, double duration, bool planar = false) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain();
  if (planar)
    for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d::UnitZ()};
  problem.start.rotation = {Vector3d::Zero(), Vector3d::Zero(), Vector3d(0, 0, M_PI / 4)};
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.steps = steps;
  problem.duration.value = duration;
  Random random(9);
  return Plan(problem, waves(random, model::System(problem.swimmer), size));
}

}  // namespace lamprey::tests
