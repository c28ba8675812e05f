// Shortest times by weak motors: moments go from limit to limit, and what they cost themselves is next to nothing.
#include <gtest/gtest.h>

#include <string>

#include "file/problem_file.hpp"
#include "study/answer.hpp"
#include "study/hull_with_fins.hpp"

namespace lamprey::tests {
namespace {

study::Answer answered_alone(const maneuver::Problem& problem) {
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// Moment, rate and angle of each joint limited.
maneuver::Problem weak_fins(double torque, double effort) {
  maneuver::Problem problem = hull_with_fins(120, {0.5, 80.0});
  problem.time_weight = 10.0;
  problem.effort = effort;
  problem.limits.torque = torque;
  problem.limits.angular_velocity = 3.0;
  problem.search.starts = 2;
  return problem;
}

double limited_share(const maneuver::Solution& solution, double torque) {
  int at_limit = 0, all = 0;
  for (const auto& moments : solution.control)
    for (const Eigen::Vector3d& moment : moments) {
      ++all;
      if (moment.norm() > (1.0 - 1e-9) * torque) ++at_limit;
    }
  return static_cast<double>(at_limit) / all;
}

class ShortestTimes : public ::testing::TestWithParam<double> {};

// However little effort counts: the search measures its steps by what moments are worth, and so does the certificate.
TEST_P(ShortestTimes, by_weak_motors_are_proved) {
  for (const double torque : {0.1, 0.02}) {
    SCOPED_TRACE(torque);
    const study::Answer answer = answered_alone(weak_fins(torque, GetParam()));
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
    EXPECT_GT(limited_share(answer.solution, torque), 0.1);
  }
}

// Where moments cost next to nothing a barrier leaves their limits a little room: what pulls by more than that holds all the same, and
// curvature is that of the limits being reached.
TEST(ShortestTime, with_little_effort_is_proved_as_with_more) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/least_time_with_little_effort.toml");
  const study::Answer little = answered_alone(problem);
  problem.effort *= 10.0;
  const study::Answer more = answered_alone(problem);
  for (const study::Answer* answer : {&little, &more})
    ASSERT_EQ(answer->certificate.verdict, certificate::Verdict::proved) << answer->solution.message;
  EXPECT_NEAR(little.solution.time.back() / more.solution.time.back(), 1.0, 1e-4);
  EXPECT_NEAR(little.certificate.second_order->smallest_eigenvalue / more.certificate.second_order->smallest_eigenvalue,
              1.0, 0.01);
}

// Which limits hold is told by the last fall of the barrier. While a shorter duration still made the cost fall, so did the barrier
// by a little, which told nothing: limits were held that nothing pulls at, and a saddle was the answer.
TEST(ShortestTime, of_a_vehicle_holds_the_limits_that_hold_it) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/weak_motors.toml");
  problem.search.starts = 1;
  const study::Answer answer = answered_alone(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
}

// Strokes get as far however fast they are, so that they are guesses in a free duration, too.
TEST(ShortestTime, of_more_strokes_than_a_guess_has_is_found) {
  maneuver::Problem problem = weak_fins(0.1, 1e-2);
  problem.steps = 200;
  problem.duration.max = 200.0;
  problem.goal->turn = Eigen::Vector3d(0.0, 0.0, 0.3);
  for (const char* fin : {"L", "R"}) problem.limits.angle[fin] = {{-0.4, 0.4}};
  problem.search.starts = 1;
  const study::Answer answer = answered_alone(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_GT(answer.solution.search.strokes, 0);
}

INSTANTIATE_TEST_SUITE_P(Efforts, ShortestTimes, testing::Values(1.0, 1e-2, 1e-4), [](const auto& effort) {
  return effort.param == 1.0 ? "one" : effort.param == 1e-2 ? "hundredth" : "ten_thousandth";
});

}  // namespace
}  // namespace lamprey::tests
