// Starts with momentum in a free duration: how far the whole drifts is up to the time it takes.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "maneuver/maneuver.hpp"
#include "model/input_error.hpp"
#include "study/answer.hpp"
#include "study/first_motion.hpp"
#include "study/solver.hpp"
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

study::Answer answer_in_free_time(const Problem& problem, study::Backend solver, const Solution* from = nullptr) {
  const model::System system(problem.swimmer);
  study::SolveOptions options;
  options.refinement = false;
  options.solver = solver;
  if (from != nullptr) options.first = study::first_motion(system, problem, *from);
  return study::answer(system, problem, options);
}

void expect_proved_in_free_time(const study::Answer& answer) {
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.goal_error, 1e-10);
  EXPECT_LE(answer.certificate.kkt, 1e-9);
  EXPECT_LE(answer.certificate.momentum_drift, 1e-11);
  EXPECT_LE(answer.certificate.iterates_momentum, 1e-11);
}

TEST(DriftingInFreeTime, has_one_answer_by_both_solvers) {
  for (const Problem& problem : {turn_in_free_time(), space_in_free_time()}) {
    const study::Answer own = answer_in_free_time(problem, study::Backend::newton);
    expect_proved_in_free_time(own);
    EXPECT_EQ(own.solution.solver.name, "lamprey newton");
    const study::Answer other = answer_in_free_time(problem, study::Backend::ipopt, &own.solution);
    EXPECT_EQ(other.solution.status, maneuver::Status::optimal) << other.solution.message;
    EXPECT_NEAR(other.solution.cost / own.solution.cost, 1.0, 1e-8);
    EXPECT_NEAR(other.solution.time.back() / own.solution.time.back(), 1.0, 1e-5);
  }
}

// From the same cold start both end at the same minimum, neither knowing of the other.
TEST(DriftingInFreeTime, is_found_by_both_solvers_from_their_own_guesses) {
  const Problem problem = turn_in_free_time();
  const study::Answer own = answer_in_free_time(problem, study::Backend::newton),
                      other = answer_in_free_time(problem, study::Backend::ipopt);
  expect_proved_in_free_time(own);
  EXPECT_EQ(other.certificate.verdict, certificate::Verdict::proved) << other.solution.message;
  EXPECT_EQ(other.solution.solver.name, "ipopt");
  EXPECT_NEAR(other.solution.cost / own.solution.cost, 1.0, 1e-8);
}

// In the duration that it found, given, the answer stays; a little less or more time costs more, time's own price included.
TEST(DriftingInFreeTime, takes_the_time_that_costs_least) {
  for (const Problem& problem : {turn_in_free_time(), space_in_free_time(), rest_in_free_time()}) {
    const study::Answer answer = answer_in_free_time(problem, study::Backend::automatic);
    expect_proved_in_free_time(answer);
    const double duration = answer.solution.time.back(), cost = answer.solution.cost;
    EXPECT_GT(duration, 1.02 * problem.duration.min);
    EXPECT_LT(duration, 0.98 * problem.duration.max);
    const auto cost_of_given = [&](double share) {
      Problem given = problem;
      given.duration = {};
      given.duration.value = share * duration;
      const study::Answer found = answer_in_free_time(given, study::Backend::newton, &answer.solution);
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
    const study::Answer answer = answer_in_free_time(problem, study::Backend::newton);
    study::Solver solver(system, problem, answer.solution);
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
  const study::Answer one = answer_in_free_time(problem, study::Backend::newton),
                      other = answer_in_free_time(slow, study::Backend::newton, &one.solution);
  expect_proved_in_free_time(other);
  EXPECT_NEAR(other.solution.time.back() / one.solution.time.back() / unit, 1.0, 1e-7);
  EXPECT_NEAR(other.solution.cost / one.solution.cost * unit * unit * unit, 1.0, 1e-8);
}

TEST(DriftingInFreeTime, is_refused_of_gaits_alone) {
  Problem problem = turn_in_free_time();
  problem.goal->periodic = true;
  try {
    answer_in_free_time(problem, study::Backend::automatic);
    FAIL() << "taken";
  } catch (const model::InputError& error) {
    EXPECT_EQ(error.key, "start");
    EXPECT_NE(error.message.find("no periodic goal"), std::string::npos) << error.message;
  }
}

}  // namespace
}  // namespace lamprey::tests
