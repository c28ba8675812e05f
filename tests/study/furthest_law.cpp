// Gaits that go as far as it pays.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

// Of small strokes what they win and what they cost are of one order in their size: there a search may stay at hardly any.
TEST(FurthestGaits, are_more_than_the_least_strokes_that_pay) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_two_arms.toml");
  problem.cost_weights.displacement[0] = 1e3;
  study::SolveOptions options;
  options.refinement = false;
  for (const std::uint64_t seed : {1U, 3U}) {
    problem.search.seed = seed;
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
    EXPECT_LT(answer.solution.cost, -0.6) << "−0.704 by other seeds, −0.0165 where strokes are least";
  }
}

}  // namespace
}  // namespace lamprey::tests
