// What a Solver finds from the last answer on is a solution of the moved problem.
#include "printed.hpp"
#include "search/solver.hpp"

#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "maneuver/feedback.hpp"
#include "mechanics/continuous.hpp"
#include "model/input_error.hpp"
#include "search/solve.hpp"
#include "study/hull_with_fins.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Goal;
using maneuver::Problem;
using maneuver::Solution;
using optimizer::Termination;

Problem example_with(const std::string& name, int steps) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + name + ".toml");
  problem.steps = steps;
  problem.search.starts = 1;
  return problem;
}

struct Solved {
  Problem problem;
  model::System system;
  Solution solution;
  Solved(const std::string& name, int steps)
      : problem(example_with(name, steps)),
        system(problem.swimmer),
        solution(search::solve(system, problem, search::SolveOptions()).front()) {}
};

certificate::Certificate certified(const Solved& solved, const Problem& problem, const search::Solver& solver) {
  certificate::Options options;
  options.replay = false;
  return certificate::certify(solved.system, problem, solver.solution(), options);
}

integrator::State state_at(const Solved& solved, std::size_t node) {
  const integrator::NodeMotion motion = maneuver::node_motion(solved.system, solved.solution);
  const integrator::ReferenceState& state = motion.state[node];
  return integrator::state_of_velocity(solved.system, state.rotation, state.position, state.velocity);
}

maneuver::Start start_of(const model::System& system, const integrator::State& state) {
  maneuver::Start start;
  for (const Eigen::Matrix3d& R : state.rotation) start.rotation.push_back(lie::log(R));
  start.position = state.position;
  const Eigen::VectorXd velocity = integrator::velocity_of_state(system, state);
  start.linear_velocity = velocity.tail<3>();
  start.angular_velocity = mechanics::angular_velocities(system, state.rotation, velocity);
  return start;
}

// Last body a hundredth rad off, no total momentum.
maneuver::Start start_beside(const model::System& system, const integrator::State& state) {
  maneuver::Start beside = start_of(system, state);
  beside.rotation.back() = lie::log(lie::exp(beside.rotation.back()) * lie::exp(Eigen::Vector3d(0.0, 0.0, 0.01)));
  return start_of(system, maneuver::start_without_momentum(system, beside));
}

// The problem of the last answer: its start, and its goal as seen from there.
Problem answered_problem(const Solved& solved, const search::Solver& solver) {
  Problem problem = solved.problem;
  const maneuver::Maneuver& answered = solver.answered();
  problem.start = start_of(solved.system, answered.start);
  problem.goal->turn.reset();
  for (std::size_t i = 0; i < answered.end_rotation.size(); ++i)
    if (const auto& end = answered.end_rotation[i])
      problem.goal->rotation[solved.system.bodies()[i].name] = lie::log(*end);
  for (std::size_t c = 0; c < 3; ++c)
    if (auto& move = problem.goal->move[c])
      *move = *answered.end_position[c] - answered.start.position[static_cast<Eigen::Index>(c)];
  problem.duration.value = solver.duration();
  problem.duration.min = solver.between()[0];
  problem.duration.max = solver.between()[1];
  return problem;
}

void expect_near(const mechanics::Rotations& one, const mechanics::Rotations& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - other[i]).norm(), 1e-8);
}

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
