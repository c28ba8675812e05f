// What is seen of a swimmer's shape and rates becomes a start that obeys the law.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"
#include "model/input_error.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

maneuver::Start tumbling() {
  maneuver::Start start;
  start.position = {0.3, -0.2, 0.1};
  start.rotation = {{0.2, -0.1, 0.4}, {0.5, 0.3, -0.2}, {-0.3, 0.6, 0.1}};
  start.angular_velocity = {{0.7, -1.1, 0.4}, {-0.6, 0.9, 1.3}, {0.2, -0.5, -0.8}};
  start.linear_velocity = {2.0, -3.0, 1.0};
  return start;
}

double momentum_share(const model::System& system, const integrator::State& state) {
  const auto total = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
  return std::max(total.linear.norm(), total.angular.norm()) / state.momentum.norm();
}

// World rate at which the child of a joint turns against its parent.
Vector3d joint_rate(const model::System& system, const integrator::State& state, int joint) {
  const auto rates =
      mechanics::angular_velocities(system, state.rotation, integrator::velocity_of_state(system, state));
  const auto world = [&](int body) { return Vector3d(state.rotation[model::at(body)] * rates[model::at(body)]); };
  return world(system.joint(joint).child) - world(system.joint(joint).parent);
}

TEST(StartWithoutMomentum, has_none_and_turns_its_joints_as_seen) {
  const model::System system(paper_chain());
  const integrator::State seen = maneuver::start_state(system, tumbling());
  const integrator::State state = maneuver::start_without_momentum(system, tumbling());
  EXPECT_GT(momentum_share(system, seen), 0.1);
  EXPECT_LT(momentum_share(system, state), tolerance(1e-14));
  for (int j = 0; j < system.joint_count(); ++j) {
    EXPECT_GT(joint_rate(system, state, j).norm(), 0.1);
    EXPECT_LT((joint_rate(system, state, j) - joint_rate(system, seen, j)).norm(), tolerance(1e-13));
  }
}

TEST(StartWithoutMomentum, leaves_a_start_alone_that_has_none) {
  const model::System system(paper_chain());
  const integrator::State once = maneuver::start_without_momentum(system, tumbling());
  maneuver::Start again = tumbling();
  again.angular_velocity =
      mechanics::angular_velocities(system, once.rotation, integrator::velocity_of_state(system, once));
  const integrator::State twice = maneuver::start_without_momentum(system, again);
  EXPECT_LT((twice.momentum - once.momentum).norm(), tolerance(1e-13) * once.momentum.norm());
}

// Places in the world have no part in it: map coordinates are millions of metres.
TEST(StartWithoutMomentum, has_none_wherever_it_begins) {
  const model::System system(paper_chain());
  maneuver::Start far = tumbling();
  far.position = {5e6, -4e6, 100.0};
  const integrator::State state = maneuver::start_without_momentum(system, far);
  EXPECT_FALSE(maneuver::has_momentum(system, state));
  EXPECT_EQ(state.momentum, maneuver::start_without_momentum(system, tumbling()).momentum);
  EXPECT_TRUE(maneuver::has_momentum(system, maneuver::start_state(system, far)));
}

// What a camera sees fits no hinge to the last digit.
TEST(StartWithoutMomentum, makes_measured_rotations_fit_their_joints) {
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    model::SwimmerDescription swimmer = random_swimmer(random, 5);
    const model::System system(swimmer);
    const mechanics::Rotations fitting = random_rotations(random, system);
    for (const double noise : {0.0, 1e-9, 1e-3}) {
      maneuver::Start start;
      for (const Eigen::Matrix3d& R : fitting)
        start.rotation.push_back(lie::log(R * lie::exp(noise * random.vector().normalized())));
      start.angular_velocity.assign(fitting.size(), Vector3d::Zero());
      const integrator::State state = maneuver::start_without_momentum(system, start);
      mechanics::Rotations again = state.rotation;
      maneuver::fit_to_joints(system, again);
      EXPECT_EQ(lie::log(state.rotation[0]), lie::log(lie::exp(start.rotation[0]))) << "the root is taken as seen";
      for (std::size_t i = 0; i < fitting.size(); ++i) {
        EXPECT_LE((again[i] - state.rotation[i]).norm(), tolerance(1e-13));
        EXPECT_LE(lie::rotation_angle(fitting[i].transpose() * state.rotation[i]), 20.0 * noise + tolerance(1e-12));
      }
    }
  }
}

TEST(StartWithoutMomentum, refuses_bodies_that_no_measurement_explains) {
  model::SwimmerDescription swimmer = paper_chain();
  swimmer.joints[1].kind = model::JointKind::hinge;
  swimmer.joints[1].axis = Vector3d(0, 0, 1);
  const model::System system(swimmer);
  maneuver::Start start = tumbling();
  start.rotation = {Vector3d::Zero(), Vector3d(0.4, 0.1, 0.2), Vector3d(0.0, 0.0, 0.5)};
  EXPECT_NO_THROW(maneuver::start_without_momentum(system, start));
  start.rotation[2] = Vector3d(0.3, 0.0, 0.5);
  try {
    maneuver::start_without_momentum(system, start);
    FAIL();
  } catch (const model::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("start.rotation.back"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lamprey::tests
