// Two bodies on one joint, as people begin: solved from every first guess, and proved.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

study::Answer answered(const std::string& joint, const std::string& second, const std::string& goal, int steps,
                       int starts) {
  const std::string text = fmt::format(
      "schema = 1\nname = \"two bodies\"\n[fluid]\ndensity = 1000.0\n[[body]]\nname = \"a\"\nsemi_axes = [0.05, 0.02, "
      "0.03]\n[[body]]\nname = \"b\"\nsemi_axes = {}\n[[joint]]\n{}\nparent = \"a\"\nchild = \"b\"\nparent_offset = "
      "[-0.055, 0.0, 0.0]\nchild_offset = [0.055, 0.0, 0.0]\n[goal]\nrotation.a = {}\n[time]\nduration = 2.5\nsteps = "
      "{}\n[search]\nstarts = {}\n",
      second, joint, goal, steps, starts);
  const maneuver::Problem problem = file::parse_problem(text, "two_bodies.toml").problem;
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

void expect_proved(const study::Answer& answer, int starts) {
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_EQ(answer.solution.search.solved, starts);
}

// Steps reach, by their own error, more than a motion of one angle does.
TEST(TwoBodies, on_one_angle_are_proved_from_every_guess) {
  for (const char* joint :
       {"kind = \"hinge\"\naxis = [0.0, 0.0, 1.0]", "kind = \"ball\"\ncontrol_axes = [[0.0, 0.0, 1.0]]"})
    for (const char* second : {"[0.05, 0.02, 0.03]", "[0.035, 0.015, 0.02]"})
      expect_proved(answered(joint, second, "[0.0, 0.0, 0.1]", 100, 24), 24);
}

// Where it is too much to tell what moments reach the message says how many steps may.
TEST(TwoBodies, on_one_angle_in_few_steps_are_told_in_how_many_they_are_proved) {
  const auto folded = [](int steps) {
    const std::string text = fmt::format(
        "schema = 1\n[fluid]\ndensity = 1000.0\n[[body]]\nname = \"a\"\nsemi_axes = [0.12, 0.03, 0.05]\n[[body]]\nname "
        "= "
        "\"b\"\nsemi_axes = [0.2, 0.03, 0.05]\n[[joint]]\nkind = \"hinge\"\naxis = [0, 0, 1]\nparent = \"a\"\nchild = "
        "\"b\"\nparent_offset = [0.13, 0, 0]\nchild_offset = [-0.13, 0, 0]\n[goal]\nangle.b = 0.4\n[time]\nduration = "
        "1.0\nsteps = {}\n",
        steps);
    const maneuver::Problem problem = file::parse_problem(text, "folded.toml").problem;
    search::SolveOptions options;
    options.refinement = false;
    return study::answer(model::System(problem.swimmer), problem, options);
  };
  const study::Answer few = folded(30);
  EXPECT_EQ(few.certificate.verdict, certificate::Verdict::stationary) << few.solution.message;
  EXPECT_NE(few.solution.message.find("[time] steps = 200 may show it"), std::string::npos) << few.solution.message;
  expect_proved(folded(200), 1);
}

// In a twentieth of the steps of a slow motion little is reached of what brackets of moments reach.
TEST(TwoBodies, on_a_ball_joint_are_proved_in_few_steps_and_many) {
  for (const int steps : {50, 400, 800})
    expect_proved(answered("kind = \"ball\"", "[0.05, 0.02, 0.03]", "[0.0, 0.3, 0.2]", steps, 1), 1);
}

}  // namespace
}  // namespace lamprey::tests
