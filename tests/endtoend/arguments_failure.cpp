// Numbers on the command line are what they look like, or refused.
#include <gtest/gtest.h>

#include "program.hpp"
#include "result/solution_file.hpp"

namespace lamprey::tests {
namespace {

TEST(WholeNumbers, beyond_what_they_may_be_are_refused) {
  const Folder folder;
  const auto refused = [&](const std::string& options, const std::string& words) {
    const ProgramRun run = lamprey(folder, "solve " + example("translation") + " --out " + (folder / "x ") + options);
    EXPECT_EQ(run.exit_code, 2) << options;
    EXPECT_NE(run.err.find(words), std::string::npos) << options << '\n' << run.err;
  };
  const std::string seeds = "; allowed: a whole number from 0 to 9223372036854775807";
  refused("--seed 99999999999999999999", "--seed: found 99999999999999999999" + seeds);
  refused("--seed 9223372036854775808", "--seed: found 9223372036854775808" + seeds);
  for (const char* wrong : {"-1", "1.5", "0x10", "+1", "ten", "\"\""}) refused(std::string("--seed ") + wrong, seeds);
  refused("--starts 1000001", "--starts: found 1000001; allowed: a whole number from 1 to 1000000");
  refused("--workers 0", "--workers: found 0; allowed: a whole number from 1 to 1024");
  refused("--keep 99999999999999999999", "--keep: found 99999999999999999999; allowed: a whole number from 1 to 1000");
}

// Zeros before a number make no other system of numbers of it.
TEST(WholeNumbers, with_zeros_before_them_are_the_same) {
  const Folder folder;
  const auto marched = [&](const std::string& options) {
    EXPECT_EQ(lamprey(folder, "simulate " + example("tumble") + " --duration 0.01 --perturb 0.1 --out " +
                                  (folder / "run") + " " + options)
                  .exit_code,
              0)
        << options;
    return result::read_solution(folder / "run").solution;
  };
  const maneuver::Solution plain = marched("--seed 10 --steps 12"), zeros = marched("--seed 010 --steps 0012");
  EXPECT_TRUE(plain.position == zeros.position && plain.rotation == zeros.rotation);
  EXPECT_FALSE(plain.rotation == marched("--seed 8 --steps 12").rotation);
  EXPECT_TRUE(marched("--seed 00 --steps 12").rotation == marched("--seed 0 --steps 12").rotation);
  marched("--seed 9223372036854775807 --steps 12");
}

TEST(Numbers, of_the_time_at_which_a_plan_is_taken_up_may_be_that_of_its_beginning) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "1"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --no-refinement --out " + (folder / "plan")).exit_code, 0);
  const std::string follow = "simulate " + problem + " --feedback " + (folder / "plan") + " --out ";
  EXPECT_EQ(lamprey(folder, follow + (folder / "untold")).exit_code, 0);
  const ProgramRun begin = lamprey(folder, follow + (folder / "told") + " --feedback-from 0");
  ASSERT_EQ(begin.exit_code, 0) << begin.err;
  EXPECT_EQ(result::read_solution(folder / "told").solution.rotation,
            result::read_solution(folder / "untold").solution.rotation);
  const ProgramRun before = lamprey(folder, follow + (folder / "none") + " --feedback-from -1");
  EXPECT_EQ(before.exit_code, 2);
  EXPECT_NE(before.err.find("--feedback-from: found -1; allowed: a number >= 0 (s)"), std::string::npos) << before.err;
}

}  // namespace
}  // namespace lamprey::tests
