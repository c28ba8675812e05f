// The local connection: no momentum is left, whatever the joints do and however the swimmer is headed, and the energy that is
// left is the least.
#include "mechanics/connection.hpp"

#include <numbers>

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

// Shapes by how far the joints have turned, [joints][3] as mechanics::rotation_at_turn has them, and rates of these.
using Turns = mechanics::Vectors;

Turns combined(const Turns& a, double scale, const Turns& b) {
  Turns sum = a;
  for (std::size_t j = 0; j < a.size(); ++j) sum[j] += scale * b[j];
  return sum;
}

VectorXd rates_of(const model::System& system, const Turns& turn, const Turns& change) {
  std::vector<double> rates;
  for (int j = 0; j < system.joint_count(); ++j) {
    Vector3d rate = change[model::at(j)];
    if (system.joint(j).free()) {  // by differences: no formula of the connection's
      constexpr double e = 1e-5;
      const Matrix3d by = (lie::exp(turn[model::at(j)] + e * rate) - lie::exp(turn[model::at(j)] - e * rate)) / (2 * e);
      rate = lie::vee(by * lie::exp(turn[model::at(j)]).transpose());
    }
    for (int c = 0; c < system.body(system.joint(j).child).freedoms; ++c) rates.push_back(rate[c]);
  }
  return Eigen::Map<VectorXd>(rates.data(), static_cast<Eigen::Index>(rates.size()));
}

// How the root has moved, (turn, shift) along its first axes, when the shape has gone once round an ellipse about `middle` with
// the half axes `size` a and `size` b, from where it is at phase `first` on.
VectorXd moved_by_ellipse(const model::System& system, const Turns& middle, const Turns& a, const Turns& b, double size,
                          double first) {
  constexpr int steps = 100;
  const auto velocity = [&](double s) {
    const Turns turn = combined(combined(middle, size * std::cos(s), a), size * std::sin(s), b);
    const Turns none(middle.size(), Vector3d::Zero());
    const Turns change = combined(combined(none, -size * std::sin(s), a), size * std::cos(s), b);
    const LocalConnection connection = mechanics::local_connection(system, mechanics::shape_at_turns(system, turn));
    const VectorXd rates = rates_of(system, turn, change);
    Eigen::Matrix4d twist = Eigen::Matrix4d::Zero();
    twist.topLeftCorner<3, 3>() = lie::hat(Vector3d(connection.turn * rates));
    twist.topRightCorner<3, 1>() = connection.shift * rates;
    return twist;
  };
  Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
  const double step = 2.0 * std::numbers::pi / steps;
  for (int k = 0; k < steps; ++k) {  // Runge and Kutta's of order 4
    const double s = first + k * step;
    const Eigen::Matrix4d early = velocity(s), middle_twist = velocity(s + 0.5 * step), late = velocity(s + step);
    const Eigen::Matrix4d k_1 = place * early, k_2 = (place + 0.5 * step * k_1) * middle_twist,
                          k_3 = (place + 0.5 * step * k_2) * middle_twist, k_4 = (place + step * k_3) * late;
    place += step * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4) / 6.0;
  }
  VectorXd moved(6);
  moved << lie::log(Matrix3d(place.topLeftCorner<3, 3>())), place.topRightCorner<3, 1>();
  return moved;
}

TEST_P(Connection, curves_by_what_small_loops_of_shapes_move_the_root) {
  const auto joints = model::at(system_.joint_count());
  Turns middle(joints), a(joints), b(joints);
  for (Turns* each : {&middle, &a, &b})
    for (std::size_t j = 0; j < joints; ++j) {
      (*each)[j] = random_.vector(0.4);
      for (int c = system_.body(system_.joint(static_cast<int>(j)).child).freedoms; c < 3; ++c) (*each)[j][c] = 0.0;
    }
  const mechanics::ConnectionCurvature curvature =
      mechanics::connection_curvature(system_, mechanics::shape_at_turns(system_, middle));
  const VectorXd along = rates_of(system_, middle, a), across = rates_of(system_, middle, b);
  VectorXd expected(6);
  for (std::size_t k = 0; k < 3; ++k) {
    expected[static_cast<Eigen::Index>(k)] = along.dot(curvature.turn[k] * across);
    expected[static_cast<Eigen::Index>(3 + k)] = along.dot(curvature.shift[k] * across);
  }
  std::vector<double> error;
  for (const double size : {0.2, 0.1, 0.05}) {
    // from opposite ends: what the beginning matters cancels to first order
    const VectorXd moved = 0.5 * (moved_by_ellipse(system_, middle, a, b, size, 0.0) +
                                  moved_by_ellipse(system_, middle, a, b, size, std::numbers::pi));
    error.push_back((moved / (std::numbers::pi * size * size) - expected).norm() / expected.norm());
  }
  EXPECT_LE(error[2], 0.02);
  for (std::size_t n = 0; n < 2; ++n) EXPECT_NEAR(std::log2(error[n] / error[n + 1]), 2.0, 0.2) << error[n];
}

}  // namespace
}  // namespace lamprey::tests
