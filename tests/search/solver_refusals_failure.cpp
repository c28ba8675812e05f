// What a Solver does not take, and in which words it says so.
#include <gtest/gtest.h>

#include "model/input_error.hpp"
#include "solved.hpp"

namespace lamprey::tests {
namespace {

TEST(SolverRefusals, say_what_does_not_fit) {
  const Solved solved("translation", 30);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  maneuver::Goal goal = *solved.problem.goal;
  goal.rest = false;
  EXPECT_THROW(solver.set_goal(goal), model::InputError);
  goal = *solved.problem.goal;
  goal.move[0].reset();
  EXPECT_THROW(solver.set_goal(goal), model::InputError);
  EXPECT_THROW(solver.set_duration(0.0), model::InputError);
  for (const double elapsed :
       {0.0, -0.1, std::nan(""), solved.problem.duration.value, (1.0 - 1e-15) * solved.problem.duration.value})
    EXPECT_THROW(solver.advance(elapsed), model::InputError);
  Problem moving = solved.problem;
  moving.start.linear_velocity = {1.0, 0.0, 0.0};
  EXPECT_THROW(solver.set_start(maneuver::start_state(solved.system, moving.start)), model::InputError);
  Problem other = solved.problem;
  other.duration.free = true;
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution).set_duration(2.0), model::InputError);
  other = solved.problem;
  other.waypoints.push_back({0.5, {std::nullopt, 0.1, std::nullopt}, std::nullopt, {}});
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution).set_duration(2.0), model::InputError);
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution).advance(0.1), model::InputError);
  other = solved.problem;
  other.goal->periodic = true;
  other.goal->rest = false;
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution).advance(0.1), model::InputError);
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution)
                   .set_start(maneuver::start_state(solved.system, other.start)),
               model::InputError);
  other = solved.problem;
  other.scheme = maneuver::Scheme::order4;
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution), model::InputError);
  other = solved.problem;
  other.steps = 31;
  EXPECT_THROW(search::Solver(solved.system, other, solved.solution), model::InputError);
  Solution foreign = solved.solution;
  foreign.position.clear();
  EXPECT_THROW(search::Solver(solved.system, solved.problem, foreign), model::InputError);
  foreign = solved.solution;
  foreign.position[3][1] = std::nan("");
  EXPECT_THROW(search::Solver(solved.system, solved.problem, foreign), model::InputError);
  foreign = solved.solution;
  for (auto& bodies : foreign.rotation) bodies.pop_back();
  EXPECT_THROW(search::Solver(solved.system, solved.problem, foreign), model::InputError);
}

TEST(SolverRefusals, name_what_a_problem_has_that_no_solver_takes) {
  const Solved solved("translation", 30);
  const auto refusal = [&](const Problem& problem) -> std::string {
    try {
      const search::Solver solver(solved.system, problem, solved.solution);
    } catch (const model::InputError& error) {
      return error.what();
    }
    return "";
  };
  Problem other = solved.problem;
  other.goal.reset();
  EXPECT_NE(refusal(other).find("found no goal"), std::string::npos) << refusal(other);
  other = solved.problem;
  other.scheme = maneuver::Scheme::order4;
  EXPECT_NE(refusal(other).find("order 2"), std::string::npos) << refusal(other);
  other = solved.problem;
  other.start.linear_velocity = {1.0, 0.0, 0.0};
  EXPECT_NE(refusal(other).find("momentum"), std::string::npos) << refusal(other);
}

// As problem files are: a search for what limits forbid would take all its time.
TEST(SolverRefusals, name_the_limit_that_a_goal_or_a_start_breaks) {
  Problem problem = example_with("translation", 50);
  problem.limits.half_spaces.push_back({Eigen::Vector3d(40.0, 0.0, 0.0), Eigen::Vector3d(-1.0, 0.0, 0.0)});
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  const Solution solution = search::solve(system, problem, options).front();
  search::Solver solver(system, problem, solution);
  const auto refused = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const model::InputError& error) {
      return error.what();
    }
    return "";
  };
  Goal goal = *problem.goal;
  goal.move[0] = 60.0;
  EXPECT_NE(refused([&] { solver.set_goal(goal); }).find("goal that breaks limits.half_space[0]"), std::string::npos);
  maneuver::Start start = start_of(system, solver.maneuver().start);
  start.position[0] += 60.0;
  const std::string of_start = refused([&] { solver.set_start(maneuver::start_without_momentum(system, start)); });
  EXPECT_NE(of_start.find("start that breaks limits.half_space[0]"), std::string::npos) << of_start;
  solver.set_goal(*problem.goal);
  EXPECT_EQ(solver.solve().termination, Termination::converged) << "what was refused left its mark";
}

TEST(SolverRefusals, goals_out_of_the_plane_that_moments_keep_are_out_of_reach) {
  const Solved solved("translation", 30);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  maneuver::Goal goal = *solved.problem.goal;
  goal.turn = Eigen::Vector3d(0.1, 0.0, 0.0);
  solver.set_goal(goal);
  const optimizer::Outcome outcome = solver.solve();
  EXPECT_EQ(outcome.termination, Termination::infeasible);
  EXPECT_NE(outcome.reason.find("cannot reach"), std::string::npos) << outcome.reason;
}

}  // namespace
}  // namespace lamprey::tests
