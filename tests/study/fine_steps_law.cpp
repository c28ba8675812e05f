// Steps so fine that a file's last digits are more of a moment than the tolerance: an answer is one all the same.
#include <gtest/gtest.h>

#include "certificate/verdict.hpp"
#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

study::Answer turned(int steps, double duration, int starts, double smoothness = 0.0) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/yaw.toml");
  problem.steps = steps;
  problem.duration.value = duration;
  problem.search.starts = starts;
  problem.search.hops = 0;
  problem.cost_weights.smoothness = smoothness;
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// Moments fall with the square of a longer duration as fast as their last digits do: what counts is the number of steps.
TEST(FineSteps, leave_moments_fewer_digits_by_the_square_of_their_number) {
  const auto round_off = [](int steps, double duration) {
    return turned(steps, duration, 8)
        .certificate.kkt_round_off;  // of the best minimum: single guesses may end at others
  };
  const double few = round_off(100, 1.0);
  EXPECT_GT(few, 0.0);
  EXPECT_NEAR(round_off(200, 1.0) / few, 4.0, 0.2);
  EXPECT_NEAR(round_off(100, 5.0) / few, 1.0, 0.05);
}

TEST(FineSteps, are_asked_for_no_more_than_their_digits_hold) {
  const study::Answer answer = turned(4000, 1.0, 1);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  maneuver::Problem problem;
  problem.goal.emplace();
  certificate::Certificate proof = answer.certificate;
  problem.search.tolerance = 0.5 * proof.kkt;
  EXPECT_TRUE(certificate::stationary(problem, proof)) << proof.kkt << " is more than " << proof.kkt_round_off;
  proof.kkt_round_off = 0.25 * proof.kkt;
  EXPECT_FALSE(certificate::stationary(problem, proof));
  EXPECT_LE(answer.certificate.kkt_round_off, optimality::proof_mark);
}

// Smoothness takes second differences of the moments, whose last digits grow with the fourth power of the number of steps.
TEST(FineSteps, of_smooth_moments_are_asked_for_no_more_than_their_digits_hold) {
  std::vector<double> round_off;
  for (const int steps : {100, 200, 400, 800}) {
    const study::Answer answer = turned(steps, 1.0, 1, 1.0);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << steps << ": " << answer.solution.message;
    round_off.push_back(answer.certificate.kkt_round_off);
  }
  EXPECT_GT(round_off[1] / round_off[0], 8.0);
  EXPECT_GT(round_off[2] / round_off[1], 8.0);
}

}  // namespace
}  // namespace lamprey::tests
