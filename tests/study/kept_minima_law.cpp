// More minima than the cheapest one: answers each of them, by rising cost, the same on any number of threads.
#include <gtest/gtest.h>

#include <cmath>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

study::Answer kept(int minima, int workers) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/rotation.toml");
  problem.steps = 200;
  problem.search.starts = 12;
  problem.search.keep = minima;
  search::SolveOptions options;
  options.refinement = false;
  options.workers = workers;
  return study::answer(model::System(problem.swimmer), problem, options);
}

TEST(KeptMinima, are_proved_distinct_and_by_rising_cost) {
  const study::Answer one = kept(1, 1), four = kept(4, 1);
  EXPECT_TRUE(one.others.empty());
  ASSERT_EQ(four.others.size(), 3U);
  EXPECT_EQ(four.solution.cost, one.solution.cost) << "the answer does not depend on how many are kept";
  double before = four.solution.cost;
  for (const study::Answer& other : four.others) {
    EXPECT_EQ(other.solution.status, maneuver::Status::optimal) << other.solution.message;
    EXPECT_EQ(other.certificate.verdict, certificate::Verdict::proved) << other.solution.message;
    EXPECT_FALSE(other.solution.feedback.gain.empty()) << "each can be followed";
    EXPECT_GT(other.solution.cost, before * (1.0 + 1e-6));
    before = other.solution.cost;
  }
}

TEST(KeptMinima, do_not_depend_on_the_number_of_threads) {
  const study::Answer alone = kept(3, 1), together = kept(3, 2);
  ASSERT_EQ(alone.others.size(), together.others.size());
  for (std::size_t n = 0; n < alone.others.size(); ++n)
    EXPECT_EQ(alone.others[n].solution.cost, together.others[n].solution.cost);
}

// Of one minimum there are no others, however many are asked for.
TEST(KeptMinima, are_no_more_than_there_are) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  problem.steps = 100;
  problem.search.starts = 4;
  problem.search.keep = 1000;
  search::SolveOptions options;
  options.refinement = false;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  EXPECT_LT(answer.others.size(), answer.solution.search.minima.size());
}

}  // namespace
}  // namespace lamprey::tests
