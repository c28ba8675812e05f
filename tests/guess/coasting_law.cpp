// First guesses of starts in motion are motions: the whole goes where its momentum takes it while the joints turn, those that nothing
// drives as they do by themselves.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "guess/coasting.hpp"
#include "guess/guess.hpp"
#include "maneuver/motion.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

// A swimmer of three links that drifts and tumbles; with a last joint that nothing drives or none.
maneuver::Problem drifting(bool passive) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  problem.start.linear_velocity = Vector3d(0.1, -0.05, 0.0);
  problem.start.angular_velocity.assign(3, Vector3d(0.0, 0.0, 0.3));
  problem.goal->rest = false;
  problem.goal->move = {};
  if (passive) {
    problem.swimmer.joints[1].actuated = false;
    problem.swimmer.joints[1].stiffness = 0.05;
  }
  return problem;
}

TEST(Coasting, keeps_its_momentum_and_turns_joints_as_the_guess_does) {
  for (const bool passive : {false, true})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const maneuver::Problem problem = drifting(passive);
      const model::System system(problem.swimmer);
      const maneuver::Maneuver grid = maneuver::make_maneuver(system, problem, 100);
      const maneuver::NodePath guess = guess::random_guess(system, grid, seed);
      constexpr double share = 0.25;
      const auto path = guess::coasting(system, problem, guess, share);
      ASSERT_TRUE(path) << seed;
      maneuver::Solution moved;
      maneuver::describe_motion(system, grid.lagrangian, grid.time_step(), *path, moved);
      const auto& linear = moved.linear_momentum.total;
      const auto& angular = moved.angular_momentum.total;
      for (std::size_t k = 1; k < linear.size(); ++k) {
        EXPECT_LT((linear[k] - linear[0]).norm(), tolerance(1e-12) * linear[0].norm()) << k;
        EXPECT_LT((angular[k] - angular[0]).norm(), tolerance(1e-11) * linear[0].norm()) << k;
      }
      EXPECT_LT((linear[0] - grid.total.linear).norm(), tolerance(1e-12) * linear[0].norm());
      EXPECT_LT((angular[0] - grid.total.angular).norm(), tolerance(1e-12) * linear[0].norm());
      const maneuver::NodePath calm = guess::calmed(system, guess, share);
      for (int j = 0; j < (passive ? 1 : 2); ++j) {
        Vector3d turn = Vector3d::Zero();
        for (std::size_t k = 0; k < calm.rotation.size(); ++k) {
          const model::Joint& joint = system.joint(j);
          turn = mechanics::turn_from_zero(joint, mechanics::child_to_parent(calm.rotation[k], joint), turn);
          EXPECT_LT((moved.joint_angle[k][model::at(j)] - turn).norm(), 1e-9) << k;
        }
      }
      for (std::size_t k = 0; passive && k < path->control.size(); ++k)
        EXPECT_EQ(path->control[k].size(), 1) << "only what is driven has moments";
    }
}

TEST(Coasting, leads_nowhere_where_steps_follow_no_angles) {
  maneuver::Problem problem = drifting(false);
  const model::System system(problem.swimmer);
  const maneuver::NodePath guess = guess::random_guess(system, maneuver::make_maneuver(system, problem, 50), 1);
  problem.scheme = maneuver::Scheme::order4;
  EXPECT_FALSE(guess::coasting(system, problem, guess, 0.5));
}

}  // namespace
}  // namespace lamprey::tests
