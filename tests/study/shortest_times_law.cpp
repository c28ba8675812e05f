// Shortest times by weak motors: moments go from limit to limit, and what they cost themselves is next to nothing.
#include <gtest/gtest.h>

#include <string>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

study::Answer answered_alone(const maneuver::Problem& problem) {
  study::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// A hull that two fins turn, moment and rate of each joint limited, and its angle.
maneuver::Problem hull_with_fins(double torque, double effort, int starts) {
  std::string text = R"(schema = 1
name = "fins"
[fluid]
density = 1000.0
[goal]
turn = [0, 0, 0.2]
[time]
duration = "free"
min = 0.5
max = 80.0
steps = 120
[cost]
time = 10.0
[limits]
angle.L = [-1.2, 1.2]
angle.R = [-1.2, 1.2]
angular_velocity = 3.0
[[body]]
name = "hull"
semi_axes = [0.3,0.1,0.08]
)";
  for (const auto& [name, side] : {std::pair("L", 1.0), std::pair("R", -1.0)})
    text += std::string("[[body]]\nname = \"") + name +
            "\"\nsemi_axes = [0.03,0.12,0.05]\n[[joint]]\nkind = \"hinge\"\nparent = \"hull\"\nchild = \"" + name +
            "\"\nparent_offset = [-0.05, " + std::to_string(0.12 * side) + ", 0]\nchild_offset = [0, " +
            std::to_string(-0.13 * side) + ", 0]\naxis = [0, 0, 1]\n";
  maneuver::Problem problem = file::parse_problem(text, "fins.toml").problem;
  problem.effort = effort;
  problem.limits.torque = torque;
  problem.search.starts = starts;
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
    const study::Answer answer = answered_alone(hull_with_fins(torque, GetParam(), 2));
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
    EXPECT_GT(limited_share(answer.solution, torque), 0.1);
  }
}

// Which limits hold is told by the last fall of the barrier. While a shorter duration still made the cost fall, so did the barrier
// by a little, which told nothing: limits were held that nothing pulls at, and a saddle was the answer.
TEST(ShortestTime, of_a_vehicle_holds_the_limits_that_hold_it) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/weak_motors.toml");
  problem.search.starts = 1;
  const study::Answer answer = answered_alone(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
}

INSTANTIATE_TEST_SUITE_P(Efforts, ShortestTimes, testing::Values(1.0, 1e-2, 1e-4), [](const auto& effort) {
  return effort.param == 1.0 ? "one" : effort.param == 1e-2 ? "hundredth" : "ten_thousandth";
});

}  // namespace
}  // namespace lamprey::tests
