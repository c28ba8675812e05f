// Motions that go on by themselves, and what nothing drives.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

study::Answer answer_to(const char* name, int starts) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/" + name + ".toml");
  problem.search.starts = starts;
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// Its moments are round-off, and no gradient to measure stationarity by: at no cost it was set aside for one of 0.17 (N m)² s.
TEST(Coasting, costs_nothing_and_is_an_answer) {
  const study::Answer answer = answer_to("spin_that_costs_nothing", 4);
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_LE(answer.solution.cost, 1e-20);
  EXPECT_LE(answer.certificate.kkt, 1e-8);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_EQ(answer.solution.message.find("cheaper"), std::string::npos) << answer.solution.message;
}

// Parts of the way are done several times where joints that nothing drives have to come to rest after each, too.
TEST(PassiveStrokes, get_where_no_single_one_does) {
  const study::Answer answer = answer_to("strokes_beside_a_passive_tip", 1);
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_GT(answer.solution.search.strokes, 0);
  EXPECT_LE(answer.certificate.goal_error, 1e-9);
}

}  // namespace
}  // namespace lamprey::tests
