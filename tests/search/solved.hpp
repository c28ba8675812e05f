// Examples, solved, and what a Solver that goes on from their answers is to be judged by.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "maneuver/feedback.hpp"
#include "mechanics/continuous.hpp"
#include "search/solve.hpp"
#include "search/solver.hpp"

namespace lamprey::tests {

using maneuver::Goal;
using maneuver::Problem;
using maneuver::Solution;
using optimizer::Termination;

inline Problem example_with(const std::string& name, int steps) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + name + ".toml");
  problem.steps = steps;
  problem.search.starts = 1;
  return problem;
}

struct Solved {
  Problem problem;
  model::System system;
  Solution solution;
  Solved(const std::string& name, int steps)
      : problem(example_with(name, steps)),
        system(problem.swimmer),
        solution(search::solve(system, problem, search::SolveOptions()).front()) {}
};

inline certificate::Certificate certified(const Solved& solved, const Problem& problem, const search::Solver& solver) {
  certificate::Options options;
  options.replay = false;
  return certificate::certify(solved.system, problem, solver.solution(), options);
}

inline integrator::State state_at(const Solved& solved, std::size_t node) {
  const integrator::NodeMotion motion = maneuver::node_motion(solved.system, solved.solution);
  const integrator::ReferenceState& state = motion.state[node];
  return integrator::state_of_velocity(solved.system, state.rotation, state.position, state.velocity);
}

inline maneuver::Start start_of(const model::System& system, const integrator::State& state) {
  maneuver::Start start;
  for (const Eigen::Matrix3d& R : state.rotation) start.rotation.push_back(lie::log(R));
  start.position = state.position;
  const Eigen::VectorXd velocity = integrator::velocity_of_state(system, state);
  start.linear_velocity = velocity.tail<3>();
  start.angular_velocity = mechanics::angular_velocities(system, state.rotation, velocity);
  return start;
}

// Last body a hundredth rad off, no total momentum.
inline maneuver::Start start_beside(const model::System& system, const integrator::State& state) {
  maneuver::Start beside = start_of(system, state);
  beside.rotation.back() = lie::log(lie::exp(beside.rotation.back()) * lie::exp(Eigen::Vector3d(0.0, 0.0, 0.01)));
  return start_of(system, maneuver::start_without_momentum(system, beside));
}

// The problem of the last answer: its start, and its goal as seen from there.
inline Problem answered_problem(const Solved& solved, const search::Solver& solver) {
  Problem problem = solved.problem;
  const maneuver::Maneuver& answered = solver.answered();
  problem.start = start_of(solved.system, answered.start);
  problem.goal->turn.reset();
  for (std::size_t i = 0; i < answered.end_rotation.size(); ++i)
    if (const auto& end = answered.end_rotation[i])
      problem.goal->rotation[solved.system.bodies()[i].name] = lie::log(*end);
  for (std::size_t c = 0; c < 3; ++c)
    if (auto& move = problem.goal->move[c])
      *move = *answered.end_position[c] - answered.start.position[static_cast<Eigen::Index>(c)];
  problem.duration.value = solver.duration();
  problem.duration.min = solver.between()[0];
  problem.duration.max = solver.between()[1];
  return problem;
}

inline void expect_near(const mechanics::Rotations& one, const mechanics::Rotations& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - other[i]).norm(), 1e-8);
}

}  // namespace lamprey::tests
