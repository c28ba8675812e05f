#include "certificate/servo_replay.hpp"

#include <gtest/gtest.h>

#include "marched_answers.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

certificate::Replay led(const maneuver::Problem& problem, const maneuver::Solution& solution) {
  const model::System system(problem.swimmer);
  certificate::Replay replay;
  certificate::replay_with_servos(evidence::StoredMotion(system, problem, solution), replay);
  return replay;
}

void expect_order_two(const certificate::Replay& coarse, const certificate::Replay& fine) {
  EXPECT_NEAR(std::log2(coarse.servo_rotation_error / fine.servo_rotation_error), 2.0, 0.25);
  EXPECT_NEAR(std::log2(coarse.servo_position_error / fine.servo_position_error), 2.0, 0.25);
}

// Steps conserve momentum by their own rule, angles by the continuous one: both lead to one place as steps shorten.
TEST(ServoReplay, error_falls_with_the_square_of_the_step) {
  const auto of_chain = [](int count) {
    const MarchedAnswer answer = march(chain_problem(count, 0.2), smooth_moments(count, 60.0));
    return led(answer.problem, answer.solution);
  };
  expect_order_two(of_chain(80), of_chain(160));
}

// With total momentum, joints of every kind, springs, dampers, coupled inertia.
TEST(ServoReplay, error_falls_with_the_square_of_the_step_for_every_joint) {
  int seen = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto of_tree = [&](int count) {
      MarchedAnswer answer = any_tree(seed, integrator::Scheme::midpoint, count);
      for (model::JointDescription& joint : answer.problem.swimmer.joints) {  // which the march was not asked for
        joint.actuated = true;
        joint.control_axes.reset();
      }
      return led(answer.problem, answer.solution);
    };
    SCOPED_TRACE(seed);
    const certificate::Replay coarse = of_tree(200), fine = of_tree(400);
    if (fine.servo_rotation_error < 1e-10) continue;  // nothing moves beside the root
    expect_order_two(coarse, fine);
    ++seen;
  }
  EXPECT_GE(seen, 6);
}

// Freedoms that stay where they are need no servo.
TEST(ServoReplay, in_the_plane_asks_for_servos_in_the_plane) {
  const MarchedAnswer answer = march(chain_problem(40, 0.2), smooth_moments(40, 60.0, true));
  maneuver::Problem confined = answer.problem;
  for (model::JointDescription& joint : confined.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  EXPECT_EQ(led(confined, answer.solution).servo_position_error,
            led(answer.problem, answer.solution).servo_position_error);
}

TEST(ServoReplay, says_nothing_where_nothing_drives_a_joint) {
  MarchedAnswer answer = march(chain_problem(20, 0.2), smooth_moments(20, 60.0));
  EXPECT_FALSE(std::isnan(led(answer.problem, answer.solution).servo_rotation_error));
  answer.problem.swimmer.joints[1].control_axes = {Vector3d(0, 0, 1)};
  EXPECT_TRUE(std::isnan(led(answer.problem, answer.solution).servo_rotation_error));
  EXPECT_TRUE(std::isnan(led(answer.problem, answer.solution).servo_position_error));
}

}  // namespace
}  // namespace lamprey::tests
