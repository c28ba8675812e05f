// Shapes seen between nodes, or measured, and how they are brought within limits.
#include "maneuver/seen_shape.hpp"

#include <gtest/gtest.h>

#include "maneuver/followed.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem with_angle_limits(const maneuver::Problem& any, double bound) {
  maneuver::Problem problem = any;
  for (const model::JointDescription& joint : problem.swimmer.joints) {
    if (joint.kind == model::JointKind::hinge) problem.limits.angle[joint.name] = {{-bound, bound}};
    if (joint.kind == model::JointKind::universal)
      problem.limits.angle[joint.name] = {{-bound, bound}, {-bound, bound}};
  }
  return problem;
}

TEST(SeenShape, is_that_of_the_state_it_makes) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Plan plan = tree_in_motion(seed, 5, integrator::Scheme::trapezoid, 4, 0.1);
    const ReferenceState at_node = node_state(plan.system, plan.solution, 2);
    const maneuver::SeenShape shape = maneuver::shape_of(
        plan.system, integrator::state_of_velocity(plan.system, at_node.rotation, at_node.position, at_node.velocity));
    const integrator::State made = maneuver::state_of(plan.system, at_node.rotation[0], at_node.position, shape, {});
    EXPECT_FALSE(maneuver::has_momentum(plan.system, made));
    const maneuver::SeenShape again = maneuver::shape_of(plan.system, made);
    for (std::size_t j = 0; j < shape.rate.size(); ++j) {
      EXPECT_LT((again.rotation[j] - shape.rotation[j]).norm(), 1e-12);
      EXPECT_LT((again.rate[j] - shape.rate[j]).norm(), 1e-10 * (1.0 + shape.rate[j].norm()));
    }
  }
}

TEST(SeenShape, between_nodes_goes_from_the_one_to_the_other_at_their_mean_rate) {
  const Plan plan = tree_in_motion(3, 5, integrator::Scheme::trapezoid, 4, 0.1);
  const auto& from = plan.solution.rotation[1];
  const auto& to = plan.solution.rotation[2];
  const auto at_share = [&](double share) { return maneuver::shape_between(plan.system, from, to, 0.025, share); };
  constexpr double little = 1e-6;
  for (int j = 0; j < plan.system.joint_count(); ++j) {
    const auto joint = static_cast<std::size_t>(j);
    EXPECT_LT((at_share(0.0).rotation[joint] - mechanics::child_to_parent(from, plan.system.joint(j))).norm(), 1e-12);
    EXPECT_LT((at_share(1.0).rotation[joint] - mechanics::child_to_parent(to, plan.system.joint(j))).norm(), 1e-12);
    if (!plan.system.joint(j).free()) {  // angles at an even pace
      const auto angles = [&](double share) {
        return mechanics::joint_angles(plan.system.joint(j), at_share(share).rotation[joint]);
      };
      const Vector3d rate = (angles(0.7) - angles(0.2)) / (0.5 * 0.025);
      EXPECT_LT((rate - at_share(0.3).rate[joint]).norm(), 1e-9 * (1.0 + rate.norm()));
      continue;
    }
    const Eigen::Matrix3d before = at_share(0.3).rotation[joint], after = at_share(0.3 + little).rotation[joint];
    const Vector3d turn = lie::log(after * before.transpose()) / (little * 0.025);
    EXPECT_LT((turn - at_share(0.3).rate[joint]).norm(), 1e-4 * turn.norm());
  }
}

TEST(SeenShape, beyond_its_limits_is_held_at_them_still) {
  const Plan plan = tree_in_motion(5, 6, integrator::Scheme::trapezoid, 2, 0.1);
  const maneuver::SeenShape seen =
      maneuver::shape_of(plan.system, maneuver::start_state(plan.system, plan.problem.start));
  const auto rows = maneuver::limit_rows(plan.system, with_angle_limits(plan.problem, 0.05));
  ASSERT_FALSE(rows.empty());
  const maneuver::BeyondLimit beyond = maneuver::beyond_limits(plan.system, rows, seen);
  ASSERT_NE(beyond.limit, nullptr);
  EXPECT_GT(beyond.angle, 0.01);
  const mechanics::Rotations straight = [&] {  // all joints at their zero angle
    mechanics::Rotations R(static_cast<std::size_t>(plan.system.body_count()), Eigen::Matrix3d::Identity());
    for (int i : plan.system.root_to_leaves())
      if (const model::Body& body = plan.system.body(i); body.parent >= 0)
        R[static_cast<std::size_t>(i)] = R[static_cast<std::size_t>(body.parent)] *
                                         mechanics::joint_rotation(plan.system.joint(body.joint), Vector3d::Zero());
    return R;
  }();
  const maneuver::SeenShape held = maneuver::held_within_limits(plan.system, rows, seen, straight);
  EXPECT_EQ(maneuver::beyond_limits(plan.system, rows, held).limit, nullptr);
  bool any_left = false;
  for (int j = 0; j < plan.system.joint_count(); ++j) {
    const auto joint = static_cast<std::size_t>(j);
    const bool moved = held.rotation[joint] != seen.rotation[joint];
    if (moved) {
      EXPECT_TRUE(held.rate[joint].isZero(0.0));
      EXPECT_NEAR(mechanics::joint_angles(plan.system.joint(j), held.rotation[joint]).cwiseAbs().maxCoeff(), 0.05,
                  1e-9);
    } else {
      EXPECT_EQ(held.rate[joint], seen.rate[joint]);
      any_left = true;
    }
  }
  EXPECT_TRUE(any_left);
}

// A swimmer that spins as one and whose joints stand still has no momentum left once that is taken off: round-off is none.
TEST(SeenShape, of_a_swimmer_that_spins_as_one_is_still) {
  const Plan plan = chain_in_motion(1.0, 2, 0.1);
  maneuver::Start start = plan.problem.start;
  for (const double spin : {1e-15, 1.0, 1e6}) {
    for (std::size_t i = 0; i < start.rotation.size(); ++i)
      start.angular_velocity[i] = lie::exp(start.rotation[i]).transpose() * Vector3d(0.0, 0.0, spin);
    for (const double share : {0.0, 1e-9, 1e-6}) {
      maneuver::Start turning = start;
      turning.angular_velocity.back()[2] += share * spin;
      EXPECT_FALSE(maneuver::has_momentum(plan.system, maneuver::start_without_momentum(plan.system, turning)))
          << spin << " " << share;
    }
  }
}

}  // namespace
}  // namespace lamprey::tests
