// Gaits that turn in place, that limits keep small, or whose goal is next to nothing.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Problem;

Problem three_links() {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/three_links.toml");
  problem.goal = maneuver::Goal();
  problem.goal->periodic = true;
  problem.goal->rest = false;
  problem.start.free_shape = true;
  problem.limits = {};
  problem.cost_weights = {};
  problem.duration.value = 1.0;
  problem.steps = 100;
  problem.search.starts = 2;
  return problem;
}

study::Answer small_answer(const Problem& problem, bool refinement = false) {
  search::SolveOptions options;
  options.refinement = refinement;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// Along the phase the Hessian vanishes: Newton steps that run along it neither end nor tell how far the search is.
TEST(TurningGaits, are_proved_but_for_their_phase_with_an_error_bar) {
  Problem problem = three_links();
  problem.goal->turn = Eigen::Vector3d(0.0, 0.0, 0.1);
  problem.steps = 200;
  problem.search.starts = 4;
  const study::Answer answer = small_answer(problem, true);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  ASSERT_TRUE(answer.certificate.second_order->along_phase);
  EXPECT_NE(answer.solution.message.find("strict but for where along itself the gait begins"), std::string::npos)
      << answer.solution.message;
  EXPECT_GE(answer.solution.search.solved, 3);
  ASSERT_TRUE(answer.certificate.refinement);
  EXPECT_NEAR(answer.certificate.refinement->observed_order, 2.0, 0.1);
}

// What angles of a third of a milliradian win is little, and more than what staying wins.
TEST(SmallGaits, that_win_are_not_told_to_stay) {
  Problem problem = three_links();
  problem.goal->turn = Eigen::Vector3d::Zero();
  problem.cost_weights.displacement = Eigen::Vector3d(1e3, 0.0, 0.0);
  for (const model::JointDescription& joint : problem.swimmer.joints)
    problem.limits.angle[joint.name] = {{-3e-4, 3e-4}};
  const study::Answer answer = small_answer(problem);
  EXPECT_EQ(answer.solution.message.find("It stays where it is"), std::string::npos) << answer.solution.message;
  EXPECT_LT(answer.solution.cost, -1e-6);
}

TEST(SmallGaits, are_not_called_infeasible_where_rest_keeps_all_limits) {
  for (const double price : {1e4, 1e6}) {
    Problem problem = three_links();
    problem.goal->turn = Eigen::Vector3d::Zero();
    problem.cost_weights.displacement = Eigen::Vector3d(price, 0.0, 0.0);
    problem.limits.torque = 1e-3;
    const study::Answer answer = small_answer(problem);
    EXPECT_NE(answer.solution.status, maneuver::Status::infeasible) << price << ": " << answer.solution.message;
  }
}

TEST(SmallGoals, are_resolved_where_the_replay_errs_by_a_tenth_of_them) {
  Problem problem = three_links();
  problem.goal->periodic = false;
  problem.goal->rest = true;
  problem.start.free_shape = false;
  problem.goal->turn = Eigen::Vector3d(0.0, 0.0, 2e-3);
  problem.goal->move = {1e-4, std::nullopt, std::nullopt};
  const study::Answer answer = small_answer(problem);
  ASSERT_TRUE(answer.certificate.replay);
  certificate::Replay replay = *answer.certificate.replay;
  EXPECT_NEAR(replay.position_mark, 1e-5, 1e-18);
  EXPECT_NEAR(replay.rotation_mark, 2e-4, 1e-18);
  replay.rotation_error = 0.0;
  replay.position_error = 0.9e-5;
  EXPECT_FALSE(replay.misses());
  replay.position_error = 1.1e-5;
  EXPECT_TRUE(replay.misses());
  EXPECT_TRUE(replay.misses_by_place());
  replay.rotation_error = std::nan("");
  EXPECT_TRUE(replay.misses()) << "it broke off";
}

TEST(ManyMinima, that_became_dear_on_all_steps_say_that_others_may_be_cheaper) {
  maneuver::Solution solution;
  solution.search.starts = solution.search.solved = 4;
  solution.search.minima = {{0.19, 4, {}}};
  solution.cost = 0.2;
  EXPECT_EQ(study::on_cheaper_ones(solution), "");
  solution.cost = 0.51;
  EXPECT_NE(study::on_cheaper_ones(solution).find("it cost 0.19"), std::string::npos);
  EXPECT_EQ(study::on_cheaper_ones(solution, true), "") << "one that costs as little on all steps is known";
}

// A hundred kilometres from the origin digits of places are too few for the cheapest gait, and no other is given out for it without a
// word.
TEST(ManyMinima, that_digits_of_far_places_hide_are_told) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_three_links.toml");
  problem.limits = {};
  problem.cost_weights.displacement.setZero();
  problem.goal->move[0] = 0.05;
  problem.start.position = Eigen::Vector3d(1e5, 1e5, 0.0);
  search::SolveOptions options;
  options.refinement = false;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  ASSERT_GT(answer.solution.cost, 1.5 * answer.solution.search.minima.front().cost) << "the cheapest is the answer";
  EXPECT_NE(answer.solution.message.find("was set aside: its discrete equations are off by"), std::string::npos)
      << answer.solution.message;
}

}  // namespace
}  // namespace lamprey::tests
