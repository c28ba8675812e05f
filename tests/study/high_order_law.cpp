// Maneuvers by schemes above order 2: searched to the end, proved, and those of fine steps of order 2.
#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "certificate/claims.hpp"
#include "file/problem_file.hpp"
#include "integrator/scheme.hpp"
#include "search/solve.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Problem;
using maneuver::Scheme;

Problem from_one_guess(const std::string& example, Scheme scheme, int steps) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + example + ".toml");
  problem.scheme = scheme;
  problem.steps = steps;
  problem.rule.reset();
  problem.search.starts = 1;
  problem.search.hops = 0;
  problem.search.seed = 3;
  return problem;
}

study::Answer proved(const Problem& problem) {
  study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.equation_residual, tolerance(1e-10));
  EXPECT_LE(answer.certificate.kkt, tolerance(1e-8));
  const auto& history = answer.solution.solver.history;
  EXPECT_LE(history.back().kkt, tolerance(1e-2)) << "a Newton step from there, and steps with its factors, do the rest";
  for (const maneuver::SolverIteration& iterate : history) EXPECT_LT(iterate.kkt, 1e3) << iterate.iteration;
  return answer;
}

class HighOrder : public testing::TestWithParam<Scheme> {};

TEST_P(HighOrder, finds_the_minima_of_fine_steps_of_order_2) {
  for (const char* example : {"translation", "rotation", "translation_in_space"}) {
    SCOPED_TRACE(example);
    const study::Answer fine = proved(from_one_guess(example, Scheme::trapezoid, 1000));
    const study::Answer high = proved(from_one_guess(example, GetParam(), 50));
    EXPECT_NEAR(high.solution.cost / fine.solution.cost, 1.0, 2e-4);
    ASSERT_TRUE(high.certificate.second_order && fine.certificate.second_order);
    EXPECT_NEAR(high.certificate.second_order->smallest_eigenvalue / fine.certificate.second_order->smallest_eigenvalue,
                1.0, 0.01);
    ASSERT_EQ(high.certificate.all_axes.has_value(), fine.certificate.all_axes.has_value());
    if (!high.certificate.all_axes) continue;
    EXPECT_EQ(high.certificate.all_axes->second_order.negative_eigenvalues,
              fine.certificate.all_axes->second_order.negative_eigenvalues);
    EXPECT_NEAR(high.certificate.all_axes->second_order.smallest_eigenvalue /
                    fine.certificate.all_axes->second_order.smallest_eigenvalue,
                1.0, 0.01);
  }
}

TEST_P(HighOrder, has_its_own_order_on_other_grids) {
  Problem problem = from_one_guess("translation", GetParam(), 60);
  problem.time_weight = 500.0;  // a second costs so much, whatever the grid
  search::SolveOptions options;
  options.refinement = true;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  ASSERT_TRUE(answer.certificate.refinement);
  const int order = integrator::order(GetParam());
  EXPECT_NEAR(answer.certificate.refinement->observed_order, order, 0.2 * order) << answer.solution.message;
  EXPECT_LT(answer.certificate.refinement->cost_error, 1e-4 * answer.solution.cost);
  problem.time_weight = 0.0;
  const study::Answer timeless = study::answer(model::System(problem.swimmer), problem, options);
  EXPECT_NEAR(answer.solution.cost - timeless.solution.cost, 500.0 * problem.duration.value,
              1e-9 * answer.solution.cost);
}

TEST_P(HighOrder, is_verified_with_its_feedback) {
  const Problem problem = from_one_guess("translation", GetParam(), 30);
  const study::Answer answer = proved(problem);
  ASSERT_TRUE(answer.certificate.replay);
  EXPECT_LT(answer.certificate.replay->feedback_rotation_error, 1e-4);  // moments linear between nodes leave more
  const certificate::Certificate found = certificate::certify(model::System(problem.swimmer), problem, answer.solution);
  for (const certificate::FalseClaim& claim :
       certificate::false_claims(answer.certificate, found, answer.solution.time.back(), 1.0))
    ADD_FAILURE() << claim.field << " is " << claim.found << ", not " << claim.stored;
}

TEST_P(HighOrder, knows_springs_and_dampers) {
  const auto sprung = [](Scheme scheme, int steps) {
    Problem problem = from_one_guess("translation", scheme, steps);  // joints bend by less than half a turn
    for (model::JointDescription& joint : problem.swimmer.joints) {
      joint.stiffness = 40.0;
      joint.damping = 2.0;
    }
    return problem;
  };
  const study::Answer fine = proved(sprung(Scheme::trapezoid, 1000)), high = proved(sprung(GetParam(), 50));
  EXPECT_NEAR(high.solution.cost / fine.solution.cost, 1.0, 1e-3);
}

// From these guesses a valley leads to the minimum; steps are long there, and what they leave of the polynomials' equations is
// worth as much as what they win. Judged by the cost alone they were refused, and searches crept or stood still.
TEST(HighOrderSearch, does_not_creep_along_valleys) {
  const auto search = [](const char* example, unsigned seed, int iterations) {
    SCOPED_TRACE(example + std::string(" from seed ") + std::to_string(seed));
    Problem problem = from_one_guess(example, Scheme::order4, 50);
    problem.search.seed = seed;
    const maneuver::Solution found = search::solve(model::System(problem.swimmer), problem, {}).front();
    EXPECT_EQ(found.status, maneuver::Status::optimal) << found.message;
    EXPECT_LE(found.solver.iterations, iterations);
  };
  search("rotation", 27, 300);              // 482 before, 103 on the coarse grid
  search("rotation", 51, 200);              // 485
  search("translation_in_space", 43, 300);  // 1,048
  search("translation_in_space", 97, 300);  // 486
}

INSTANTIATE_TEST_SUITE_P(Schemes, HighOrder, testing::Values(Scheme::order4, Scheme::order6), [](const auto& scheme) {
  return std::string(scheme.param == Scheme::order4 ? "order4" : "order6");
});

}  // namespace
}  // namespace lamprey::tests
