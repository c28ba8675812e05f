// Starts with momentum from which no first guess of shapes gets to the goal, and plans on a thousand steps.
#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "certificate/verdict.hpp"
#include "file/problem_file.hpp"
#include "search/solver.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

// Two bodies that tumble in a vacuum, in space, with one hinge: motions that leave mechanics on the way get there.
TEST(DriftingSwimmers, are_sought_by_the_second_solver_where_the_first_finds_nothing) {
  const maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/tumbling_pair.toml");
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  options.solver = search::Backend::newton;
  EXPECT_NE(study::answer(system, problem, options).solution.status, maneuver::Status::optimal);
  options.solver = search::Backend::automatic;
  const study::Answer answer = study::answer(system, problem, options);
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_EQ(answer.solution.search.starts, 2 * problem.search.starts);
  ASSERT_FALSE(answer.solution.search.minima.empty());
  EXPECT_GT(answer.solution.search.minima.front().by_ipopt.value_or(0), 0);
}

// On many steps sets of limits that hold change by many nodes with the goal: where none is found in a few tries, what a barrier has
// found is the answer.
TEST(SolversThatDrift, go_on_within_limits_on_a_thousand_steps) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/drifting_to_rest.toml");
  problem.steps = 1000;
  problem.search.starts = 1;
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  const study::Answer answer = study::answer(system, problem, options);
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  search::Solver solver(system, problem, answer.solution);
  EXPECT_TRUE(solver.answers());
  for (const double share : {1.01, 1.0}) {
    maneuver::Goal goal = *problem.goal;
    *goal.turn *= share;
    solver.set_goal(goal);
    const optimizer::Outcome outcome = solver.solve();
    EXPECT_EQ(outcome.termination, optimizer::Termination::converged) << outcome.reason;
    maneuver::Problem asked = problem;
    asked.goal = goal;
    const certificate::Certificate proof = certificate::certify(system, asked, solver.solution(), {});
    EXPECT_TRUE(certificate::stationary(asked, proof)) << proof.kkt << " " << proof.limits->complementarity;
    EXPECT_EQ(proof.verdict, certificate::Verdict::proved);
  }
  EXPECT_NEAR(solver.cost() / answer.solution.cost, 1.0, 1e-7);  // one of them by a barrier
}

}  // namespace
}  // namespace lamprey::tests
