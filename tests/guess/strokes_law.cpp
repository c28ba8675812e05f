// Guesses of many strokes arrive where they shall, keep to limits of the joints, and are the same for the same seed.
#include "guess/strokes.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "guess/guess.hpp"
#include "hull_with_paddles.hpp"
#include "model/system.hpp"
#include "shape/reach.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

struct Rowed {
  model::System system;
  maneuver::Maneuver maneuver;
  guess::Strokes strokes;
};

Rowed rowed(const maneuver::Problem& problem, int strokes, bool within_limits, std::uint64_t seed = 1) {
  model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 20 * strokes);
  const maneuver::NodePath guess = guess::random_guess(system, maneuver, 1);
  const auto coordinates = shape::reachable_coordinates(system, maneuver, guess);
  const auto rows = shape::independent_end_rows(system, maneuver, *coordinates, guess);
  const guess::StrokeLimits limits =
      within_limits ? guess::stroke_limits(system, problem, maneuver.start, maneuver.duration, strokes)
                    : guess::no_stroke_limits(system);
  return {system, maneuver, guess::strokes_to_goal(system, maneuver, *coordinates, *rows, limits, strokes, seed)};
}

double angle(const Rowed& rowed, std::size_t node, int joint) {
  const model::Joint& hinge = rowed.system.joint(joint);
  return mechanics::joint_angles(hinge, mechanics::child_to_parent(rowed.strokes.path.rotation[node], hinge))[0];
}

TEST(Strokes, carry_the_swimmer_to_its_goal_and_end_in_its_first_shape) {
  for (const int strokes : {8, 16}) {
    const Rowed found = rowed(hull_with_paddles(0.3), strokes, false);
    ASSERT_FALSE(found.strokes.path.rotation.empty());
    EXPECT_LE(found.strokes.missed, tolerance(1e-5)) << strokes;
    const Eigen::Matrix3d& hull = found.strokes.path.rotation.back()[0];
    EXPECT_NEAR(std::atan2(hull(1, 0), hull(0, 0)), 0.3, tolerance(1e-5));
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(angle(found, found.strokes.path.rotation.size() - 1, j), 0.0, tolerance(1e-12));
  }
}

TEST(Strokes, are_as_many_as_asked_for) {
  const Rowed found = rowed(hull_with_paddles(0.2), 8, false);
  int signs = 0;  // changes of an arm's sense of turning
  double before = 0.0;
  for (std::size_t k = 0; k + 1 < found.strokes.path.rotation.size(); ++k) {
    const double turned = angle(found, k + 1, 0) - angle(found, k, 0);
    signs += before * turned < 0.0;
    before = turned;
  }
  EXPECT_NEAR(signs, 16, 2);
}

TEST(Strokes, keep_to_the_joints_limits) {
  maneuver::Problem problem = hull_with_paddles(0.3);
  for (const model::JointDescription& joint : problem.swimmer.joints) problem.limits.angle[joint.name] = {{-0.7, 0.9}};
  problem.limits.angular_velocity = 3.0;
  const int strokes = 12;
  const Rowed found = rowed(problem, strokes, true);
  ASSERT_FALSE(found.strokes.path.rotation.empty());
  double largest = 0.0, fastest = 0.0;
  for (std::size_t k = 0; k + 1 < found.strokes.path.rotation.size(); ++k)
    for (int j = 0; j < 4; ++j) {
      largest = std::max(largest, std::abs(angle(found, k, j)));
      fastest = std::max(fastest, std::abs(angle(found, k + 1, j) - angle(found, k, j)) / found.maneuver.time_step());
    }
  EXPECT_LE(largest, 0.7);
  EXPECT_GE(largest, 0.3) << "hardly a stroke";
  const Rowed free = rowed(hull_with_paddles(0.8), strokes, false);
  double beyond = 0.0;
  for (std::size_t k = 0; k < free.strokes.path.rotation.size(); ++k)
    beyond = std::max(beyond, std::abs(angle(free, k, 0)));
  EXPECT_GT(beyond, 0.9) << "limits had nothing to do";
  EXPECT_LE(fastest, 3.0 * 1.3) << "but where strokes begin and end";
}

TEST(Strokes, are_limited_alike_by_a_rate_of_each_joint_and_of_all) {
  maneuver::Problem all = hull_with_paddles(0.3), each = all;
  all.limits.angular_velocity = 2.0;
  for (const model::JointDescription& joint : each.swimmer.joints) each.limits.joint_angular_velocity[joint.name] = 2.0;
  const model::System system(all.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, all, 100);
  const guess::StrokeLimits one = guess::stroke_limits(system, all, maneuver.start, maneuver.duration, 10);
  const guess::StrokeLimits other = guess::stroke_limits(system, each, maneuver.start, maneuver.duration, 10);
  EXPECT_EQ(one.amplitude, other.amplitude);
  EXPECT_LT(one.amplitude[0], 2.0 * 20.0 / (2.0 * std::numbers::pi * 10));
}

// As in the search, and what is said of angles is not said of ball joints.
TEST(Strokes, are_limited_by_a_joints_own_rate_in_the_place_of_that_of_all) {
  maneuver::Problem own = hull_with_paddles(0.3), faster = own;
  for (maneuver::Problem* problem : {&own, &faster}) problem->limits.angular_velocity = 2.0;
  const std::string& name = own.swimmer.joints[0].name;
  own.limits.joint_angular_velocity[name] = faster.limits.joint_angular_velocity[name] = 3.0;
  for (const model::JointDescription& joint : faster.swimmer.joints)
    if (joint.name != name) faster.limits.joint_angular_velocity[joint.name] = 2.0;
  const model::System system(own.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, own, 100);
  const guess::StrokeLimits one = guess::stroke_limits(system, own, maneuver.start, maneuver.duration, 10);
  EXPECT_EQ(one.amplitude, guess::stroke_limits(system, faster, maneuver.start, maneuver.duration, 10).amplitude);
  EXPECT_NEAR(one.amplitude[0], 1.5 * one.amplitude[1], tolerance(1e-14));
}

TEST(Strokes, are_the_same_for_the_same_seed) {
  const Rowed one = rowed(hull_with_paddles(0.2), 4, false, 3), same = rowed(hull_with_paddles(0.2), 4, false, 3),
              other = rowed(hull_with_paddles(0.2), 4, false, 4);
  double apart = 0.0;
  for (std::size_t k = 0; k < one.strokes.path.rotation.size(); ++k) {
    EXPECT_EQ(one.strokes.path.rotation[k], same.strokes.path.rotation[k]);
    apart = std::max(apart, std::abs(angle(one, k, 0) - angle(other, k, 0)));
  }
  EXPECT_GT(apart, 1e-3);
}

}  // namespace
}  // namespace lamprey::tests
