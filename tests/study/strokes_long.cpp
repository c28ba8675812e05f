// Goals within limits that only strokes of a gait reach, from the first guesses on.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

TEST(StrokesWithinLimits, reach_sideways_by_a_gait_that_begins_and_ends_at_rest) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/sideways_by_two_fins.toml");
  problem.search.starts = 1;
  problem.search.time_limit = 400.0;
  study::SolveOptions options;
  options.refinement = false;
  options.workers = 2;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
  EXPECT_GT(answer.solution.search.strokes, 4) << "equal strokes were enough";
}

}  // namespace
}  // namespace lamprey::tests
