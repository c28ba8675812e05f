// A Solver goes on within limits: from nodes that press on them, with slacks and multipliers of its last answer.
#include <gtest/gtest.h>

#include "solved.hpp"
#include "study/hull_with_fins.hpp"

namespace lamprey::tests {
namespace {

// An example with limits on the swing of both joints, and its answer.
struct WithinSwing {
  Problem problem;
  model::System system;
  Solution solution;
  WithinSwing(const char* example, int steps, double swing)
      : problem(example_with(example, steps)), system(limited(swing)) {
    search::SolveOptions options;
    options.refinement = false;
    solution = search::solve(system, problem, options).front();
  }

 private:
  const model::SwimmerDescription& limited(double swing) {
    problem.limits.swing = {{"front", swing}, {"back", swing}};
    return problem.swimmer;
  }
};

// Where an answer presses on limits for long a first step to another goal may hardly move: limits are eased before it, and where
// round-off hides what steps gain nothing is tried any more.
TEST(SolverWithinLimits, moves_on_from_nodes_that_press_on_their_limits) {
  const WithinSwing rotation("rotation", 300, 0.9);
  ASSERT_EQ(rotation.solution.status, maneuver::Status::optimal) << rotation.solution.message;
  search::Solver solver(rotation.system, rotation.problem, rotation.solution);
  for (const double share : {0.99, 1.01}) {
    Goal goal = *rotation.problem.goal;
    *goal.turn *= share;
    solver.set_goal(goal);
    const optimizer::Outcome outcome = solver.solve();
    ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
    EXPECT_LE(outcome.iterations, 50) << share;
    EXPECT_LE(outcome.evaluations, 100) << share;
    EXPECT_GT(std::abs(solver.cost() / rotation.solution.cost - 1.0), 1e-3);
  }
}

// Nor does a longer way lead from node to node of them.
// What has passed and what is left take as long as the whole, and as dear.
TEST(SolverWithinLimits, goes_on_with_the_rest_of_a_free_duration) {
  const Solved solved("free_time", 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  const double whole = solved.solution.time.back(), passed = 0.25 * whole;
  solver.advance(passed);
  EXPECT_NEAR(solver.between()[1], solved.problem.duration.max - passed, 1e-12);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_NEAR((passed + solver.duration()) / whole, 1.0, 4e-3);
  const Problem rest = answered_problem(solved, solver);
  const certificate::Certificate certificate = certified(solved, rest, solver);
  EXPECT_LT(certificate.goal_error, 1e-10);
  EXPECT_LT(certificate.kkt, 1e-8);
  ASSERT_TRUE(certificate.limits);
  EXPECT_LT(certificate.limits->violation, 1e-8);
}

// Two fins that turn a hull press on limits of their angles.
struct PressingFins {
  Problem problem = hull_with_fins(60, {4.0, 4.0});
  model::System system{problem.swimmer};
  Solution solution;
  PressingFins() {
    problem.duration.free = false;
    problem.time_weight = 0.0;
    for (const char* fin : {"L", "R"}) problem.limits.angle[fin] = {{-0.5, 0.5}};
    problem.search.starts = 4;
    solution = search::solve(system, problem, search::SolveOptions()).front();
    EXPECT_EQ(solution.status, maneuver::Status::optimal) << solution.message;
  }
  double angle(const integrator::State& state, int joint) const {
    return mechanics::joint_angles(system.joint(joint), mechanics::child_to_parent(state.rotation, system.joint(joint)))
        .cwiseAbs()
        .maxCoeff();
  }
};

TEST(SolverWithinLimits, begins_within_them_whenever_time_has_passed) {
  const PressingFins fins;
  int pressed = 0;
  for (int n = 1; n < 48; ++n) {
    search::Solver solver(fins.system, fins.problem, fins.solution);
    solver.advance(n / 48.0 * 0.9 * fins.problem.duration.value);
    for (int joint = 0; joint < 2; ++joint) {
      const double angle = fins.angle(solver.maneuver().start, joint);
      EXPECT_LE(angle, 0.5 + 1e-9) << n;
      pressed += angle > 0.5 - 1e-6 ? 1 : 0;
    }
  }
  EXPECT_GT(pressed, 5) << "no limit was near";
}

TEST(SolverWithinLimits, begins_at_a_limit_that_a_joint_is_seen_beyond) {
  const PressingFins fins;
  search::Solver solver(fins.system, fins.problem, fins.solution);
  solver.advance(0.4 * fins.problem.duration.value);
  const auto seen = [&](double angle) {
    maneuver::Start start = start_of(fins.system, solver.maneuver().start);
    start.rotation[1] = lie::log(lie::exp(start.rotation[0]) *
                                 mechanics::joint_rotation(fins.system.joint(0), Eigen::Vector3d(angle, 0.0, 0.0)));
    return maneuver::start_without_momentum(fins.system, start);
  };
  solver.set_start(seen(0.55));
  EXPECT_NEAR(fins.angle(solver.maneuver().start, 0), 0.5, 1e-9);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_THROW(solver.set_start(seen(0.75)), model::InputError);
}

// Where many limits hold at once others do at the next goal: sets of them are tried, of which each leaves a node or two to mend. From a
// barrier on it were three to eight times as many steps.
TEST(SolverWithinLimits, finds_which_of_many_limits_hold_by_trying) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/chain_of_seven_turns.toml");
  problem.steps = 100;
  const model::System system(problem.swimmer);
  const Solution first = search::solve(system, problem, search::SolveOptions()).front();
  ASSERT_EQ(first.status, maneuver::Status::optimal) << first.message;
  search::Solver solver(system, problem, first);
  int steps = 0;
  for (const double share : {1.01, 1.02, 1.03}) {
    Problem moved = problem;
    *moved.goal->turn *= share;
    solver.set_goal(*moved.goal);
    const optimizer::Outcome outcome = solver.solve();
    ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
    steps += outcome.iterations;
    certificate::Options options;
    options.replay = false;
    const certificate::Certificate proof = certificate::certify(system, moved, solver.solution(), options);
    EXPECT_EQ(proof.verdict, certificate::Verdict::proved) << share;
  }
  EXPECT_LE(steps, 100);
}

TEST(SolverWithinLimits, moves_farther_than_slacks_reach) {
  const WithinSwing translation("translation", 1000, 1.2);
  search::Solver solver(translation.system, translation.problem, translation.solution);
  Goal goal = *translation.problem.goal;
  *goal.move[0] *= 1.03;
  solver.set_goal(goal);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE(outcome.iterations, 60);  // 118 where limits are not eased
}

}  // namespace
}  // namespace lamprey::tests
