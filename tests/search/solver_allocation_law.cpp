// A Solver that begins at an answer asks for no more memory.
#include <gtest/gtest.h>

#include "counted_allocations.hpp"
#include "file/problem_file.hpp"
#include "printed.hpp"
#include "search/solver.hpp"

namespace lamprey::tests {
namespace {

class SolverAllocation : public testing::TestWithParam<const char*> {};

TEST_P(SolverAllocation, none_happens_once_a_solver_is_made) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + GetParam() + ".toml");
  problem.steps = 50;
  problem.search.starts = 1;
  problem.search.hops = 0;
  const model::System system(problem.swimmer);
  const maneuver::Solution solution = search::solve(system, problem, search::SolveOptions()).front();
  const long at_first = allocations;
  search::Solver solver(system, problem, solution);
  EXPECT_GT(allocations, at_first) << "nothing is counted";
  int iterations = 0;
  for (double share : {1.01, 1.02, 0.99}) {
    maneuver::Goal goal = *problem.goal;
    for (auto& coordinate : goal.move)
      if (coordinate) *coordinate *= share;
    if (goal.turn) *goal.turn *= 2.0 - share;
    for (auto& [body, rotation] : goal.rotation)
      if (rotation) *rotation += Eigen::Vector3d(0.0, 0.0, share - 1.0);
    solver.set_goal(goal);
    const long before = allocations;
    const optimizer::Outcome& outcome = solver.solve();
    EXPECT_EQ(allocations - before, 0);
    ASSERT_EQ(outcome.termination, optimizer::Termination::converged) << outcome.reason;
    iterations += outcome.iterations;
  }
  EXPECT_GT(iterations, 3) << "Newton had nothing to do";
}

INSTANTIATE_TEST_SUITE_P(Examples, SolverAllocation,
                         testing::Values("translation", "translation_in_space", "rotation", "falling_cat_flip",
                                         "sideways", "around_an_obstacle", "rotation_with_clearance", "free_time",
                                         "gait", "gait_within_limits", "least_work", "eel_gait", "drifting",
                                         "drifting_to_rest"),
                         named_by_value);

}  // namespace
}  // namespace lamprey::tests
