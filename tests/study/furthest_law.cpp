// Gaits that go as far as it pays.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "model/input_error.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

// Of small strokes what they win and what they cost are of one order in their size: there a search may stay at hardly any.
TEST(FurthestGaits, are_more_than_the_least_strokes_that_pay) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_two_arms.toml");
  problem.cost_weights.displacement[0] = 1e3;
  search::SolveOptions options;
  options.refinement = false;
  for (const std::uint64_t seed : {1U, 3U}) {
    problem.search.seed = seed;
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
    EXPECT_LT(answer.solution.cost, -0.6) << "−0.704 by other seeds, −0.0165 where strokes are least";
  }
}

// Joints that stop at their limits bound what one loop of shapes wins; no smooth way leads from one to two.
TEST(FurthestGaits, go_round_more_than_once_where_that_wins_more) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_by_several_cycles.toml");
  search::SolveOptions options;
  options.refinement = false;
  const model::System system(problem.swimmer);
  const auto solved = [&] { return study::answer(system, problem, options); };
  const study::Answer several = solved();
  EXPECT_EQ(several.certificate.verdict, certificate::Verdict::proved) << several.solution.message;
  EXPECT_GT(several.solution.position.back().x() - several.solution.position.front().x(), 0.5);
  options.first_alone = true;
  const study::Answer once = solved();
  EXPECT_LT(once.solution.position.back().x() - once.solution.position.front().x(), 0.32) << "the loop of all shapes";
  EXPECT_LT(several.solution.cost, 1.3 * once.solution.cost) << "both below zero";
}

// Of more and more cycles the best number is not passed over, whatever the first guesses came to: here five, one of which by itself
// costs a fifth.
TEST(FurthestGaits, go_round_as_often_as_wins_most) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_three_links.toml");
  search::SolveOptions options;
  options.refinement = false;
  const model::System system(problem.swimmer);
  const study::Answer all = study::answer(system, problem, options);
  problem.steps /= 5;
  problem.duration.value /= 5.0;
  problem.search.starts = 4;
  const study::Answer one = study::answer(system, problem, options);
  EXPECT_EQ(all.certificate.verdict, certificate::Verdict::proved) << all.solution.message;
  EXPECT_LT(all.solution.cost, 4.97 * one.solution.cost) << "both below zero";
}

// From a straight shape no moment moves the swimmer to first order: to stay is stationary there, and an answer where the price is low.
TEST(FurthestGaits, stay_where_no_stroke_is_worth_its_cost) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_two_arms.toml");
  problem.steps = 100;
  problem.search.starts = 3;
  problem.cost_weights.displacement[0] *= 1e-6;
  search::SolveOptions options;
  options.refinement = false;
  const study::Answer still = study::answer(model::System(problem.swimmer), problem, options);
  EXPECT_EQ(still.solution.status, maneuver::Status::optimal) << still.solution.message;
  EXPECT_EQ(still.solution.cost, 0.0);
  EXPECT_NE(still.solution.message.find("It stays where it is"), std::string::npos) << still.solution.message;
}

TEST(FurthestGaits, are_not_sought_along_what_no_moment_moves) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_two_arms.toml");
  problem.cost_weights.displacement = {0.0, 0.0, -5.0};
  const model::System system(problem.swimmer);
  try {
    study::answer(system, problem, {});
    FAIL() << "sought";
  } catch (const model::InputError& error) {
    EXPECT_EQ(error.key, "cost.displacement");
    EXPECT_NE(error.message.find("along which the joints' moments move nothing"), std::string::npos) << error.message;
  }
}

}  // namespace
}  // namespace lamprey::tests
