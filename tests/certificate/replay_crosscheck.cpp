#include "certificate/replay.hpp"

#include <gtest/gtest.h>

#include "evidence/cost_check.hpp"
#include "maneuver/feedback.hpp"
#include "marched_answers.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using certificate::Replay;
using evidence::StoredMotion;

Replay replayed(const MarchedAnswer& answer) {
  const model::System system(answer.problem.swimmer);
  return certificate::replay(StoredMotion(system, answer.problem, answer.solution), {1e-12});
}

Replay replayed(int count) { return replayed(march(chain_problem(count, 0.2), smooth_moments(count, 60.0))); }

TEST(Replay, error_falls_with_the_square_of_the_step) {
  const Replay coarse = replayed(60);
  const Replay fine = replayed(120);
  EXPECT_NEAR(coarse.window, 0.05 * 0.2, 1e-9);
  EXPECT_NEAR(fine.window, coarse.window, 1e-9);
  EXPECT_NEAR(std::log2(coarse.rotation_error / fine.rotation_error), 2.0, tolerance(0.2));
  EXPECT_NEAR(std::log2(coarse.whole_rotation_error / fine.whole_rotation_error), 2.0, tolerance(0.2));
  EXPECT_NEAR(std::log2(coarse.whole_position_error / fine.whole_position_error), 2.0, tolerance(0.2));
  EXPECT_LT(fine.rotation_error, 1e-3);
}

TEST(Replay, finds_moments_that_were_not_the_ones) {
  MarchedAnswer answer = march(chain_problem(100, 0.2), smooth_moments(100, 60.0));
  const double right = replayed(answer).rotation_error;
  for (auto& u : answer.solution.control) u[0].z() *= 2.0;
  EXPECT_GT(replayed(answer).rotation_error, 10.0 * right);
}

TEST(Replay, of_a_rigid_drift_is_exact_and_nothing_grows) {
  maneuver::Problem problem = chain_problem(100, 1.0);
  problem.swimmer.bodies.resize(1);
  problem.swimmer.joints.clear();
  problem.swimmer.bodies[0].mass_matrix = Matrix3d::Identity();
  problem.swimmer.bodies[0].inertia_matrix = 2.0 * Matrix3d::Identity();
  problem.start.rotation.resize(1);
  problem.start.angular_velocity = {Vector3d::Zero()};
  problem.start.linear_velocity = Vector3d(1.0, -2.0, 0.5);
  const Replay replay = replayed(march(problem, NodeMoments(101)));
  EXPECT_LE(replay.whole_rotation_error, tolerance(1e-12));
  EXPECT_LE(replay.whole_position_error, tolerance(1e-12));
  EXPECT_LE(std::abs(replay.growth_rate), tolerance(1e-9));
}

// One body in the fluid gliding broadside on: its inertia makes this unstable (Munk's moment), at a rate known in
// closed form.
TEST(Replay, growth_rate_of_a_gliding_ellipsoid_is_the_known_one) {
  maneuver::Problem problem = chain_problem(4000, 40.0);
  problem.swimmer.bodies.resize(1);
  problem.swimmer.joints.clear();
  problem.swimmer.bodies[0].mass_matrix = Vector3d(1.0, 2.0, 2.0).asDiagonal();
  problem.swimmer.bodies[0].inertia_matrix = Vector3d(1.0, 1.5, 1.5).asDiagonal();
  problem.start.rotation.resize(1);
  problem.start.angular_velocity = {Vector3d::Zero()};
  problem.start.linear_velocity = Vector3d(0.8, 0.0, 0.0);  // along the long axis: the unstable direction
  const Replay replay = replayed(march(problem, NodeMoments(4001)));
  // θ'' J = V² (M_2 − M_1) M_1/M_2 θ at constant linear momentum
  const double rate = std::sqrt(0.8 * 0.8 * (2.0 - 1.0) * 1.0 / 2.0 / 1.5);
  EXPECT_NEAR(replay.growth_rate, rate, tolerance(0.01 * rate));
}

// The same motion in other seconds: windows, errors and growth are those of its own time.
TEST(Replay, does_not_depend_on_the_unit_of_time) {
  const auto of_duration = [](double duration) {
    return replayed(march(chain_problem(100, duration), smooth_moments(100, 60.0 / (duration * duration))));
  };
  const Replay second = of_duration(1.0);
  EXPECT_GT(second.growth_rate, 5.0);
  for (const double duration : {1e-3, 1e3}) {
    const Replay other = of_duration(duration);
    EXPECT_NEAR(other.window / duration, second.window, tolerance(1e-12));
    EXPECT_NEAR(other.growth_rate * duration, second.growth_rate, tolerance(1e-6));
    EXPECT_NEAR(other.rotation_error, second.rotation_error, tolerance(1e-6 * second.rotation_error));
  }
}

// A motion that feedback holds and that goes astray without it, in the hands of another integrator.
TEST(Replay, with_the_stored_gains_stays_with_an_unstable_motion) {
  maneuver::Problem problem = chain_problem(100, 1.0);
  const NodeMoments moments = smooth_moments(100, 60.0);
  MarchedAnswer answer = march(problem, moments);
  const model::System system(problem.swimmer);
  EXPECT_TRUE(std::isnan(replayed(answer).feedback_rotation_error)) << "no gains are stored";
  maneuver::Solution full = maneuver::simulate(
      system, problem,
      [&](double t) { return moments[static_cast<std::size_t>(std::lround(t / problem.time_step()))]; },
      maneuver::SimulateOptions{});
  answer.solution.feedback = maneuver::design_feedback(system, problem, full);
  const Replay held = replayed(answer);
  EXPECT_LT(held.feedback_rotation_error, 0.1 * held.whole_rotation_error);
  EXPECT_LT(held.feedback_rotation_error, 5e-3);
  for (MatrixXd& gain : answer.solution.feedback.gain) gain.setZero();
  EXPECT_NEAR(replayed(answer).feedback_rotation_error, held.whole_rotation_error, 1e-6);
}

// Each axis of a universal joint works by itself, as its nodes' powers have it.
TEST(Replay, works_by_drives) {
  int seen = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    MarchedAnswer answer = any_tree(seed, integrator::Scheme::trapezoid, 400);
    for (model::JointDescription& joint : answer.problem.swimmer.joints) {
      joint.actuated = true;  // which the march was not asked for
      joint.control_axes.reset();
    }
    answer.problem.cost_weights.work = 1.0;
    const model::System system(answer.problem.swimmer);
    if (system.drive_count() == system.joint_count()) continue;  // no universal joint
    const evidence::Powers powers = evidence::powers_of(StoredMotion(system, answer.problem, answer.solution));
    const double by_nodes = (powers.value.cwiseAbs() * powers.time).sum();
    EXPECT_NEAR(replayed(answer).work, by_nodes, tolerance(2e-3) * by_nodes) << seed;
    ++seen;
  }
  EXPECT_GE(seen, 4);
}

TEST(Replay, leaves_unset_what_leaves_all_bounds) {
  MarchedAnswer answer = march(chain_problem(20, 0.1), smooth_moments(20, 60.0));
  answer.solution.control[10][0].x() = 1e300;
  const Replay replay = replayed(answer);
  EXPECT_TRUE(std::isnan(replay.rotation_error));
  EXPECT_TRUE(std::isnan(replay.whole_rotation_error));
}

}  // namespace
}  // namespace lamprey::tests
