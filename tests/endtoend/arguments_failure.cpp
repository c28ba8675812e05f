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

}  // namespace
}  // namespace lamprey::tests
