// Searches that springs and dampers lead astray say so.
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

// Stages that go back in time have a pole where they are as long as 2J/c (chapter 8): no motion by order4 in these steps.
TEST(Springs, with_dampers_too_strong_for_stages_back_in_time_are_advised_to_take_the_midpoint) {
  std::string text = "schema = 1\nname = \"fish\"\n[fluid]\ndensity = 1000.0\n";
  const char* sizes[] = {"[0.06, 0.02, 0.03]", "[0.055, 0.017, 0.03]", "[0.05, 0.014, 0.03]", "[0.045, 0.011, 0.03]"};
  const double half[] = {0.063, 0.058, 0.053, 0.048};
  for (int i = 0; i < 4; ++i) text += "[[body]]\nname = \"b" + std::to_string(i) + "\"\nsemi_axes = " + sizes[i] + "\n";
  for (int i = 1; i < 4; ++i)
    text += "[[joint]]\nkind = \"hinge\"\nparent = \"b" + std::to_string(i - 1) + "\"\nchild = \"b" +
            std::to_string(i) + "\"\nparent_offset = [" + std::to_string(-half[i - 1]) + ", 0, 0]\nchild_offset = [" +
            std::to_string(half[i]) + ", 0, 0]\naxis = [0, 0, 1]\nstiffness = 0.2\ndamping = 0.02\n";
  text += "[goal]\nmove = [0.05, \"free\", \"free\"]\nturn = [0, 0, 0]\n[time]\nduration = 1.5\nsteps = 40\n";
  const auto answered = [&](const std::string& scheme) {
    const maneuver::Problem problem =
        file::parse_problem(text + "[integrator]\nscheme = \"" + scheme + "\"\n", "fish.toml").problem;
    return study::answer(model::System(problem.swimmer), problem, {}).solution;
  };
  const maneuver::Solution composed = answered("order4");
  EXPECT_NE(composed.status, maneuver::Status::optimal);
  EXPECT_NE(composed.message.find("scheme = \"midpoint\""), std::string::npos) << composed.message;
  EXPECT_EQ(answered("midpoint").status, maneuver::Status::optimal);
}

}  // namespace
}  // namespace lamprey::tests
