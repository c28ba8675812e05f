// Goals and costs at the edges of what a problem file can ask for end in an answer like any other.
#include <gtest/gtest.h>

#include "certificate/marched_answers.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem planar_chain() {
  maneuver::Problem problem = chain_problem(40, 1.0);
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  problem.goal->turn.reset();
  problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  return problem;
}

study::Answer answered(const maneuver::Problem& problem) {
  return study::answer(model::System(problem.swimmer), problem, {});
}

// From rest, to rest anywhere: nothing is to be done, and of no momentum nothing can be told relative to its scale.
TEST(UnusualGoals, to_come_to_rest_anywhere_costs_nothing) {
  const study::Answer answer = answered(planar_chain());
  EXPECT_LE(answer.solution.cost, 1e-12);
  EXPECT_FALSE(answer.solution.message.empty());
}

TEST(UnusualGoals, to_pass_a_point_and_come_to_rest_anywhere_is_proved) {
  maneuver::Problem problem = planar_chain();
  maneuver::Waypoint waypoint;
  waypoint.time = 0.5;
  waypoint.move = {0.05, std::nullopt, std::nullopt};
  problem.waypoints.push_back(waypoint);
  const study::Answer answer = answered(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
}

// The second-order test of free durations asks how fast joints turn at the start.
TEST(UnusualGoals, free_durations_with_every_other_cost_are_proved) {
  for (double maneuver::CostWeights::*weight :
       {&maneuver::CostWeights::work, &maneuver::CostWeights::power, &maneuver::CostWeights::smoothness}) {
    maneuver::Problem problem = planar_chain();
    problem.goal->turn = Vector3d::Zero();
    problem.goal->move[0] = 0.5;
    problem.duration.free = true;
    problem.duration.min = 0.7;
    problem.duration.max = 2.0;
    problem.cost_weights.*weight = 0.01;
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  }
}

}  // namespace
}  // namespace lamprey::tests
