#include <gtest/gtest.h>

#include <functional>

#include "chains.hpp"
#include "difference_order.hpp"
#include "mechanics/discrete_lagrangian_derivatives.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mechanics::DiscreteLagrangian;
using mechanics::Interval;
using mechanics::StepLayout;

constexpr DiscreteLagrangian lagrangians[] = {DiscreteLagrangian::paper, DiscreteLagrangian::trapezoid};
constexpr double h = 0.1;

// The step perturbed body side at both nodes: R exp(η̂), R' exp(η̂'), Δx + δ.
Interval perturbed(const model::System& system, const Interval& step, const VectorXd& y) {
  Interval moved = step;
  const StepLayout at{system.body_count()};
  for (int i = 0; i < system.body_count(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    moved.rotation[n] = step.rotation[n] * lie::exp(y.segment<3>(at.left(i)));
    const Matrix3d next = step.next_rotation[n] * lie::exp(y.segment<3>(at.right(i)));
    moved.cayley[n] = lie::inverse_cayley(moved.rotation[n].transpose() * next);
  }
  moved.displacement = step.displacement + y.tail<3>();
  mechanics::update_interval(system, moved);
  return moved;
}

VectorXd momenta(const model::System& system, DiscreteLagrangian lagrangian, const Interval& step) {
  mechanics::DiscreteMomenta p(system.body_count());
  mechanics::discrete_momenta(system, lagrangian, h, step, p);
  VectorXd stacked(6 * system.body_count() + 3);
  for (int i = 0; i < system.body_count(); ++i) {
    stacked.segment<3>(3 * i) = p.minus[static_cast<std::size_t>(i)];
    stacked.segment<3>(3 * (system.body_count() + i)) = p.plus[static_cast<std::size_t>(i)];
  }
  stacked.tail<3>() = p.linear;
  return stacked;
}

class StepDerivatives : public ::testing::TestWithParam<int> {};

TEST_P(StepDerivatives, momenta_are_the_gradient_of_the_discrete_lagrangian) {
  Random random(static_cast<unsigned>(GetParam()));
  const model::System system(random_tree(random, GetParam()));
  const Interval step = random_interval(random, system, 0.3);
  for (auto lagrangian : lagrangians) {
    VectorXd gradient = momenta(system, lagrangian, step);
    gradient.head(3 * system.body_count()) *= -1.0;
    const VectorXd y = VectorXd::Random(gradient.size());
    const auto along = [&](double t) {
      return VectorXd::Constant(1,
                                mechanics::discrete_lagrangian(system, lagrangian, h, perturbed(system, step, t * y)));
    };
    expect_second_order_differences(along, VectorXd::Constant(1, gradient.dot(y)));
  }
}

TEST_P(StepDerivatives, first_derivatives_of_momenta_match_central_differences_at_second_order) {
  Random random(10 + static_cast<unsigned>(GetParam()));
  const model::System system(random_tree(random, GetParam()));
  const Interval step = random_interval(random, system, 0.3);
  mechanics::DerivativeWorkspace work(system.body_count());
  mechanics::StepQuadratic quadratic(system.body_count());
  mechanics::MomentumJacobian jacobian(system.body_count());
  for (auto lagrangian : lagrangians) {
    mechanics::lagrangian_quadratic(system, lagrangian, h, step, work, quadratic);
    mechanics::momentum_jacobian(quadratic, jacobian);
    EXPECT_LE((quadratic.hessian - quadratic.hessian.transpose()).lpNorm<Eigen::Infinity>(), 1e-11);
    const VectorXd y = VectorXd::Random(quadratic.gradient.size());
    VectorXd expected(y.size());
    expected << jacobian.minus * y, jacobian.plus * y, jacobian.linear * y;
    expect_second_order_differences(
        [&](double t) { return momenta(system, lagrangian, perturbed(system, step, t * y)); }, expected);
  }
}

TEST_P(StepDerivatives, second_derivatives_match_central_differences_at_second_order) {
  Random random(20 + static_cast<unsigned>(GetParam()));
  const model::System system(random_tree(random, GetParam()));
  const int n = system.body_count();
  const Interval step = random_interval(random, system, 0.3);
  mechanics::StepDirection direction(n);
  for (auto& v : direction.left) v = random.vector();
  for (auto& v : direction.right) v = random.vector();
  direction.displacement = random.vector();
  mechanics::DerivativeWorkspace work(n);
  mechanics::StepQuadratic quadratic(n);
  const StepLayout at{n};
  for (auto lagrangian : lagrangians) {
    const VectorXd y = VectorXd::Random(at.size());
    const auto gradient = [&](double t) {
      mechanics::StepQuadratic here(n);
      mechanics::directional_quadratic(system, lagrangian, h, perturbed(system, step, t * y), direction, work, here);
      return here.gradient;
    };
    mechanics::directional_quadratic(system, lagrangian, h, step, direction, work, quadratic);
    const VectorXd p = momenta(system, lagrangian, step);
    double value = direction.displacement.dot(p.tail<3>());
    for (int i = 0; i < n; ++i)
      value += direction.right[static_cast<std::size_t>(i)].dot(p.segment<3>(at.right(i))) -
               direction.left[static_cast<std::size_t>(i)].dot(p.segment<3>(at.left(i)));
    // gradient along y of the value, then the Hessian: body-side gradients turn by half of ĝ (equation 4.12)
    const auto along = [&](double t) {
      const VectorXd q = momenta(system, lagrangian, perturbed(system, step, t * y));
      double s = direction.displacement.dot(q.tail<3>());
      for (int i = 0; i < n; ++i)
        s += direction.right[static_cast<std::size_t>(i)].dot(q.segment<3>(at.right(i))) -
             direction.left[static_cast<std::size_t>(i)].dot(q.segment<3>(at.left(i)));
      return VectorXd::Constant(1, s);
    };
    EXPECT_NEAR(along(0.0)[0], value, 1e-12 * std::abs(value));
    expect_second_order_differences(along, VectorXd::Constant(1, quadratic.gradient.dot(y)));
    VectorXd expected = quadratic.hessian * y;
    for (int b = 0; b < 2 * n; ++b)
      expected.segment<3>(3 * b) += 0.5 * quadratic.gradient.segment<3>(3 * b).cross(y.segment<3>(3 * b));
    expect_second_order_differences(gradient, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Trees, StepDerivatives, ::testing::Values(1, 2, 3, 5), named_by_value);

}  // namespace
}  // namespace lamprey::tests
