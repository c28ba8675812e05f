// What a march has reached can be read back, however it ended and however few its nodes are.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "file/solution_file.hpp"
#include "file/tasks.hpp"

namespace lamprey::tests {
namespace {

file::ProblemFile spline_problem() {
  return file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/paper_scheme/rotation.toml");
}

void expect_read_back(const file::Results& results) {
  const std::string text = file::solution_text(results);
  const file::Results back = file::parse_solution(text, "x");
  EXPECT_EQ(file::solution_text(back), text);
  EXPECT_EQ(back.problem.steps + 1, static_cast<int>(back.solution.time.size()));
}

TEST(MarchedResults, with_fewer_nodes_than_the_splines_points_are_read_back) {
  file::MarchOptions options;
  options.steps = 5;
  const file::Results results = file::march_task(spline_problem(), options, "");
  EXPECT_EQ(results.solution.status, maneuver::Status::simulated);
  expect_read_back(results);
}

TEST(MarchedResults, of_an_interrupted_march_are_read_back) {
  for (int most : {0, 1, 7}) {
    int asked = 0;
    file::MarchOptions options;
    options.interrupted = [&] { return asked++ >= most; };
    const file::Results results = file::march_task(spline_problem(), options, "");
    EXPECT_EQ(results.solution.status, maneuver::Status::interrupted);
    expect_read_back(results);
  }
}

TEST(MarchedResults, of_a_free_duration_say_which_was_taken) {
  const file::ProblemFile problem =
      file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/free_time.toml");
  file::MarchOptions options;
  options.steps = 5;
  const auto tells = [&] {
    return file::march_task(problem, options, "").solution.message.find("The duration is free") != std::string::npos;
  };
  EXPECT_TRUE(tells());
  options.duration = 1.0;
  EXPECT_FALSE(tells());
}

}  // namespace
}  // namespace lamprey::tests
