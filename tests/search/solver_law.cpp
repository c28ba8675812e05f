// What a Solver finds from the last answer on is a solution of the moved problem.
#include <gtest/gtest.h>

#include "model/input_error.hpp"
#include "printed.hpp"
#include "solved.hpp"

namespace lamprey::tests {
namespace {

class SolverOfManeuvers : public testing::TestWithParam<const char*> {};

TEST_P(SolverOfManeuvers, moves_on_to_another_goal_in_a_few_steps) {
  const Solved solved(GetParam(), 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  const Solution begun = solver.solution();  // what it was given
  EXPECT_NEAR(begun.cost / solved.solution.cost, 1.0, 1e-9);
  EXPECT_EQ(begun.status, maneuver::Status::optimal);
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  EXPECT_NEAR(solver.cost() / solved.solution.cost, 1.0, 1e-9);
  Problem moved = solved.problem;
  for (auto& coordinate : moved.goal->move)
    if (coordinate) *coordinate *= 1.01;
  if (moved.goal->turn) *moved.goal->turn *= 0.99;
  solver.set_goal(*moved.goal);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE(outcome.iterations, 6);
  const certificate::Certificate certificate = certified(solved, moved, solver);
  EXPECT_LT(certificate.goal_error, 1e-10);
  EXPECT_LT(certificate.kkt, 1e-8);
  EXPECT_GT(std::abs(solver.cost() - solved.solution.cost), 1e-3 * solved.solution.cost);
}

TEST_P(SolverOfManeuvers, finds_what_is_left_of_an_optimal_maneuver_optimal) {
  const Solved solved(GetParam(), 60);
  const std::size_t from = 20;
  Problem rest = solved.problem;
  rest.steps = 40;
  rest.duration.value *= 40.0 / 60.0;
  Solution tail;
  tail.rotation.assign(solved.solution.rotation.begin() + from, solved.solution.rotation.end());
  tail.position.assign(solved.solution.position.begin() + from, solved.solution.position.end());
  search::Solver solver(solved.system, rest, tail);
  solver.set_start(state_at(solved, from));
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE(outcome.iterations, 3);
  double largest = 0.0, difference = 0.0;
  const Solution found = solver.solution();
  for (std::size_t k = 0; k < found.control.size(); ++k)
    for (std::size_t j = 0; j < found.control[k].size(); ++j) {
      largest = std::max(largest, solved.solution.control[from + k][j].norm());
      difference = std::max(difference, (found.control[k][j] - solved.solution.control[from + k][j]).norm());
    }
  EXPECT_LT(difference, 1e-6 * largest);
}

TEST_P(SolverOfManeuvers, goes_on_from_another_start_and_with_less_time) {
  const Solved solved(GetParam(), 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  Problem moved = solved.problem;
  moved.start.rotation.back() = Eigen::Vector3d(0.0, 0.0, 0.02);
  moved.duration.value *= 0.98;
  solver.set_start(maneuver::start_state(solved.system, moved.start));
  solver.set_duration(moved.duration.value);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  // the goal stayed where it was in the world
  for (int i = 0; i < solved.system.body_count(); ++i)
    if (const auto& end = solver.maneuver().end_rotation[static_cast<std::size_t>(i)])
      moved.goal->rotation[solved.system.body(i).name] = lie::log(*end);
  moved.goal->turn.reset();
  const certificate::Certificate certificate = certified(solved, moved, solver);
  EXPECT_LT(certificate.goal_error, 1e-10);
  EXPECT_LT(certificate.kkt, 1e-8);
}

// The time after a third of the motion, and what the nodes from there on cost by the trapezoid.
struct Rest {
  double time, cost;
};

Rest rest_of(const Solved& solved) {
  const std::size_t from = solved.solution.time.size() / 3;
  double cost = 0.0;
  for (std::size_t k = from; k + 1 < solved.solution.time.size(); ++k)
    for (std::size_t node : {k, k + 1})
      for (const Eigen::Vector3d& moment : solved.solution.control[node])
        cost += 0.25 * (solved.solution.time[k + 1] - solved.solution.time[k]) * moment.squaredNorm();
  return {solved.solution.time[from], cost};
}

// Bellman: the rest of an optimal motion is the optimal motion for the rest of the time, to what steps of another length make of it.
double missed_by_the_rest(const char* name, int steps) {
  const Solved solved(name, steps);
  const Rest rest = rest_of(solved);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  solver.advance(rest.time);
  const optimizer::Outcome outcome = solver.solve();
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE(outcome.iterations, 8);
  EXPECT_NEAR(solver.duration(), solved.problem.duration.value - rest.time, 1e-12);
  search::Solver whole(solved.system, solved.problem, solved.solution);  // begins at all of the motion
  whole.set_start(solver.maneuver().start);
  whole.set_duration(solver.duration());
  EXPECT_GT(whole.solve().iterations, outcome.iterations);
  EXPECT_EQ(solver.path().rotation.size(), solved.solution.rotation.size());
  return std::abs(solver.cost() / rest.cost - 1.0);
}

TEST_P(SolverOfManeuvers, goes_on_with_the_rest_of_its_answer_when_time_has_passed) {
  const double coarse = missed_by_the_rest(GetParam(), 90), fine = missed_by_the_rest(GetParam(), 180);
  EXPECT_LT(coarse, 0.05);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.3) << coarse << " " << fine;
}

TEST_P(SolverOfManeuvers, adds_up_times_that_pass_before_it_finds_an_answer) {
  const Solved solved(GetParam(), 60);
  search::Solver once(solved.system, solved.problem, solved.solution),
      twice(solved.system, solved.problem, solved.solution);
  once.advance(0.375 * solved.problem.duration.value);
  twice.advance(0.25 * solved.problem.duration.value);
  optimizer::Options none = search::Solver::newton_options();
  none.most_iterations = 0;
  EXPECT_EQ(twice.solve(none).termination, Termination::stalled);
  twice.advance(0.125 * solved.problem.duration.value);
  ASSERT_EQ(once.solve().termination, Termination::converged);
  ASSERT_EQ(twice.solve().termination, Termination::converged);
  expect_near(once.path().rotation.back(), twice.path().rotation.back());
  expect_near(once.path().rotation.front(), twice.path().rotation.front());
  EXPECT_NEAR(once.cost() / twice.cost(), 1.0, 1e-9);
}

TEST_P(SolverOfManeuvers, goes_on_from_where_it_is_seen_when_time_has_passed) {
  const Solved solved(GetParam(), 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  solver.advance(0.31 * solved.problem.duration.value);  // between two nodes
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  const certificate::Certificate planned = certified(solved, answered_problem(solved, solver), solver);
  EXPECT_LT(planned.equation_residual, 1e-10);
  EXPECT_LT(planned.kkt, 1e-8);
  const integrator::State seen =
      maneuver::start_without_momentum(solved.system, start_beside(solved.system, solver.maneuver().start));
  solver.set_start(seen);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE(outcome.iterations, 20);
  EXPECT_EQ(solver.path().rotation.front(), seen.rotation);
  // the goal stays where it was in the world
  for (std::size_t i = 0; i < seen.rotation.size(); ++i)
    if (solver.maneuver().end_rotation[i]) {
      EXPECT_LT((solver.path().rotation.back()[i] - solved.solution.rotation.back()[i]).norm(), 1e-8);
    }
  const certificate::Certificate certificate = certified(solved, answered_problem(solved, solver), solver);
  EXPECT_LT(certificate.equation_residual, 1e-10);
  EXPECT_LT(certificate.kkt, 1e-8);
}

void expect_same_answer(const Solution& one, const Solution& two) {
  EXPECT_EQ(one.cost, two.cost);
  EXPECT_EQ(one.status, two.status);
  EXPECT_EQ(one.time, two.time);
  EXPECT_EQ(one.position, two.position);
  EXPECT_EQ(one.rotation, two.rotation);
  EXPECT_EQ(one.control, two.control);
  EXPECT_EQ(one.angular_velocity, two.angular_velocity);
}

TEST_P(SolverOfManeuvers, keeps_its_answer_while_another_start_and_duration_are_not_solved) {
  const Solved solved(GetParam(), 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  const Solution answer = solver.solution();
  const maneuver::NodePath path = solver.path();
  const double before = solver.duration();
  Problem moved = solved.problem;
  moved.start.rotation.back() = Eigen::Vector3d(0.0, 0.0, 0.02);
  const double duration = 0.98 * solved.problem.duration.value;
  const auto ask = [&] {
    solver.set_start(maneuver::start_state(solved.system, moved.start));
    solver.set_duration(duration);
  };
  const auto expect_kept = [&] {
    EXPECT_EQ(solver.path().rotation, path.rotation);
    EXPECT_EQ(solver.path().cayley, path.cayley);
    EXPECT_EQ(solver.duration(), before);
    expect_same_answer(solver.solution(), answer);
    EXPECT_EQ(solver.answered().duration, solved.problem.duration.value);
    EXPECT_EQ(solver.answered().start.rotation, path.rotation.front());
    EXPECT_EQ(solver.maneuver().duration, duration);
    const certificate::Certificate certificate = certified(solved, solved.problem, solver);
    EXPECT_LT(certificate.equation_residual, evidence::equation_mark);
    EXPECT_LT(certificate.start_error, 1e-12);
    EXPECT_LT(certificate.kkt, 1e-8);
  };
  ask();
  expect_kept();
  optimizer::Options none = search::Solver::newton_options();
  none.interrupted = [] { return true; };
  ASSERT_EQ(solver.solve(none).termination, Termination::interrupted);
  expect_kept();

  ASSERT_EQ(solver.solve().termination, Termination::converged) << "what is asked for stays";
  EXPECT_EQ(solver.answered().duration, duration);
  EXPECT_NEAR(solver.duration(), duration, 1e-12);
  EXPECT_NE(solver.cost(), answer.cost);
}

// Whatever comes between two requests, the second goes on from the first one's motion.
TEST_P(SolverOfManeuvers, requests_before_a_solve_add_up) {
  const Solved solved(GetParam(), 60);
  const auto outcome_of = [&](const std::vector<double>& angles, const std::vector<double>& shares) {
    search::Solver solver(solved.system, solved.problem, solved.solution);
    Problem moved = solved.problem;
    for (double angle : angles) {
      moved.start.rotation.back() = Eigen::Vector3d(0.0, 0.0, angle);
      solver.set_start(maneuver::start_state(solved.system, moved.start));
    }
    for (double share : shares) solver.set_duration(share * solved.problem.duration.value);
    EXPECT_EQ(solver.solve().termination, Termination::converged);
    return solver.solution();
  };
  const Solution straight = outcome_of({0.02}, {0.98}), around = outcome_of({-0.01, 0.03, 0.02}, {1.02, 0.98});
  EXPECT_NEAR(around.cost / straight.cost, 1.0, 1e-8);
  EXPECT_NEAR(around.time.back() / straight.time.back(), 1.0, 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Examples, SolverOfManeuvers, testing::Values("translation", "rotation"), named_by_value);

// Limits, waypoints, free durations, other costs and periodic goals: what a search takes.
class SolverOfRicherProblems : public testing::TestWithParam<const char*> {};

TEST_P(SolverOfRicherProblems, stays_at_an_answer_and_moves_on_to_another_goal) {
  const Solved solved(GetParam(), 50);
  ASSERT_EQ(solved.solution.status, maneuver::Status::optimal) << solved.solution.message;
  search::Solver solver(solved.system, solved.problem, solved.solution);
  const optimizer::Outcome stayed = solver.solve();
  ASSERT_EQ(stayed.termination, Termination::converged) << stayed.reason;
  EXPECT_NEAR(solver.cost() / solved.solution.cost, 1.0, 1e-8);
  EXPECT_NEAR(solver.duration() / solved.solution.time.back(), 1.0, 1e-6);
  Problem moved = solved.problem;
  for (auto& coordinate : moved.goal->move)
    if (coordinate) *coordinate *= 1.01;
  *moved.goal->turn *= 0.99;
  solver.set_goal(*moved.goal);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  const certificate::Certificate certificate = certified(solved, moved, solver);
  EXPECT_LT(certificate.goal_error, 1e-9);
  EXPECT_LT(certificate.kkt, 1e-8);
  if (certificate.limits) {
    EXPECT_LT(certificate.limits->violation, evidence::limit_mark);
    EXPECT_LT(certificate.limits->complementarity, evidence::complementarity_mark);
  }
  // from scratch they take 60 or more; kinks of work and an obstacle beside the way settle slowly
  const std::string name = GetParam();
  EXPECT_LE(outcome.iterations, name == "around_an_obstacle" ? 60 : name == "least_work" ? 30 : 8);
  EXPECT_GT(std::abs(solver.cost() - solved.solution.cost), 1e-3 * solved.solution.cost);
}

INSTANTIATE_TEST_SUITE_P(Examples, SolverOfRicherProblems,
                         testing::Values("free_time", "around_an_obstacle", "least_work", "gait_within_limits",
                                         "rotation_with_clearance"),
                         named_by_value);

// To stay is what costs nothing, and what no search finds its way from: at rest no small change of shapes moves the swimmer.
class SolverAtRest : public testing::TestWithParam<const char*> {};

Goal to_stay(const Goal& goal) {
  Goal stay = goal;
  for (auto& coordinate : stay.move)
    if (coordinate) *coordinate = 0.0;
  if (stay.turn) stay.turn->setZero();
  for (auto& [body, rotation] : stay.rotation)
    if (rotation) rotation->setZero();
  return stay;
}

TEST_P(SolverAtRest, stays_where_the_goal_is_and_moves_on_from_there) {
  const Solved solved(GetParam(), 50);
  ASSERT_EQ(solved.solution.status, maneuver::Status::optimal) << solved.solution.message;
  search::Solver solver(solved.system, solved.problem, solved.solution);
  Problem stay = solved.problem;
  stay.goal = to_stay(*solved.problem.goal);
  for (int round = 0; round < 2; ++round) {
    solver.set_goal(*stay.goal);
    if (round == 1) solver.advance(0.1 * solver.duration());  // of a motion, or of none
    const optimizer::Outcome outcome = solver.solve();
    ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
    EXPECT_TRUE(solver.answers());
    EXPECT_EQ(solver.cost(), 0.0);
    stay.duration.value = solver.duration();
    const certificate::Certificate certificate = certified(solved, stay, solver);
    EXPECT_EQ(certificate.goal_error, 0.0);
    EXPECT_LT(certificate.kkt, 1e-12);
  }
  solver.set_duration(solved.problem.duration.value);
  solver.set_goal(*solved.problem.goal);
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_NEAR(solver.cost() / solved.solution.cost, 1.0, 1e-6);  // the shapes of the last answer that moved
  EXPECT_LT(certified(solved, solved.problem, solver).goal_error, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Examples, SolverAtRest, testing::Values("translation", "rotation", "rotation_with_clearance"),
                         named_by_value);

// A swimmer that is measured next to where it shall be moves a little, and so does what brings it to rest there.
TEST_P(SolverAtRest, brings_to_rest_what_hardly_moves) {
  const Solved solved(GetParam(), 50);
  std::vector<double> costs;
  for (const double rate : {1e-2, 1e-1}) {  // rad/s
    search::Solver solver(solved.system, solved.problem, solved.solution);
    solver.set_goal(to_stay(*solved.problem.goal));
    ASSERT_EQ(solver.solve().termination, Termination::converged);
    maneuver::Start start = start_of(solved.system, solver.answered().start);
    for (std::size_t i = 0; i < start.angular_velocity.size(); ++i)
      start.angular_velocity[i] = Eigen::Vector3d(0.0, 0.0, (i % 2 == 0 ? 1.0 : -2.0) * rate);
    solver.set_start(maneuver::start_without_momentum(solved.system, start));
    const optimizer::Outcome outcome = solver.solve();
    ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
    EXPECT_LE(outcome.iterations, 60);
    costs.push_back(solver.cost());
  }
  EXPECT_NEAR(costs[1] / costs[0], 100.0, 1.0);  // moments as rates
}

TEST(SolverBegunAtRest, is_made_of_a_solution_that_stays) {
  Problem problem = example_with("translation", 100);
  const Goal far = *problem.goal;
  problem.goal = to_stay(far);
  const model::System system(problem.swimmer);
  const Solution still = search::solve(system, problem, search::SolveOptions()).front();
  ASSERT_EQ(still.solver.name, "at rest");
  search::Solver solver(system, problem, still);
  EXPECT_TRUE(solver.answers());
  EXPECT_EQ(solver.cost(), 0.0);
  solver.set_goal(far);
  EXPECT_FALSE(solver.answers());
  EXPECT_EQ(solver.solve().termination, Termination::converged);
  EXPECT_GT(solver.cost(), 1e3);
}

// The distance that work is counted by is the one from the start that is asked for to the goal.
TEST(SolverOfWorkPerDistance, follows_its_start_and_its_goal) {
  Problem problem = example_with("translation", 50);
  problem.goal->move = {1.0, 0.0, 0.0};
  problem.cost_weights.transport = 20.0;
  const model::System system(problem.swimmer);
  search::Solver solver(system, problem, search::solve(system, problem, search::SolveOptions()).front());
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  const auto expect_certified = [&] {
    ASSERT_EQ(solver.solve().termination, Termination::converged);
    certificate::Options options;
    options.replay = false;
    const certificate::Certificate certificate = certificate::certify(system, problem, solver.solution(), options);
    EXPECT_LT(certificate.cost_error, 1e-9);
    EXPECT_LT(certificate.kkt, 1e-8);
    EXPECT_LT(certificate.goal_error, 1e-9);
  };
  problem.start.position[0] = 0.05;
  *problem.goal->move[0] -= 0.05;  // to where it was in the world
  solver.set_start(maneuver::start_state(system, problem.start));
  expect_certified();
  Goal goal = *problem.goal;
  *goal.move[0] = 1.02;  // seen from the first start
  solver.set_goal(goal);
  *problem.goal->move[0] = 0.97;
  expect_certified();
  *goal.move[0] = 0.05;
  EXPECT_THROW(solver.set_goal(goal), model::InputError);
}

TEST(Solver, gives_gains_about_its_last_answer) {
  const Solved solved("translation", 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  solver.advance(0.2 * solved.problem.duration.value);
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  const maneuver::Feedback gains = solver.feedback();
  EXPECT_NEAR(gains.time.back(), solver.duration(), 1e-12);
  const maneuver::Feedback own =
      maneuver::design_feedback(solved.system, answered_problem(solved, solver), solver.solution());
  EXPECT_EQ(gains.time, own.time);
  EXPECT_EQ(gains.gain, own.gain);
}

TEST(Solver, knows_which_solutions_answer_its_problem) {
  const Solved solved("translation", 60);
  const auto answers = [&](const Problem& problem) {
    return search::Solver(solved.system, problem, solved.solution).answers();
  };
  EXPECT_TRUE(answers(solved.problem));
  Problem other = solved.problem;
  other.goal->move[0] = 2.1;
  EXPECT_FALSE(answers(other)) << "goal";
  const Goal other_goal = *other.goal;
  other = solved.problem;
  other.duration.value *= 1.1;
  EXPECT_FALSE(answers(other)) << "duration";
  other = solved.problem;
  other.start.position[1] = 0.1;
  EXPECT_FALSE(answers(other)) << "start";
  other = solved.problem;
  other.limits.torque = 1.0;
  EXPECT_FALSE(answers(other)) << "limits";
  search::Solver solver(solved.system, solved.problem, solved.solution);
  solver.set_duration(1.01 * solved.problem.duration.value);
  EXPECT_FALSE(solver.answers());
  solver.set_goal(other_goal);
  optimizer::Options none = search::Solver::newton_options();
  none.most_iterations = 0;
  EXPECT_NE(solver.solve(none).termination, Termination::converged);
  EXPECT_FALSE(solver.answers());
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  EXPECT_TRUE(solver.answers());
  solver.set_goal(*solved.problem.goal);
  EXPECT_FALSE(solver.answers());
}

// What moments of a plane cannot turn back ends as it began; the answer is to that.
TEST(Solver, answers_what_it_reaches_from_a_start_a_little_out_of_its_plane) {
  const Solved solved("translation", 60);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  maneuver::Start tilted = start_of(solved.system, solver.maneuver().start);
  for (Eigen::Vector3d& vector : tilted.rotation)
    vector = lie::log(lie::exp(Eigen::Vector3d(1e-7, 0.0, 0.0)) * lie::exp(vector));
  solver.set_start(maneuver::start_without_momentum(solved.system, tilted));
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_GT(solver.path().rotation.back()[0](2, 1), 0.5e-7) << "nothing was out of reach";
  const certificate::Certificate certificate = certified(solved, answered_problem(solved, solver), solver);
  EXPECT_LT(certificate.goal_error, 1e-12);
  EXPECT_LT(certificate.kkt, 1e-8);
}

TEST(Solver, goes_on_where_its_time_was_over) {
  const Solved solved("rotation", 200);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  Goal goal = *solved.problem.goal;
  goal.turn = 0.8 * *goal.turn;
  solver.set_goal(goal);
  optimizer::Options few = search::Solver::newton_options();
  int calls = 0;
  few.interrupted = [asked = 0]() mutable { return ++asked % 4 == 0; };
  while (calls < 200 && solver.solve(few).termination == Termination::interrupted) ++calls;
  EXPECT_GT(calls, 2);
  EXPECT_TRUE(solver.answers());
}

TEST(Solver, takes_turns_in_radians) {
  const Solved solved("translation", 50);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  Goal goal = *solved.problem.goal;
  goal.turn = Eigen::Vector3d(0.0, 0.0, 60.0);
  EXPECT_THROW(solver.set_goal(goal), model::InputError);
  goal.turn = Eigen::Vector3d(0.0, 0.0, 0.1);
  EXPECT_NO_THROW(solver.set_goal(goal));
}

TEST(SolverOfLedBodies, follows_a_start_with_other_joint_angles) {
  const Solved solved("falling_cat_flip", 50);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  Problem moved = solved.problem;
  const model::Joint& joint = solved.system.joint(0);
  const Eigen::Matrix3d root = lie::exp(moved.start.rotation[0]);
  moved.start.rotation[1] =
      lie::log(Eigen::Matrix3d(root * mechanics::joint_rotation(joint, Eigen::Vector3d(0.03, -0.02, 0.0))));
  solver.set_start(maneuver::start_state(solved.system, moved.start));
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  for (int i = 0; i < solved.system.body_count(); ++i)  // the goal stayed where it was in the world
    moved.goal->rotation[solved.system.body(i).name] =
        lie::log(*solver.maneuver().end_rotation[static_cast<std::size_t>(i)]);
  moved.goal->turn.reset();
  const certificate::Certificate certificate = certified(solved, moved, solver);
  EXPECT_LT(certificate.goal_error, 1e-10);
  EXPECT_LT(certificate.kkt, 1e-8);
}

}  // namespace
}  // namespace lamprey::tests
