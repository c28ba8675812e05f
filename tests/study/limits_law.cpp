// Answers within limits are proved however little effort counts, and bounds that no motion comes near change none.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem tried(const std::string& name) {
  return file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/" + name + ".toml");
}

study::Answer answered(const maneuver::Problem& problem) {
  study::SolveOptions options;
  options.refinement = false;  // other grids are no matter here
  return study::answer(model::System(problem.swimmer), problem, options);
}

// Multipliers are large beside the gradient of effort: weights of limits must not bring round-off into them.
TEST(Limits, that_pull_harder_than_effort_are_proved) {
  maneuver::Problem problem = tried("gait_at_least_transport_50");
  problem.search.starts = 1;
  for (const int seed : {1, 2, 3, 4}) {
    problem.search.seed = static_cast<unsigned>(seed);
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << seed << ": " << answer.solution.message;
    EXPECT_LT(answer.certificate.kkt, 5e-9) << seed;
  }
  EXPECT_EQ(answered(tried("vehicle_within_limits")).certificate.verdict, certificate::Verdict::proved);
}

// Steps as long as here show half a turn at most: rates of several turns a step are none that a motion could exceed.
TEST(Limits, of_rates_far_beyond_any_motion_change_nothing) {
  maneuver::Problem problem = tried("vehicle_within_limits");
  problem.limits = maneuver::Limits();
  const study::Answer free = answered(problem);
  ASSERT_EQ(free.certificate.verdict, certificate::Verdict::proved) << free.solution.message;
  for (const double bound : {60.0, 200.0, 2000.0}) {  // rad/s, at 0.06 s a step
    problem.limits.angular_velocity = bound;
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << bound << ": " << answer.solution.message;
    EXPECT_NEAR(answer.solution.cost / free.solution.cost, 1.0, 1e-8) << bound;
  }
}

}  // namespace
}  // namespace lamprey::tests
