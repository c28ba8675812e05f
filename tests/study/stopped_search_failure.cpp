// Searches that are made to stop end with what there is, or with the exception of who stops them.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Problem;

Problem translation(int steps) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  problem.steps = steps;
  problem.search.starts = 4;
  return problem;
}

TEST(StoppedSearch, ends_with_an_exception_of_its_threads_whatever_their_number) {
  const Problem problem = translation(20);
  const model::System system(problem.swimmer);
  for (int workers : {1, 2, 4}) {
    study::SolveOptions options;
    options.workers = workers;
    options.progress = [](const std::string&) { throw std::out_of_range("told"); };
    EXPECT_THROW(study::solve(system, problem, options), std::out_of_range) << workers << " workers";
  }
}

}  // namespace
}  // namespace lamprey::tests
