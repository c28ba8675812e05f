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
  for (model::JointDescription& joint : problem.swimmer.joints) joint.stiffness = 40.0;
  const model::System system(problem.swimmer);
  int named = 0;
  for (problem.search.seed = 1; problem.search.seed <= 8 && named == 0;
       ++problem.search.seed) {  // which guess ends there differs
    const study::Answer answer = study::answer(system, problem, {});
    double most = 0.0;
    for (const auto& R : answer.solution.rotation)
      for (std::size_t i = 1; i < 3; ++i) most = std::max(most, lie::rotation_angle(R[0].transpose() * R[i]));
    const std::string& message = answer.solution.message;
    const bool says_so = message.find("stands at half a turn") != std::string::npos;
    if (answer.solution.status == maneuver::Status::optimal) {
      EXPECT_FALSE(says_so) << message;
    } else if (most > M_PI - 1e-5) {
      EXPECT_TRUE(says_so) << message;
      EXPECT_NE(message.find("limits.swing"), std::string::npos) << message;
      ++named;
    }
  }
  EXPECT_GT(named, 0) << "other guesses are needed for this test";
}

}  // namespace
}  // namespace lamprey::tests
