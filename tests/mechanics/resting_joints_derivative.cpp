// A whole that moves as one: what it carries along its joints is what its velocities say, and first and second derivatives are
// those of differences.
#include "mechanics/resting_joints.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "mechanics/connection.hpp"
#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mechanics::RestingJoints;
using mechanics::Rotations;

class RestingJointsOfTrees : public ::testing::TestWithParam<unsigned> {
 protected:
  RestingJointsOfTrees() : resting_(system_) {
    for (double& entry : total_) entry = random_.normal();
    for (VectorXd* vector : {&multiplier_, &direction_})
      for (double& entry : *vector) entry = random_.normal();
    const Matrix3d root = rotation_[0];
    for (Matrix3d& R : rotation_) R = root.transpose() * R;
    resting_.take(rotation_);
  }
  Rotations moved(double length) const {
    mechanics::Interval interval(system_.body_count());
    interval.rotation = rotation_;
    for (Vector3d& v : interval.cayley) v.setZero();
    for (Vector3d& v : interval.joint_turn) v.setZero();
    for (int i = 1; i < system_.body_count(); ++i) {
      const model::Body& body = system_.body(i);
      const VectorXd own = length * direction_.segment(body.velocity_offset - 3, body.freedoms);
      if (body.freedoms == 3) {
        const double angle = own.norm();  // along an exponential
        interval.cayley[model::at(i)] = angle == 0.0 ? Vector3d::Zero() : Vector3d(std::tan(0.5 * angle) / angle * own);
      } else {
        interval.joint_turn[model::at(i)].head(body.freedoms) = own;
      }
    }
    interval.displacement.setZero();
    mechanics::update_interval(system_, interval);
    return interval.next_rotation;
  }

  Random random_{GetParam()};
  model::SwimmerDescription swimmer_ = random_swimmer(random_, 5);
  model::System system_{swimmer_};
  Rotations rotation_ = random_rotations(random_, system_);
  RestingJoints resting_;
  RestingJoints::Momentum total_;
  VectorXd multiplier_{system_.velocity_count() - 6}, direction_{multiplier_};
};
INSTANTIATE_TEST_SUITE_P(Trees, RestingJointsOfTrees, ::testing::Range(1U, 13U));

TEST_P(RestingJointsOfTrees, carry_what_the_velocities_of_the_whole_say) {
  const mechanics::SpatialMomentum seen{total_.tail<3>(), total_.head<3>()};
  const VectorXd velocity =
      mechanics::velocity_of_rates(system_, rotation_, Vector3d::Zero(),
                                   mechanics::Vectors(model::at(system_.joint_count()), Vector3d::Zero()), seen);
  const VectorXd momentum = mechanics::generalized_momentum(system_, rotation_, velocity);
  const VectorXd carried = resting_.by_total() * total_;
  EXPECT_GT(carried.norm(), 0.0);
  EXPECT_LE((carried - momentum.segment(3, carried.size())).norm(), tolerance(1e-11 * momentum.norm()));
}

TEST_P(RestingJointsOfTrees, change_along_the_shape_as_differences_do) {
  MatrixXd rates(multiplier_.size(), multiplier_.size());
  resting_.rates(total_, rates);
  RestingJoints other(system_);
  const auto there = [&](double length) -> VectorXd {
    other.take(moved(length));
    return other.by_total() * total_;
  };
  expect_second_order_differences(there, rates * direction_);
}

TEST_P(RestingJointsOfTrees, bend_along_the_shape_as_differences_do) {
  MatrixXd form(multiplier_.size(), multiplier_.size()), by_total(multiplier_.size(), 6);
  resting_.curvature(multiplier_, total_, form, by_total);
  RestingJoints other(system_);
  MatrixXd rates = form;
  // along an exponential the rates along itself are those of its own freedoms
  const auto there = [&](double length) -> VectorXd {
    other.take(moved(length));
    other.rates(total_, rates);
    VectorXd both(7);
    both << multiplier_.dot(rates * direction_), other.by_total().transpose() * multiplier_;
    return both;
  };
  VectorXd expected(7);
  expected << direction_.dot(form * direction_), by_total.transpose() * direction_;
  expect_second_order_differences(there, expected);
}

}  // namespace
}  // namespace lamprey::tests
