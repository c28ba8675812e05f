// Searches that springs and dampers lead astray say so.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "lie/so3.hpp"
#include "study/answer.hpp"
#include "study/verdict.hpp"

namespace lamprey::tests {
namespace {

// Searches may end there, which ones differs from one processor to the next: a motion made up that does.
TEST(Springs, that_stand_at_half_a_turn_are_named) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/rotation.toml");
  problem.steps = 20;
  const model::System system(problem.swimmer);
  const std::size_t child = static_cast<std::size_t>(system.joint(1).child);
  certificate::Certificate proof;
  proof.equation_residual = 0.1;
  const auto told = [&](double most) {
    maneuver::Solution solution;
    for (int k = 0; k <= problem.steps; ++k) {
      solution.time.push_back(0.05 * k);
      solution.rotation.emplace_back(problem.swimmer.bodies.size(), Eigen::Matrix3d::Identity());
      solution.rotation.back()[child] = lie::exp(Eigen::Vector3d(0.0, most * std::sin(M_PI * k / problem.steps), 0.0));
    }
    study::judge(problem, proof, solution);
    EXPECT_NE(solution.status, maneuver::Status::optimal);
    return solution.message;
  };
  EXPECT_EQ(told(M_PI).find("stands at half a turn"), std::string::npos) << "without a spring: " << told(M_PI);
  problem.swimmer.joints[1].stiffness = 40.0;
  const std::string message = told(M_PI);
  EXPECT_NE(message.find("At 0.5 s joint " + problem.swimmer.joints[1].name + " stands at half a turn"),
            std::string::npos)
      << message;
  EXPECT_NE(message.find("limits.swing"), std::string::npos) << message;
  EXPECT_EQ(told(3.0).find("stands at half a turn"), std::string::npos) << told(3.0);
  problem.swimmer.joints[1].reference_rotation =
      Eigen::Vector3d(0.0, 3.0 - M_PI, 0.0);  // where the spring has no moment
  EXPECT_NE(told(3.0).find("stands at half a turn"), std::string::npos) << told(3.0);
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
