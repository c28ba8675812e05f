// Grids too coarse for a maneuver end with a status and its reason.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

class FewSteps : public testing::TestWithParam<std::tuple<const char*, int>> {};

TEST_P(FewSteps, end_with_a_status) {
  const auto [name, steps] = GetParam();
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + name + ".toml");
  problem.steps = steps;
  problem.search.starts = 1;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_FALSE(answer.solution.message.empty());
  EXPECT_EQ(answer.solution.time.size(), static_cast<std::size_t>(steps) + 1);
  const bool optimal = answer.solution.status == maneuver::Status::optimal;
  EXPECT_TRUE(!optimal || answer.certificate.goal_error <= certificate::goal_mark);
}

INSTANTIATE_TEST_SUITE_P(Examples, FewSteps,
                         testing::Combine(testing::Values("translation", "rotation", "gait"),
                                          testing::Values(1, 2, 3, 4, 5, 8)));

}  // namespace
}  // namespace lamprey::tests
