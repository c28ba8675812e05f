// Long chains of small links: their limits hold at many nodes at once, and little moments move them far.
#include <gtest/gtest.h>

#include <string>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem hard(const std::string& name) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/" + name + ".toml");
  problem.search.time_limit.reset();
  return problem;
}

maneuver::Problem eel_within_limits() { return hard("eel_within_limits"); }

study::Answer answered_without_refinement(const maneuver::Problem& problem) {
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

void expect_proved(const study::Answer& answer) {
  EXPECT_LE(answer.certificate.kkt, 1e-8) << answer.solution.message;
  ASSERT_TRUE(answer.certificate.limits && answer.certificate.second_order) << answer.solution.message;
  EXPECT_LE(answer.certificate.limits->violation, evidence::limit_mark);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
}

// Of rates and angles, whose set no landing finds: the barrier's answer stays.
TEST(LimitsOfLongChains, are_kept_by_a_proved_gait) {
  maneuver::Problem problem = eel_within_limits();
  for (auto& [joint, bounds] : problem.limits.angle) bounds = {{-0.6, 0.6}};
  problem.goal->move[0] = 0.12;
  expect_proved(answered_without_refinement(problem));
}

// Of rates alone, at nearly every node of some joints.
TEST(LimitsOfLongChains, of_rates_become_equalities_of_a_proved_gait) {
  maneuver::Problem problem = eel_within_limits();
  problem.limits.angle.clear();
  problem.goal->move[0] = 0.12;
  expect_proved(answered_without_refinement(problem));
}

// Its multipliers of rates and angles differ much from barrier to barrier: a weight that falls with it would let go of them.
TEST(LimitsOfLongChains, are_kept_in_short_steps) {
  expect_proved(answered_without_refinement(hard("snake_in_240_steps")));
}

}  // namespace
}  // namespace lamprey::tests
