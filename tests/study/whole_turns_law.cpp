// Joints that turn all the way round find what strokes do not, and cheaper motions than joints that only swing.
#include <gtest/gtest.h>

#include <algorithm>

#include "file/problem_file.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem example(const std::string& path, int steps) {
  maneuver::Problem problem = file::read_problem_file(LAMPREY_SOURCE_DIR + path).problem;
  problem.steps = steps;
  problem.search.hops = problem.search.whole_turns = 0;
  return problem;
}

study::Answer answer_to(const maneuver::Problem& problem) {
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(system, problem, options);
}

bool says(const study::Answer& answer, const std::string& words) {
  return answer.solution.message.find(words) != std::string::npos;
}

// A quarter turn by four paddles, which no stroke manages: where neither guesses nor strokes arrive, turns are tried unasked.
TEST(WholeTurnsSearch, turns_a_hull_by_its_paddles_where_strokes_do_not_arrive) {
  maneuver::Problem problem = example("/bench/problems/four_arms_yaw_90.toml", 200);
  const double unasked = answer_to(problem).solution.cost;
  problem.search.starts = 5;
  problem.search.whole_turns = 4;
  const study::Answer answer = answer_to(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.goal_error, tolerance(1e-10));
  EXPECT_LE(std::max(answer.solution.cost, unasked), 0.1);
}

TEST(WholeTurnsSearch, finds_cheaper_ways_through_space) {
  maneuver::Problem problem = example("/examples/translation_in_space.toml", 100);
  problem.search.starts = 16;
  const study::Answer swinging = answer_to(problem);
  EXPECT_TRUE(says(swinging, "whole_turns = 8 has that many of the")) << swinging.solution.message;
  EXPECT_TRUE(says(swinging, "of them met once: [search] hops = 64")) << swinging.solution.message;
  problem.search.whole_turns = 15;
  const study::Answer turning = answer_to(problem);
  EXPECT_EQ(turning.certificate.verdict, certificate::Verdict::proved) << turning.solution.message;
  EXPECT_LE(turning.solution.cost, 0.6 * swinging.solution.cost);
  EXPECT_FALSE(says(turning, "whole_turns")) << turning.solution.message;
  EXPECT_EQ(turning.solution.search.starts, 16);
}

TEST(WholeTurnsSearch, begins_with_the_same_guesses_before_the_last) {
  maneuver::Problem problem = example("/examples/rotation.toml", 60);
  problem.search.starts = 1;
  const double alone = answer_to(problem).solution.cost;
  problem.search.whole_turns = 5;  // of one guess
  EXPECT_EQ(answer_to(problem).solution.cost, alone);
}

TEST(WholeTurnsSearch, swings_where_limits_let_no_joint_turn_round) {
  maneuver::Problem problem = example("/examples/rotation.toml", 60);
  problem.search.starts = 8;
  for (const model::JointDescription& joint : problem.swimmer.joints) problem.limits.swing[joint.name] = 2.5;
  const study::Answer swinging = answer_to(problem);
  EXPECT_FALSE(says(swinging, "whole_turns"));
  problem.search.whole_turns = 2;
  const study::Answer same = answer_to(problem);
  EXPECT_EQ(same.solution.cost, swinging.solution.cost);
  EXPECT_EQ(same.solution.search.solved, swinging.solution.search.solved);
}

}  // namespace
}  // namespace lamprey::tests
