// Starts with momentum in a free duration: how far the whole drifts is up to the time it takes.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "maneuver/maneuver.hpp"
#include "model/input_error.hpp"
#include "search/drifting.hpp"
#include "search/first_motion.hpp"
#include "search/solver.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using maneuver::Problem;
using maneuver::Solution;

Problem of_free_time(const std::string& path, int steps, double time_weight) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + path);
  problem.steps = steps;
  problem.search.starts = 2;
  problem.duration.free = true;
  problem.duration.min = 0.2 * problem.duration.value;
  problem.duration.max = 5.0 * problem.duration.value;
  problem.time_weight = time_weight;
  return problem;
}
// One joint in a plane, where the goal asks for a place that the swimmer drifts to; three bodies in space; within limits, joints at rest.
Problem turn_in_free_time() { return of_free_time("/bench/problems/drifting_turn.toml", 80, 2.0); }
Problem space_in_free_time() {
  Problem problem = of_free_time("/examples/drifting.toml", 100, 1.0);
  problem.limits = {};
  return problem;
}
Problem rest_in_free_time() { return of_free_time("/examples/drifting_to_rest.toml", 100, 20.0); }

study::Answer answer_in_free_time(const Problem& problem, search::Backend solver, const Solution* from = nullptr) {
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  options.solver = solver;
  if (from != nullptr) options.first = search::first_motion(system, problem, *from);
  return study::answer(system, problem, options);
}

void expect_proved_in_free_time(const study::Answer& answer) {
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.goal_error, 1e-10);
  EXPECT_LE(answer.certificate.kkt, 1e-9);
  EXPECT_LE(answer.certificate.momentum_drift, 1e-11);
  if (answer.solution.solver.name == "lamprey newton") {
    EXPECT_LE(answer.certificate.iterates_momentum, 1e-11);
  }
}

TEST(DriftingInFreeTime, has_one_answer_by_both_solvers) {
  for (const Problem& problem : {turn_in_free_time(), space_in_free_time()}) {
    const study::Answer own = answer_in_free_time(problem, search::Backend::newton);
    expect_proved_in_free_time(own);
    EXPECT_EQ(own.solution.solver.name, "lamprey newton");
    const study::Answer other = answer_in_free_time(problem, search::Backend::ipopt, &own.solution);
    EXPECT_EQ(other.solution.status, maneuver::Status::optimal) << other.solution.message;
    EXPECT_NEAR(other.solution.cost / own.solution.cost, 1.0, 1e-8);
    EXPECT_NEAR(other.solution.time.back() / own.solution.time.back(), 1.0, 1e-5);
  }
}

// From the same cold start both end at the same minimum, neither knowing of the other.
TEST(DriftingInFreeTime, is_found_by_both_solvers_from_their_own_guesses) {
  const Problem problem = turn_in_free_time();
  const study::Answer own = answer_in_free_time(problem, search::Backend::newton),
                      other = answer_in_free_time(problem, search::Backend::ipopt);
  expect_proved_in_free_time(own);
  EXPECT_EQ(other.certificate.verdict, certificate::Verdict::proved) << other.solution.message;
  EXPECT_EQ(other.solution.solver.name, "ipopt");
  EXPECT_NEAR(other.solution.cost / own.solution.cost, 1.0, 1e-8);
}

