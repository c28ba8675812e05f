// The local connection: no momentum is left, whatever the joints do and however the swimmer is headed, and the energy that is
// left is the least.
#include "mechanics/connection.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using mechanics::LocalConnection;
using mechanics::Rotations;

class Connection : public ::testing::TestWithParam<unsigned> {
 protected:
  Random random_{GetParam()};
  model::SwimmerDescription swimmer_ = random_swimmer(random_, 6);
  model::System system_{swimmer_};
  Rotations rotation_ = random_rotations(random_, system_);
};
INSTANTIATE_TEST_SUITE_P(Trees, Connection, ::testing::Range(1U, 9U));

// ξ of the motion that the connection says, from rates of the joints.
VectorXd velocity_by(const model::System& system, const Rotations& R, const LocalConnection& connection,
                     const VectorXd& rates) {
  mechanics::Vectors angular(R.size());
  angular[0] = connection.turn * rates;
  std::vector<Eigen::Index> first;
  Eigen::Index next = 0;
  for (const model::Joint& joint : system.joints()) {
    first.push_back(next);
    next += system.body(joint.child).freedoms;
  }
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent < 0) continue;
    const model::Joint& joint = system.joint(body.joint);
    const Vector3d of_joint = [&] {
      Vector3d own = Vector3d::Zero();
      own.head(body.freedoms) = rates.segment(first[model::at(body.joint)], body.freedoms);
      return own;
    }();
    const Matrix3d Q = mechanics::child_to_parent(R, joint);
    const Vector3d turned =
        joint.free()
            ? Vector3d(Q.transpose() * of_joint)
            : Vector3d(mechanics::joint_frame(joint, R[model::at(body.parent)], R[model::at(i)]).axes * of_joint);
    angular[model::at(i)] = Q.transpose() * angular[model::at(body.parent)] + turned;
  }
  return mechanics::velocity_of_bodies(system, R, angular, R[0] * (connection.shift * rates));
}

TEST_P(Connection, leaves_no_momentum_and_the_least_energy) {
  const LocalConnection connection = mechanics::local_connection(system_, rotation_);
  VectorXd rates(connection.turn.cols());
  for (double& rate : rates) rate = random_.normal();
  const VectorXd velocity = velocity_by(system_, rotation_, connection, rates);
  const VectorXd momentum = mechanics::generalized_momentum(system_, rotation_, velocity);
  const auto total = mechanics::spatial_momentum(system_, rotation_, random_.vector(), momentum);
  const double size = momentum.lpNorm<Eigen::Infinity>();
  EXPECT_LE(total.linear.norm(), tolerance(1e-11 * size));
  EXPECT_LE(total.angular.norm(), tolerance(1e-11 * size));
  const double energy = mechanics::kinetic_energy(system_, rotation_, velocity);
  EXPECT_NEAR(0.5 * rates.dot(connection.inertia * rates), energy, tolerance(1e-11 * energy));
  for (int c = 0; c < 6; ++c) {  // any other motion of the root has more
    LocalConnection other = connection;
    (c < 3 ? other.turn : other.shift).row(c % 3).array() += 1e-3;
    EXPECT_GT(mechanics::kinetic_energy(system_, rotation_, velocity_by(system_, rotation_, other, rates)), energy);
  }
}

TEST_P(Connection, says_how_the_whole_moves_with_any_momentum) {
  const Vector3d position = random_.vector();
  mechanics::Vectors rate;
  VectorXd rates(mechanics::local_connection(system_, rotation_).turn.cols());
  Eigen::Index next = 0;
  for (const model::Joint& joint : system_.joints()) {
    rate.emplace_back(Vector3d::Zero());
    for (int c = 0; c < system_.body(joint.child).freedoms; ++c) rates[next++] = rate.back()[c] = random_.normal();
  }
  const mechanics::SpatialMomentum asked{random_.vector(), random_.vector()};
  const VectorXd velocity = mechanics::velocity_of_rates(system_, rotation_, position, rate, asked);
  const VectorXd momentum = mechanics::generalized_momentum(system_, rotation_, velocity);
  const auto total = mechanics::spatial_momentum(system_, rotation_, position, momentum);
  const double size = momentum.lpNorm<Eigen::Infinity>() + asked.linear.norm() + asked.angular.norm();
  EXPECT_LE((total.linear - asked.linear).norm(), tolerance(1e-11 * size));
  EXPECT_LE((total.angular - asked.angular).norm(), tolerance(1e-11 * size));
  // where there is none, and nothing but it, the local connection and a stiff motion
  const VectorXd still = mechanics::velocity_of_rates(system_, rotation_, position, rate, {});
  const VectorXd expected = velocity_by(system_, rotation_, mechanics::local_connection(system_, rotation_), rates);
  EXPECT_LE((still - expected).norm(), tolerance(1e-11 * expected.norm()));
  mechanics::Vectors none(rate.size(), Vector3d::Zero());
  const VectorXd stiff = mechanics::velocity_of_rates(system_, rotation_, position, none, asked);
  const mechanics::Vectors angular = mechanics::angular_velocities(system_, rotation_, stiff);
  for (std::size_t i = 1; i < angular.size(); ++i)
    EXPECT_LE((rotation_[i] * angular[i] - rotation_[0] * angular[0]).norm(), tolerance(1e-11 * angular[0].norm()));
}

TEST_P(Connection, does_not_depend_on_the_heading) {
  const LocalConnection connection = mechanics::local_connection(system_, rotation_);
  const Matrix3d turn = lie::exp(random_.vector());
  Rotations turned = rotation_;
  for (Matrix3d& R : turned) R = turn * R;
  const LocalConnection same = mechanics::local_connection(system_, turned);
  EXPECT_LE((same.turn - connection.turn).norm(), tolerance(1e-11 * connection.turn.norm()));
  EXPECT_LE((same.shift - connection.shift).norm(), tolerance(1e-11 * connection.shift.norm()));
  EXPECT_LE((same.inertia - connection.inertia).norm(), tolerance(1e-11 * connection.inertia.norm()));
}

}  // namespace
}  // namespace lamprey::tests
