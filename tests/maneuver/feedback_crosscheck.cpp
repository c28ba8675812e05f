// Laws that do what springs and dampers in the joints do.
#include <gtest/gtest.h>

#include "maneuver/followed.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using integrator::Scheme;

constexpr double stiffness = 3.0;  // N m/rad
constexpr double damping = 0.4;    // N m s/rad

// A tree on hinges and universal joints, with springs and dampers or without.
maneuver::Problem hinged_tree(double k, double c, Scheme scheme, int steps) {
  Random random(31);
  maneuver::Problem problem;
  problem.swimmer = random_tree(random, 4);
  for (std::size_t j = 0; j < problem.swimmer.joints.size(); ++j) {
    model::JointDescription& joint = problem.swimmer.joints[j];
    joint.kind = j == 1 ? model::JointKind::universal : model::JointKind::hinge;
    joint.reference_rotation = random.vector(0.5);
    const Vector3d second = random.vector();
    if (j == 1) joint.axes = {(lie::exp(joint.reference_rotation) * second).cross(random.vector()), second};
    if (j != 1) joint.axis = random.vector();
    joint.stiffness = k;
    joint.damping = c;
  }
  problem.steps = steps;
  problem.duration.value = 0.5;
  problem.scheme = scheme;
  const model::System system(problem.swimmer);
  ReferenceState state{random_rotations(random, system), Vector3d::Zero(), VectorXd()};
  mechanics::pack(system, random_freedoms(random, system, 1.0), random.vector(0.3), state.velocity);
  problem.start = start_at(system, state);
  return problem;
}

// Angles answered as springs answer them, rates as dampers: u on the parent, its opposite on the child.
integrator::FeedbackLaw springs_and_dampers(const model::System& system, double k, double c) {
  mechanics::Rotations zero(model::at(system.body_count()), Matrix3d::Identity());
  for (int i : system.root_to_leaves())
    if (system.body(i).parent >= 0)
      zero[model::at(i)] =
          zero[model::at(system.body(i).parent)] * system.joint(system.body(i).joint).reference_rotation;
  const int half = system.velocity_count();
  const ReferenceState rest{zero, Vector3d::Zero(), VectorXd::Zero(half)};
  MatrixXd gain = MatrixXd::Zero(system.control_count(), 2 * half);
  Eigen::Index row = 0;
  for (const model::Joint& joint : system.joints())
    for (Eigen::Index a = 0; a < joint.actuation.cols(); ++a, ++row) {
      gain(row, system.body(joint.child).velocity_offset + a) = k;
      gain(row, half + system.body(joint.child).velocity_offset + a) = c;
    }
  return {integrator::MotionPath(system, {{0.0, 0.5}, {rest, rest}}),
          maneuver::no_control(system),
          {0.0, 0.5},
          {gain, gain}};
}

double distance(const model::System& system, const maneuver::Solution& a, const maneuver::Solution& b) {
  return integrator::deviation(system, node_state(system, a, static_cast<int>(a.time.size()) - 1),
                               node_state(system, b, static_cast<int>(b.time.size()) - 1))
      .norm();
}

maneuver::Solution marched(const maneuver::Problem& problem) {
  const model::System system(problem.swimmer);
  return maneuver::simulate(system, problem, maneuver::no_control(system), maneuver::SimulateOptions{});
}

class FeedbackAsJoints : public ::testing::TestWithParam<Scheme> {};

TEST_P(FeedbackAsJoints, a_law_that_acts_as_springs_marches_as_springs_do) {
  const maneuver::Problem bare = hinged_tree(0.0, 0.0, GetParam(), 50);
  const model::System system(bare.swimmer);
  const maneuver::Solution sprung = marched(hinged_tree(stiffness, 0.0, GetParam(), 50));
  EXPECT_LE(distance(system, follow(system, bare, springs_and_dampers(system, stiffness, 0.0)), sprung),
            tolerance(1e-11));
  EXPECT_GT(distance(system, marched(bare), sprung), 0.1);
}

// Dampers act on turns over a step, the law on velocities at nodes: they differ by the scheme's order.
TEST_P(FeedbackAsJoints, a_law_that_acts_as_dampers_comes_to_them_at_the_order_of_the_scheme) {
  const auto error = [](int steps) {
    const maneuver::Problem bare = hinged_tree(stiffness, 0.0, GetParam(), steps);
    const model::System system(bare.swimmer);
    return distance(system, follow(system, bare, springs_and_dampers(system, 0.0, damping)),
                    marched(hinged_tree(stiffness, damping, GetParam(), steps)));
  };
  const double coarse = error(20), fine = error(40);
  EXPECT_NEAR(std::log2(coarse / fine), integrator::order(GetParam()), tolerance(0.35)) << coarse << ", " << fine;
  EXPECT_GT(fine, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Schemes, FeedbackAsJoints,
                         ::testing::Values(Scheme::trapezoid, Scheme::midpoint, Scheme::order4), named_by_value);

TEST(FeedbackInContinuousTime, a_law_that_acts_as_springs_and_dampers_moves_as_they_do) {
  const maneuver::Problem bare = hinged_tree(0.0, 0.0, Scheme::trapezoid, 10);
  const maneuver::Problem full = hinged_tree(stiffness, damping, Scheme::trapezoid, 10);
  const model::System system(bare.swimmer), resisted(full.swimmer);
  const maneuver::Solution expected =
      maneuver::simulate_by_reference(resisted, full, maneuver::no_control(resisted), maneuver::SimulateOptions{});
  const maneuver::Solution law = follow(system, bare, springs_and_dampers(system, stiffness, damping), true);
  EXPECT_LE(distance(system, law, expected), tolerance(1e-9));
  EXPECT_FALSE(law.marched_by.empty());
}

// Between nodes the path runs as the motion does, to the fourth order of the nodes' distance.
TEST(MotionPath, comes_to_the_motion_between_its_nodes_at_fourth_order) {
  const auto error = [](int steps) {
    const maneuver::Problem fine = hinged_tree(stiffness, 0.0, Scheme::trapezoid, 4 * steps);
    const model::System system(fine.swimmer);
    const maneuver::Solution motion =
        maneuver::simulate_by_reference(system, fine, maneuver::no_control(system), maneuver::SimulateOptions{});
    const integrator::NodeMotion all = maneuver::node_motion(system, motion);
    integrator::NodeMotion nodes;
    for (std::size_t k = 0; k < all.time.size(); k += 4) {
      nodes.time.push_back(all.time[k]);
      nodes.state.push_back(all.state[k]);
    }
    const integrator::MotionPath path(system, nodes);
    double place = 0.0, speed = 0.0;
    for (std::size_t k = 0; k < all.time.size(); ++k) {
      const VectorXd off = integrator::deviation(system, path.at_time(all.time[k]), all.state[k]);
      if (k % 4 == 0) {
        EXPECT_LE(off.norm(), tolerance(1e-14));
      }
      place = std::max(place, off.head(system.velocity_count()).norm());
      speed = std::max(speed, off.tail(system.velocity_count()).norm());
    }
    return std::pair(place, speed);
  };
  const auto coarse = error(20), fine = error(40);
  EXPECT_NEAR(std::log2(coarse.first / fine.first), 4.0, tolerance(0.2));
  EXPECT_NEAR(std::log2(coarse.second / fine.second), 3.0, tolerance(0.2));
}

}  // namespace
}  // namespace lamprey::tests
