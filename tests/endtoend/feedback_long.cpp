// The rotation as it is, followed whole by the independent integrator of the continuous equations.
#include <gtest/gtest.h>

#include "solved_example.hpp"

namespace lamprey::tests {
namespace {

// Largest angle between the ends of two motions' bodies, rad.
double apart(const maneuver::Solution& a, const maneuver::Solution& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.rotation.back().size(); ++i)
    largest = std::max(largest, lie::rotation_angle(a.rotation.back()[i].transpose() * b.rotation.back()[i]));
  return largest;
}

TEST(FollowingLong, rotation_from_perturbed_starts_ends_at_its_goal_and_without_feedback_nowhere_near) {
  const Folder folder;
  const std::string solved = folder / "solved";
  ASSERT_EQ(lamprey(folder, "solve " + example("rotation") + " --out " + solved).exit_code, 0);
  const result::Results plan = result::read_solution(solved);
  EXPECT_LE(plan.certificate->replay->feedback_rotation_error, tolerance(1e-4));
  EXPECT_LE(plan.certificate->replay->servo_rotation_error, tolerance(1e-4));
  EXPECT_LE(plan.certificate->replay->servo_position_error, tolerance(1e-4));
  EXPECT_GE(plan.certificate->replay->growth_rate, 20.0);
  const auto marched = [&](const std::string& how, const std::string& seed) {
    const ProgramRun run = lamprey(folder, "simulate " + example("rotation") + " --reference --perturb 1e-3 --seed " +
                                               seed + " " + how + " --out " + (folder / "run"));
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return result::read_solution(folder / "run").solution;
  };
  for (const char* seed : {"1", "2", "3", "4", "5"}) {
    const maneuver::Solution held = marched("--feedback " + solved, seed);
    EXPECT_LE(apart(held, plan.solution), tolerance(1e-2)) << "seed " << seed;
    EXPECT_NEAR(held.tracking->rotation_error, apart(held, plan.solution), 1e-12);
    EXPECT_GT(apart(marched("--controls " + solved + "/solution.json", seed), plan.solution), 0.1) << "seed " << seed;
  }
}

}  // namespace
}  // namespace lamprey::tests
