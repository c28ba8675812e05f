// A Solver that could not reach a goal goes on to the next one as if it had never been asked for the other.
#include <gtest/gtest.h>

#include "model/system.hpp"
#include "search/solve.hpp"
#include "search/solver.hpp"

namespace lamprey::tests {
namespace {

using optimizer::Termination;

// Three links in a plane, whose joints exert 1 N m at most.
maneuver::Problem three_links() {
  maneuver::Problem problem;
  problem.name = "three links";
  problem.swimmer.density = 1000.0;
  for (const char* name : {"middle", "front", "back"}) {
    model::BodyDescription body;
    body.name = name;
    body.semi_axes = {0.1, 0.02, 0.03};
    problem.swimmer.bodies.push_back(body);
  }
  for (const double side : {1.0, -1.0}) {
    model::JointDescription joint;
    joint.name = joint.child = side > 0.0 ? "front" : "back";
    joint.parent = "middle";
    joint.kind = model::JointKind::hinge;
    joint.axis = {0.0, 0.0, 1.0};
    joint.parent_offset = {0.11 * side, 0.0, 0.0};
    joint.child_offset = {-0.11 * side, 0.0, 0.0};
    problem.swimmer.joints.push_back(joint);
  }
  problem.start.rotation.assign(3, Eigen::Vector3d::Zero());
  problem.start.angular_velocity.assign(3, Eigen::Vector3d::Zero());
  problem.goal.emplace();
  problem.goal->move = {0.1, std::nullopt, std::nullopt};
  problem.goal->turn = Eigen::Vector3d::Zero();
  problem.duration.value = 1.0;
  problem.steps = 200;
  problem.limits.torque = 1.0;
  return problem;
}

// The barrier of its last answer is too stiff to get far from it.
TEST(SolverAfterFailure, finds_the_goals_that_it_finds_without) {
  const maneuver::Problem problem = three_links();
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  const maneuver::Solution solution = search::solve(system, problem, options).front();
  ASSERT_EQ(solution.status, maneuver::Status::optimal) << solution.message;
  for (const double too_far : {0.3, 3.0})
    for (const double next : {0.05, 0.1, 0.135}) {
      search::Solver solver(system, problem, solution);
      const auto asked_for = [&](double move) {
        maneuver::Goal goal = *problem.goal;
        goal.move[0] = move;
        solver.set_goal(goal);
        return solver.solve().termination;
      };
      for (const double nearer : {0.11, 0.12, 0.13, 0.14, 0.15})
        ASSERT_EQ(asked_for(nearer), Termination::converged) << nearer;
      EXPECT_NE(asked_for(too_far), Termination::converged);
      EXPECT_EQ(asked_for(next), Termination::converged) << next << " after " << too_far;
    }
}

}  // namespace
}  // namespace lamprey::tests
