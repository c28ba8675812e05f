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

// Two links on a hinge: the second one's half lengths, where the hinge is in each, and the tables of goal and limits.
study::Answer on_a_hinge(const std::string& second, double on_first, double on_second, const std::string& asked,
                         int steps) {
  const std::string text = fmt::format(
      "schema = 1\n[fluid]\ndensity = 1000.0\n[[body]]\nname = \"a\"\nsemi_axes = [0.12, 0.03, 0.05]\n[[body]]\nname = "
      "\"b\"\nsemi_axes = {}\n[[joint]]\nkind = \"hinge\"\naxis = [0, 0, 1]\nparent = \"a\"\nchild = "
      "\"b\"\nparent_offset "
      "= [{}, 0, 0]\nchild_offset = [{}, 0, 0]\n[time]\nduration = 1.0\nsteps = {}\n{}",
      second, on_first, on_second, steps, asked);
  const maneuver::Problem problem = file::parse_problem(text, "two_links.toml").problem;
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// In few steps parts of the motion do not show what moments reach, and the whole does.
TEST(TwoBodies, on_one_angle_are_proved_in_few_steps_as_in_many) {
  const auto folded = [](int steps) {
    return on_a_hinge("[0.2, 0.03, 0.05]", 0.13, -0.13, "[goal]\nangle.b = 0.4\n", steps);
  };
  const study::Answer few = folded(30), many = folded(200);
  expect_proved(few, 1);
  expect_proved(many, 1);
  EXPECT_NEAR(few.certificate.second_order->smallest_eigenvalue, many.certificate.second_order->smallest_eigenvalue,
              1e-2);
}

// In a twentieth of the steps of a slow motion little is reached of what brackets of moments reach.
TEST(TwoBodies, on_a_ball_joint_are_proved_in_few_steps_and_many) {
  for (const int steps : {50, 400, 800})
    expect_proved(answered("kind = \"ball\"", "[0.05, 0.02, 0.03]", "[0.0, 0.3, 0.2]", steps, 1), 1);
}

// What short strokes reach by the brackets of their moments shows in their whole length, if not in parts of it.
TEST(TwoBodies, on_a_hinge_are_proved_however_short_the_way) {
  for (const double way : {-0.005, -0.01, -0.02}) {
    const std::string asked =
        fmt::format("[goal]\nmove = [{}, \"free\", \"free\"]\n[limits]\nangle.b = [-2.0, 2.0]\n", way);
    const study::Answer answer = on_a_hinge("[0.08, 0.02, 0.05]", -0.13, 0.09, asked, 100);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << way << answer.solution.message;
  }
}

}  // namespace
}  // namespace lamprey::tests
