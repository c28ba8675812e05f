// A search that ends where a spring's moment jumps says so.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

TEST(Springs, that_stand_at_half_a_turn_are_named) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/rotation.toml");
  problem.steps = 100;
  problem.search.starts = 1;
  problem.search.seed = 3;
  for (model::JointDescription& joint : problem.swimmer.joints) joint.stiffness = 40.0;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  double most = 0.0;
  for (const auto& R : answer.solution.rotation)
    for (std::size_t i = 1; i < 3; ++i) most = std::max(most, lie::rotation_angle(R[0].transpose() * R[i]));
  ASSERT_GT(most, M_PI - 1e-5) << "another guess is needed for this test";
  EXPECT_EQ(answer.solution.status, maneuver::Status::feasible);
  EXPECT_NE(answer.solution.message.find("joint front stands at half a turn"), std::string::npos)
      << answer.solution.message;
  EXPECT_NE(answer.solution.message.find("limits.swing"), std::string::npos) << answer.solution.message;
}

}  // namespace
}  // namespace lamprey::tests
