// Gaits that go as far as it pays.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
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

}  // namespace
}  // namespace lamprey::tests
