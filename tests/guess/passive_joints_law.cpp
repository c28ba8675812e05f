// Joints without motors follow: nothing moves them but springs, dampers and inertia, and the others go as they were told.
#include "guess/passive_joints.hpp"

#include <gtest/gtest.h>

#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "printed.hpp"
#include "shape/shape_program.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

// Head, middle and a fluke that no motor moves.
maneuver::Problem with_fluke(model::JointKind kind, double spring, double damper) {
  maneuver::Problem problem;
  problem.swimmer.density = 1000.0;
  problem.swimmer.bodies.resize(3);
  const std::array names = {"head", "middle", "fluke"};
  const std::array<Vector3d, 3> axes = {Vector3d(0.25, 0.06, 0.1), Vector3d(0.12, 0.04, 0.08),
                                        Vector3d(0.08, 0.02, 0.12)};
  for (std::size_t i = 0; i < 3; ++i) {
    problem.swimmer.bodies[i].name = names[i];
    problem.swimmer.bodies[i].semi_axes = axes[i];
    if (i == 0) continue;
    model::JointDescription joint;
    joint.name = names[i];
    joint.kind = i == 2 ? kind : model::JointKind::hinge;
    joint.parent = names[i - 1];
    joint.child = names[i];
    joint.parent_offset = Vector3d(-axes[i - 1][0] - 0.01, 0.0, 0.0);
    joint.child_offset = Vector3d(axes[i][0] + 0.01, 0.0, 0.0);
    if (joint.kind == model::JointKind::hinge) joint.axis = Vector3d(0, 0, 1);
    joint.actuated = i == 1;
    if (i == 2) {
      joint.stiffness = spring;
      joint.damping = damper;
    }
    problem.swimmer.joints.push_back(joint);
  }
  problem.start.rotation = {Vector3d(0.1, 0.2, -0.1), Vector3d(0.1, 0.2, -0.1), Vector3d(0.1, 0.2, -0.1)};
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.goal = maneuver::Goal();
  problem.goal->move[0] = 0.03;
  problem.duration.value = 2.0;
  return problem;
}

class Fluke : public ::testing::TestWithParam<std::tuple<model::JointKind, double, double>> {};

TEST_P(Fluke, feels_no_moment_while_the_other_joint_goes_as_planned) {
  const auto& [kind, spring, damper] = GetParam();
  const maneuver::Problem problem = with_fluke(kind, spring, damper);
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 80);
  const maneuver::ShapeCoordinates coordinates(system);
  const maneuver::NodePath guess = guess::random_guess(system, maneuver, 3);
  const auto followed = guess::with_passive_joints(system, maneuver, coordinates, guess);
  ASSERT_TRUE(followed);
  shape::ShapeProgram program(system, maneuver, coordinates, {}, {}, shape::Steps::rough);
  ASSERT_TRUE(program.go_to(guess));
  EXPECT_GT(program.merit().violation, 1e-3) << "a fluke held as it was needs moments";
  ASSERT_TRUE(program.go_to(*followed));
  EXPECT_LE(program.merit().violation, tolerance(1e-8)) << "idle moments as a share of the largest moment";
  EXPECT_LE(program.drift(), tolerance(1e-12));
  double swung = 0.0;
  for (std::size_t k = 0; k < guess.rotation.size(); ++k) {
    const auto angle = [&](const maneuver::NodePath& path, int joint) {
      return lie::log(mechanics::child_to_parent(path.rotation[k], system.joint(joint)));
    };
    EXPECT_LE((angle(guess, 0) - angle(*followed, 0)).norm(), tolerance(1e-10));
    swung = std::max(swung, (angle(guess, 1) - angle(*followed, 1)).norm());
  }
  EXPECT_GT(swung, 0.05) << "the fluke stood still";
}

