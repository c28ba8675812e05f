// Searches on more steps than a machine holds are refused by what they would take, and how many it holds.
#include "study/enough_memory.hpp"

#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "model/input_error.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem with_steps(const std::string& example, int steps) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + example + ".toml");
  problem.steps = steps;
  return problem;
}

TEST(EnoughMemory, is_as_was_measured) {
  for (const auto& [example, measured] : {std::pair("translation", 36e3), std::pair("translation_in_space", 63e3)}) {
    const maneuver::Problem problem = with_steps(example, 1000);
    EXPECT_NEAR(study::bytes_of_search(model::System(problem.swimmer), problem) / 1000.0 / measured, 1.0, 0.3);
  }
}

TEST(EnoughMemory, is_told_with_the_steps_that_a_machine_holds) {
  const maneuver::Problem problem = with_steps("translation", 1'000'000);
  const model::System system(problem.swimmer);
  try {
    study::require_memory(system, problem, 1e9);
    FAIL() << "taken";
  } catch (const model::InputError& error) {
    EXPECT_EQ(error.key, "time.steps");
    EXPECT_NE(error.message.find("GB of memory"), std::string::npos) << error.message;
    EXPECT_NE(error.message.find("000 steps; choose fewer"), std::string::npos) << error.message;
  }
  EXPECT_NO_THROW(study::require_memory(system, problem, 1e12));
  EXPECT_GT(study::bytes_of_machine(), 1e8);
  const std::string words = study::short_of_memory(system, problem, 1e9);
  EXPECT_NE(words.find("GB of memory, of which this machine has 1 GB"), std::string::npos) << words;
  EXPECT_EQ(study::short_of_memory(system, problem, 1e12), "");
}

}  // namespace
}  // namespace lamprey::tests
