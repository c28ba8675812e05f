// How springs and dampers feel the length of a step, against the whole balance at several lengths.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "mechanics/compliant_time.hpp"
#include "mechanics/step_balance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using mechanics::CompliantTime;
using mechanics::ForcedStep;
using mechanics::Freedoms;
using mechanics::Interval;

VectorXd stacked(const Freedoms& first, const Freedoms& second) {
  const auto bodies = static_cast<Eigen::Index>(first.size());
  VectorXd result(6 * bodies);
  for (Eigen::Index i = 0; i < bodies; ++i) {
    result.segment<3>(3 * i) = first[static_cast<std::size_t>(i)];
    result.segment<3>(3 * (bodies + i)) = second[static_cast<std::size_t>(i)];
  }
  return result;
}

class CompliantTimeOf : public ::testing::TestWithParam<unsigned> {
 protected:
  static constexpr double h = 0.1;

  CompliantTimeOf()
      : random_(GetParam()),
        system_(with_springs_and_dampers(random_swimmer(random_, 5))),
        interval_(random_interval(random_, system_, 0.4)),
        no_control_(static_cast<std::size_t>(system_.joint_count()), Vector3d::Zero()),
        left_(random_freedoms(random_, system_, 1.0)),
        right_(random_freedoms(random_, system_, 1.0)) {
    EXPECT_TRUE(system_.compliant());
  }

  static model::SwimmerDescription with_springs_and_dampers(model::SwimmerDescription swimmer) {
    for (model::JointDescription& joint : swimmer.joints)
      if (joint.kind != model::JointKind::fixed) {
        joint.stiffness = 2.0;
        joint.damping = 0.5;
      }
    return swimmer;
  }

  ForcedStep step_of(double time_step) const {
    return {system_, mechanics::DiscreteLagrangian::midpoint, time_step, interval_, no_control_, no_control_};
  }

  // h E⁻ and h E⁺, over the first h.
  VectorXd impulses(double time_step) const {
    mechanics::StepBalance balance(system_.body_count());
    evaluate_balance(step_of(time_step), balance);
    return time_step / h * stacked(balance.minus, balance.plus);
  }

  // Gradient of −h E⁻·left + h E⁺·right, over the first h.
  VectorXd gradient(double time_step) const {
    mechanics::StepBalance balance(system_.body_count());
    mechanics::StepRate rate(system_.body_count());
    mechanics::StepVariation along(system_);
    along.left = left_;
    along.right = right_;
    evaluate_balance(step_of(time_step), balance);
    evaluate_rate(step_of(time_step), balance, along, mechanics::RateKind::adjoint, rate);
    return time_step / h * stacked(rate.minus, rate.plus);
  }

  Random random_;
  model::System system_;
  Interval interval_;
  mechanics::Moments no_control_;
  Freedoms left_, right_;
};

TEST_P(CompliantTimeOf, is_the_rate_of_impulses_by_the_logarithm_of_the_time_step) {
  CompliantTime time(system_);
  time.evaluate(h, interval_);
  expect_second_order_differences([&](double t) { return impulses(h * std::exp(t)); },
                                  stacked(time.minus(), time.plus()));
}

// As a polynomial in h what inertia leaves is 0, what dampers share grows with h, and what springs share with h².
TEST_P(CompliantTimeOf, tells_dampers_from_springs) {
  CompliantTime time(system_);
  time.evaluate(h, interval_);
  const VectorXd twice = impulses(2.0 * h), once = impulses(h), half = impulses(0.5 * h);
  const VectorXd springs = (2.0 / 3.0) * (twice - 3.0 * once + 2.0 * half);
  const VectorXd dampers = (twice - once) - 3.0 * springs;
  const double size = once.norm();
  EXPECT_GT(std::min(springs.norm(), dampers.norm()), 1e-5 * size);
  EXPECT_LE((dampers - stacked(time.damped_minus(), time.damped_plus())).norm(), tolerance(1e-12) * size);
  EXPECT_LE((dampers + 2.0 * springs - stacked(time.minus(), time.plus())).norm(), tolerance(1e-12) * size);
}

TEST_P(CompliantTimeOf, has_a_gradient_that_is_the_adjoints_rate_by_the_logarithm_of_the_time_step) {
  CompliantTime time(system_);
  time.evaluate(h, interval_);
  time.differentiate(h, interval_, left_, right_);
  expect_second_order_differences([&](double t) { return gradient(h * std::exp(t)); },
                                  stacked(time.by_left(), time.by_right()));
}

INSTANTIATE_TEST_SUITE_P(Swimmers, CompliantTimeOf, ::testing::Values(1U, 2U, 3U, 4U, 5U, 6U));

}  // namespace
}  // namespace lamprey::tests
