// Searches by Ipopt, whose linear solver keeps global data, from several threads of one process.
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

study::Answer solved_by_ipopt(int workers) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  problem.steps = 40;
  problem.search.starts = 2;
  search::SolveOptions options;
  options.refinement = false;
  options.workers = workers;
  options.solver = search::Backend::ipopt;
  return study::answer(model::System(problem.swimmer), problem, options);
}

TEST(IpoptThreads, find_what_one_finds_with_and_without_processes_of_their_own) {
  const double cost = solved_by_ipopt(1).solution.cost;
  for (const int workers : {1, 2}) {
    std::vector<double> costs(3, 0.0);
    {
      std::vector<std::jthread> threads;
      for (double& own : costs) threads.emplace_back([&own, workers] { own = solved_by_ipopt(workers).solution.cost; });
    }
    for (const double own : costs) EXPECT_NEAR(own / cost, 1.0, 1e-9) << workers << " workers";
  }
}

}  // namespace
}  // namespace lamprey::tests
