// Goals within limits that neither first guesses nor equal strokes reach.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "search/stroke_searches.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem sideways_by_two_fins() {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/sideways_by_two_fins.toml");
  problem.search.starts = 1;
  problem.search.time_limit = 400.0;
  return problem;
}

TEST(StrokesWithinLimits, reach_sideways_in_parts_of_the_way) {
  const maneuver::Problem problem = sideways_by_two_fins();
  search::SolveOptions options;
  options.refinement = false;
  options.workers = 2;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
  EXPECT_GT(answer.solution.search.strokes, 0) << "a first guess was enough";
}

TEST(StrokesWithinLimits, reach_sideways_by_a_gait_that_begins_and_ends_at_rest) {
  const maneuver::Problem problem = sideways_by_two_fins();
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.workers = 2;
  const search::Budget budget(problem, options);
  EXPECT_TRUE(search::any_converged(search::solve_gaits_from_rest(search::Grids(system, problem, options, budget))));
}

}  // namespace
}  // namespace lamprey::tests
