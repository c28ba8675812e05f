#include <gtest/gtest.h>

#include "difference_order.hpp"
#include "integrator/random_motions.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

VectorXd one(double value) { return VectorXd::Constant(1, value); }

class Adjoint : public ::testing::TestWithParam<MotionSetting> {};

TEST_P(Adjoint, gradient_by_start_and_controls_matches_central_differences_at_second_order) {
  RandomMotion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const auto direction = m.random_direction();
  expect_second_order_differences([&](double t) { return one(scalar.value(m.moved(direction, t))); },
                                  one(slope_along(gradient, direction).value));
}

TEST_P(Adjoint, gradient_by_duration_matches_central_differences_at_second_order) {
  RandomMotion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const double duration = m.setting.duration;
  expect_second_order_differences(
      [&](double t) { return one(scalar.value(m.run(m.system, m.start, m.control, duration * (1.0 + t)))); },
      one(duration * gradient.by_duration));
}

TEST_P(Adjoint, gradient_by_parameters_matches_central_differences_at_second_order) {
  RandomMotion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const model::SwimmerDescription direction = random_parameters(m.random, m.swimmer);
  const auto along = [&](double t) {
    const model::System other(moved_parameters(m.swimmer, direction, t));
    return one(scalar.value(m.run(other, m.start, m.control, m.setting.duration)));
  };
  expect_second_order_differences(along, one(slope_along(gradient.by_parameters, direction).value), 3e-9);
}

TEST_P(Adjoint, hessian_product_matches_central_differences_of_the_gradient_at_second_order) {
  RandomMotion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const auto direction = m.random_direction();
  integrator::HessianProduct product(m.trajectory);
  sweep.hessian_product(scalar, direction, product);
  const auto along = [&](double t) {
    const Trajectory moved = m.moved(direction, t);
    integrator::AdjointSweep other(moved);
    TrajectoryGradient there(moved);
    other.gradient(scalar, there);
    return stacked(m.system, there.by_start, there.by_control);
  };
  expect_second_order_differences(along, stacked(m.system, product.by_start, product.by_control), 1e-8);
}

// Round-off in the derivatives of a stage is in proportion to one over its length, so stages of all schemes are as long.
TEST_P(Adjoint, tangent_and_gradient_give_one_dot_product) {
  MotionSetting setting = GetParam();
  if (order(setting.scheme) > 2) setting.duration *= 4.0;
  RandomMotion m(setting);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  StateGradient row(m.system), end(m.system);
  row.turn = random_freedoms(m.random, m.system, 1.0);
  row.momentum = random_freedoms(m.random, m.system, 1.0);
  row.position = m.random.vector();
  row.linear = m.random.vector();
  sweep.gradient(AtEnd(m.trajectory.steps(), row), gradient);
  const auto direction = m.random_direction();
  sweep.tangent(direction, end);
  Slope ahead;
  ahead.add_state(row, end);
  const double behind = slope_along(gradient, direction).value;
  EXPECT_NEAR(behind, ahead.value, tolerance(1e-12) * norm(row) * norm(end));
}

std::vector<MotionSetting> motion_settings() {
  std::vector<MotionSetting> all;
  unsigned seed = 1;
  for (integrator::Scheme scheme : all_schemes)
    for (int bodies : {1, 2, 3, 5, 8}) all.push_back({scheme, bodies, seed++});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Schemes, Adjoint, ::testing::ValuesIn(motion_settings()), named_by_value);

}  // namespace
}  // namespace lamprey::tests