// In the duration that it found, given, the answer stays; a little less or more time costs more, time's own price included.
TEST(DriftingInFreeTime, takes_the_time_that_costs_least) {
  for (const Problem& problem : {turn_in_free_time(), space_in_free_time(), rest_in_free_time()}) {
    const study::Answer answer = answer_in_free_time(problem, search::Backend::automatic);
    expect_proved_in_free_time(answer);
    const double duration = answer.solution.time.back(), cost = answer.solution.cost;
    EXPECT_GT(duration, 1.02 * problem.duration.min);
    EXPECT_LT(duration, 0.98 * problem.duration.max);
    const auto cost_of_given = [&](double share) {
      Problem given = problem;
      given.duration = {};
      given.duration.value = share * duration;
      const study::Answer found = answer_in_free_time(given, search::Backend::newton, &answer.solution);
      EXPECT_EQ(found.certificate.verdict, certificate::Verdict::proved) << found.solution.message;
      return found.solution.cost;
    };
    EXPECT_NEAR(cost_of_given(1.0) / cost, 1.0, 1e-8);
    const double less = cost_of_given(0.97), more = cost_of_given(1.0 / 0.97);
    EXPECT_GT(less, cost * (1.0 + 1e-6));
    EXPECT_GT(more, cost * (1.0 + 1e-6));
    EXPECT_LT(std::abs(more - less), 0.3 * (more + less - 2.0 * cost)) << "the least is not in the midst of them";
  }
}

// A plan in free time that goes on from where the swimmer is: the same end, to what steps of another length make of it.
TEST(DriftingInFreeTime, goes_on_with_the_rest_of_an_answer) {
  const auto missed = [](int steps) {
    Problem problem = space_in_free_time();
    problem.steps = steps;
    const model::System system(problem.swimmer);
    const study::Answer answer = answer_in_free_time(problem, search::Backend::newton);
    search::Solver solver(system, problem, answer.solution);
    EXPECT_TRUE(solver.answers());
    const double passed = answer.solution.time[static_cast<std::size_t>(steps) / 4];
    solver.advance(passed);
    const optimizer::Outcome outcome = solver.solve();
    EXPECT_EQ(outcome.termination, optimizer::Termination::converged) << outcome.reason;
    return std::abs(passed + solver.solution().time.back() - answer.solution.time.back());
  };
  const double coarse = missed(80), fine = missed(160);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, 0.35 * coarse);
}

// To its very end: what is left in as many steps is little time, moments are few and what round-off leaves of idle ones is more
// beside them.
TEST(DriftingInFreeTime, goes_on_to_the_end_of_a_plan_with_a_joint_that_nothing_drives) {
  Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/drifting_passive_tip_in_free_time.toml");
  const model::System system(problem.swimmer);
  const study::Answer answer = answer_in_free_time(problem, search::Backend::newton);
  expect_proved_in_free_time(answer);
  for (const double share : {0.8, 0.9, 0.95}) {
    search::Solver solver(system, problem, answer.solution);
    const double passed = share * answer.solution.time.back();
    solver.advance(passed);
    const optimizer::Outcome outcome = solver.solve();
    EXPECT_EQ(outcome.termination, optimizer::Termination::converged) << share << ": " << outcome.reason;
    EXPECT_NEAR(passed + solver.solution().time.back(), answer.solution.time.back(), 1e-3);
  }
}

// Goals that momentum reaches by itself: in no more time than must be, or where time costs nothing in the time that it takes.
TEST(DriftingInFreeTime, does_nothing_where_its_momentum_gets_there) {
  Problem problem = turn_in_free_time();
  problem.goal = maneuver::Goal();
  problem.goal->rest = false;
  problem.goal->angle[problem.swimmer.joints[0].name] = {0.0};
  const study::Answer at_once = answer_in_free_time(problem, search::Backend::automatic);
  expect_proved_in_free_time(at_once);
  EXPECT_EQ(at_once.solution.time.back(), problem.duration.min);
  EXPECT_NEAR(at_once.solution.cost, problem.time_weight * problem.duration.min, 1e-15);
  EXPECT_NE(at_once.solution.message.find("does nothing"), std::string::npos) << at_once.solution.message;

  problem.goal->turn = Vector3d::Zero();
  problem.goal->move = {1.0, 0.0, std::nullopt};
  problem.time_weight = 0.0;
  const study::Answer in_time = answer_in_free_time(problem, search::Backend::automatic);
  EXPECT_EQ(in_time.solution.status, maneuver::Status::optimal) << in_time.solution.message;
  EXPECT_EQ(in_time.solution.cost, 0.0);
  EXPECT_NEAR(in_time.solution.time.back(), 1.0 / problem.start.linear_velocity.norm(), 1e-8);
  problem.duration = {};
  problem.duration.value = in_time.solution.time.back();
  problem.time_weight = 3.0;
  const study::Answer given = answer_in_free_time(problem, search::Backend::automatic);
  expect_proved_in_free_time(given);
  EXPECT_NEAR(given.solution.cost, 3.0 * problem.duration.value, 1e-12);
}

