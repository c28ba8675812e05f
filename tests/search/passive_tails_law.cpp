// Gaits of fish whose tails nothing drives: next to their minima some motions, the phase above all, change hardly anything, and
// searches that do not see how idle moments bend creep along them.
#include <gtest/gtest.h>

#include <string>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "search/solve.hpp"

namespace lamprey::tests {
namespace {

struct Tail {
  double stiffness, damping;  // N m/rad, N m s/rad
  unsigned seed;
};

class PassiveTails : public testing::TestWithParam<Tail> {};

TEST_P(PassiveTails, beat_at_proved_minima_after_a_few_hundred_steps_of_the_search) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/passive_tail.toml");
  problem.steps = 100;
  problem.search.starts = 1;
  problem.search.seed = GetParam().seed;
  problem.swimmer.joints[1].stiffness = GetParam().stiffness;
  problem.swimmer.joints[1].damping = GetParam().damping;
  const model::System system(problem.swimmer);
  const maneuver::Solution solution = search::solve(system, problem, search::SolveOptions()).front();
  ASSERT_EQ(solution.status, maneuver::Status::optimal) << solution.message;
  EXPECT_LE(solution.solver.iterations, 800);
  certificate::Options options;
  options.replay = false;
  const certificate::Certificate proof = certificate::certify(system, problem, solution, options);
  EXPECT_EQ(proof.verdict, certificate::Verdict::proved);
}

INSTANTIATE_TEST_SUITE_P(Tails, PassiveTails,
                         testing::Values(Tail{0.5, 0.01, 1}, Tail{1.0, 0.01, 1}, Tail{1.0, 0.05, 2}, Tail{2.0, 0.01, 1},
                                         Tail{2.0, 0.01, 2}, Tail{2.0, 0.05, 1}, Tail{4.0, 0.05, 1}));

// A gait of seven links, three hinges driven and three on springs, tells penalties apart by powers of ten: too little does not show its Hessian definite, too much drowns what is
// small in round-off, and steps shifted for want of the right one creep.
class HalfDriven : public testing::TestWithParam<unsigned> {};

TEST_P(HalfDriven, swims_at_a_proved_minimum) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/half_driven_fish.toml");
  problem.search.seed = GetParam();
  const model::System system(problem.swimmer);
  const maneuver::Solution solution = search::solve(system, problem, search::SolveOptions()).front();
  ASSERT_EQ(solution.status, maneuver::Status::optimal) << solution.message;
  certificate::Options options;
  options.replay = false;
  const certificate::Certificate proof = certificate::certify(system, problem, solution, options);
  EXPECT_EQ(proof.verdict, certificate::Verdict::proved) << "stationary to " << proof.kkt;
}

INSTANTIATE_TEST_SUITE_P(Seeds, HalfDriven, testing::Range(1U, 5U));

}  // namespace
}  // namespace lamprey::tests
