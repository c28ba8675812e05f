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
  const std::string& message = answer.solution.message;
  EXPECT_EQ(answer.solution.time.size(), static_cast<std::size_t>(steps) + 1);
  const bool optimal = answer.solution.status == maneuver::Status::optimal;
  EXPECT_TRUE(steps != 1 || !optimal) << message;
  EXPECT_TRUE(steps != 8 || optimal) << message;
  EXPECT_EQ(optimal, answer.certificate.verdict != certificate::Verdict::not_optimal) << message;
  const auto says = [&](const char* words) { return message.find(words) != std::string::npos; };
  EXPECT_TRUE(optimal ? says("may be too few") : says("missed by") || says("no motion was found")) << message;
}

std::string name_of(const testing::TestParamInfo<std::tuple<const char*, int>>& info) {
  return std::string(std::get<0>(info.param)) + "_in_" + std::to_string(std::get<1>(info.param));
}

INSTANTIATE_TEST_SUITE_P(Examples, FewSteps,
                         testing::Combine(testing::Values("translation", "rotation", "gait"),
                                          testing::Values(1, 2, 3, 4, 5, 8)),
                         name_of);

}  // namespace
}  // namespace lamprey::tests