// What begins at rest where the goal is stays as briefly as it may.
TEST(FreeTime, is_the_least_where_nothing_needs_to_move) {
  Problem problem = turn_in_free_time();
  problem.start.linear_velocity.setZero();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->rest = true;
  const study::Answer answer = answer_in_free_time(problem, search::Backend::automatic);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_EQ(answer.solution.time.back(), problem.duration.min);
  EXPECT_EQ(answer.solution.cost, problem.time_weight * problem.duration.min);
}

// Guesses begin in short and in long times: from the midst of wide bounds searches came to minima seven times as dear.
TEST(DriftingInFreeTime, is_found_within_wide_bounds_as_within_narrow_ones) {
  Problem problem = rest_in_free_time();
  problem.time_weight = 0.5;
  problem.search.starts = 3;
  problem.duration.min = 0.5;
  const auto cost_within = [&](double most) {
    problem.duration.max = most;
    problem.duration.value = 0.5 * (problem.duration.min + most);
    const study::Answer answer = answer_in_free_time(problem, search::Backend::automatic);
    expect_proved_in_free_time(answer);
    return answer.solution.cost;
  };
  const double narrow = cost_within(8.0);
  EXPECT_NEAR(cost_within(60.0) / narrow, 1.0, 1e-7);
}

// Momentum is in no unit of time: bodies and prices that are the same in other units of time have the same motion.
TEST(DriftingInFreeTime, is_the_same_in_other_units_of_time) {
  const double unit = 7.0;
  const Problem problem = turn_in_free_time();
  Problem slow = problem;
  slow.start.linear_velocity /= unit;
  slow.duration.value *= unit;
  slow.duration.min *= unit;
  slow.duration.max *= unit;
  slow.time_weight /= unit * unit * unit * unit;
  const study::Answer one = answer_in_free_time(problem, search::Backend::newton),
                      other = answer_in_free_time(slow, search::Backend::newton, &one.solution);
  expect_proved_in_free_time(other);
  EXPECT_NEAR(other.solution.time.back() / one.solution.time.back() / unit, 1.0, 1e-7);
  EXPECT_NEAR(other.solution.cost / one.solution.cost * unit * unit * unit, 1.0, 1e-8);
}

TEST(DriftingInFreeTime, stops_looking_for_a_coast_when_told_to) {
  Problem problem = turn_in_free_time();
  problem.time_weight = 0.0;
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, problem.steps);
  int asked = 0, in_all = 0;
  search::coasting_to_goal(system, problem, maneuver, [&] { return ++in_all < 0; });
  EXPECT_FALSE(search::coasting_to_goal(system, problem, maneuver, [&] { return ++asked > 100; }));
  EXPECT_GT(in_all, 2000);
  EXPECT_LT(asked, 200) << "one more for each duration";
}

TEST(DriftingInFreeTime, is_refused_of_gaits_alone) {
  Problem problem = turn_in_free_time();
  problem.goal->periodic = true;
  try {
    answer_in_free_time(problem, search::Backend::automatic);
    FAIL() << "taken";
  } catch (const model::InputError& error) {
    EXPECT_EQ(error.key, "start");
    EXPECT_NE(error.message.find("no periodic goal"), std::string::npos) << error.message;
  }
}

}  // namespace
}  // namespace lamprey::tests
