// Starts with momentum from which no first guess of shapes gets to the goal.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

// Two bodies that tumble in a vacuum, in space, with one hinge: motions that leave mechanics on the way get there.
TEST(DriftingSwimmers, are_sought_by_the_second_solver_where_the_first_finds_nothing) {
  const maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/tumbling_pair.toml");
  const model::System system(problem.swimmer);
  study::SolveOptions options;
  options.refinement = false;
  options.solver = study::Backend::newton;
  EXPECT_NE(study::answer(system, problem, options).solution.status, maneuver::Status::optimal);
  options.solver = study::Backend::automatic;
  const study::Answer answer = study::answer(system, problem, options);
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_EQ(answer.solution.search.starts, 2 * problem.search.starts);
  ASSERT_FALSE(answer.solution.search.minima.empty());
  EXPECT_GT(answer.solution.search.minima.front().by_ipopt.value_or(0), 0);
}

}  // namespace
}  // namespace lamprey::tests
