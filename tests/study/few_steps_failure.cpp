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

// Parts are searched on steps of their own: the whole has those that were asked for.
TEST(FewSteps, of_goals_in_parts_are_those_asked_for) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/three_hinges.toml");
  problem.start.rotation.assign(3, Eigen::Vector3d::Zero());
  problem.goal->move = {};
  problem.goal->turn = Eigen::Vector3d(0.0, 0.0, 0.3);
  for (const char* joint : {"b1", "b2"}) problem.limits.angle[joint] = {{-0.6, 0.6}};
  problem.duration.value = 8.0;
  problem.search.starts = 1;
  search::SolveOptions options;
  options.refinement = false;
  for (const int steps : {48, 80}) {
    problem.steps = steps;
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_EQ(answer.solution.time.size(), static_cast<std::size_t>(steps) + 1);
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  }
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