TEST_P(Fluke, goes_round_with_a_stroke_that_closes) {
  const auto& [kind, spring, damper] = GetParam();
  maneuver::Problem problem = with_fluke(kind, spring, damper);
  problem.goal->periodic = problem.start.free_shape = true;
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 80);
  const maneuver::ShapeCoordinates coordinates(system);
  const maneuver::NodePath guess = guess::random_guess(system, maneuver, 3);
  const auto cycle = guess::cycle_of_passive_joints(system, maneuver, coordinates, guess, 0.5);
  ASSERT_TRUE(cycle);
  shape::ShapeProgram program(system, maneuver, coordinates, {}, {}, shape::Steps::rough);
  ASSERT_TRUE(program.go_to(guess));
  EXPECT_GT(program.merit().violation, 1e-3) << "a fluke held as it was needs moments";
  ASSERT_TRUE(program.go_to(*cycle));
  EXPECT_LE(program.merit().violation, tolerance(1e-8)) << "idle moments as a share of the largest moment";
  const auto joint_of = [&](const maneuver::NodePath& path, std::size_t k, int joint) {
    return mechanics::child_to_parent(path.rotation[k], system.joint(joint));
  };
  const auto apart = [&](const maneuver::NodePath& one, std::size_t k, const maneuver::NodePath& other, std::size_t n,
                         int joint) {
    return lie::rotation_angle(joint_of(one, k, joint).transpose() * joint_of(other, n, joint));
  };
  double driven = 0.0, calmer = 0.0, swung = 0.0;
  for (std::size_t k = 0; k <= 80; ++k) {
    driven = std::max(driven, apart(guess, k, guess, 0, 0));
    calmer = std::max(calmer, apart(*cycle, k, *cycle, 0, 0));
    swung = std::max(swung, apart(*cycle, k, *cycle, 0, 1));
  }
  EXPECT_LE(apart(*cycle, 80, *cycle, 0, 0) + apart(*cycle, 80, *cycle, 0, 1), tolerance(1e-10)) << "it closes";
  EXPECT_NEAR(std::log2(driven / calmer), std::round(std::log2(driven / calmer)), 1e-6) << "half, or half of that";
  EXPECT_GT(std::log2(driven / calmer), 0.5);
  EXPECT_GT(swung, 0.02) << "the fluke stood still";
}

INSTANTIATE_TEST_SUITE_P(PassiveJoints, Fluke,
                         ::testing::Values(std::tuple(model::JointKind::hinge, 0.0, 0.0),
                                           std::tuple(model::JointKind::hinge, 2.0, 0.0),
                                           std::tuple(model::JointKind::hinge, 2.0, 0.3),
                                           std::tuple(model::JointKind::ball, 1.0, 0.1)),
                         named_by_value);

// Steps that cannot follow a spring end in nothing, not in a motion that breaks the mechanics.
TEST(StiffFluke, on_a_spring_too_stiff_for_the_steps_is_exact_or_not_found) {
  int found = 0;
  for (const double spring : {1.0, 10.0, 30.0, 1e2, 1e4, 1e8}) {
    const maneuver::Problem problem = with_fluke(model::JointKind::hinge, spring, 0.0);
    const model::System system(problem.swimmer);
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 80);
    const maneuver::ShapeCoordinates coordinates(system);
    const maneuver::NodePath guess = guess::random_guess(system, maneuver, 3);
    const auto followed = guess::with_passive_joints(system, maneuver, coordinates, guess);
    if (!followed) continue;
    ++found;
    shape::ShapeProgram program(system, maneuver, coordinates, {}, {}, shape::Steps::rough);
    ASSERT_TRUE(program.go_to(*followed));
    EXPECT_LE(program.merit().violation, tolerance(1e-12)) << spring;
  }
  EXPECT_GT(found, 0);
  EXPECT_LT(found, 6) << "no spring was too stiff";
}

// A cycle is no march: what oscillates faster than steps show is held by its spring.
TEST(StiffFluke, goes_round_on_any_spring) {
  for (const double spring : {1.0, 1e2, 1e4, 1e8}) {
    maneuver::Problem problem = with_fluke(model::JointKind::hinge, spring, 0.0);
    problem.goal->periodic = problem.start.free_shape = true;
    const model::System system(problem.swimmer);
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 80);
    const maneuver::ShapeCoordinates coordinates(system);
    const auto cycle =
        guess::cycle_of_passive_joints(system, maneuver, coordinates, guess::random_guess(system, maneuver, 3), 1.0);
    ASSERT_TRUE(cycle) << spring;
    shape::ShapeProgram program(system, maneuver, coordinates, {}, {}, shape::Steps::rough);
    ASSERT_TRUE(program.go_to(*cycle));
    EXPECT_LE(program.merit().violation, tolerance(1e-8)) << spring;
  }
}

}  // namespace
}  // namespace lamprey::tests
