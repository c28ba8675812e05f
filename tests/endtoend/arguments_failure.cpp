// Numbers on the command line are what they look like, or refused.
#include <fmt/format.h>
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

// Plain lines of usage, and nothing of what the parser of arguments would add.
TEST(Help, is_for_people_and_fits_a_hundred_columns) {
  const Folder folder;
  const std::string whole = lamprey(folder, "--help").out;
  EXPECT_EQ(whole.rfind("Usage: lamprey COMMAND [options]\n\nOptimal maneuvers and gaits", 0), 0U) << whole;
  EXPECT_NE(whole.find("Exit codes: 0 done"), std::string::npos);
  for (const auto& [command, usage] :
       {std::pair("solve", "PROBLEM --out DIR [options]"), std::pair("simulate", "PROBLEM --out DIR [options]"),
        std::pair("check", "PROBLEM"), std::pair("verify", "DIR [options]"), std::pair("report", "DIR [DIR2]"),
        std::pair("export", "DIR"), std::pair("inertia", "--semi-axes A B [C] --density D [options]"),
        std::pair("bench", "[options]")}) {
    const std::string help = lamprey(folder, std::string(command) + " --help").out;
    EXPECT_EQ(help.rfind(fmt::format("Usage: lamprey {} {}\n", command, usage), 0), 0U) << help;
    for (const char* other : {"Exit codes", "{false}", "Excludes", "Needs", "INT", "TEXT", "FLOAT", "REQUIRED", "(1x)"})
      EXPECT_EQ(help.find(other), std::string::npos) << command << ": " << other;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) {
      const auto letters = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      EXPECT_LE(letters, 100) << line;
    }
  }
  EXPECT_NE(lamprey(folder, "solve --help").out.find("\n  --[no-]refinement  "), std::string::npos);
}

TEST(Refusals, say_what_to_give) {
  const Folder folder;
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const ProgramRun run = lamprey(folder, arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_NE(run.err.find(words), std::string::npos) << arguments << '\n' << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  };
  refused("", "lamprey: give a command, one of solve, simulate, ");
  refused("report", "lamprey report: give one result folder, or two to compare\n");
  refused("report a b c", "lamprey report: give one result folder, or two to compare\n");
  refused("solve", "lamprey solve: give a problem file (TOML) and --out DIR (folder for the results: ");
  refused("solve x.toml", "lamprey solve: give --out DIR (folder");
  refused("solve x.toml --out", "lamprey solve: give --out DIR (folder");
  refused("verify a b", "lamprey verify: found \"b\" beyond what it takes; usage: lamprey verify DIR [options]");
  refused("solve x.toml --out y --solver newtom", "--solver: found newtom; allowed: newton, ipopt, both");
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
