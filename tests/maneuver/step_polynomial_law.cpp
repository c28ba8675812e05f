#include <gtest/gtest.h>

#include "maneuver/step_polynomial.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using integrator::Scheme;

TEST(StepPolynomial, is_orthonormal_over_the_step) {
  constexpr int points = 400;  // Simpson's rule, exact up to degree 3, and near enough for 4
  MatrixXd gram = MatrixXd::Zero(3, 3);
  for (int n = 0; n <= points; ++n) {
    const double weight = (n == 0 || n == points ? 1.0 : n % 2 == 1 ? 4.0 : 2.0) / (3.0 * points);
    const VectorXd value = maneuver::legendre(double(n) / points, 3);
    gram += weight * value * value.transpose();
  }
  EXPECT_LE((gram - MatrixXd::Identity(3, 3)).norm(), tolerance(1e-8));
}

TEST(StepPolynomial, gives_back_the_polynomial_whose_samples_at_the_gauss_points_it_takes) {
  for (int terms : {1, 2, 3}) {
    const auto polynomial = [terms](double c) {
      return 0.7 + (terms > 1 ? -1.3 * c : 0.0) + (terms > 2 ? 2.1 * c * c : 0.0);
    };
    const maneuver::GaussRule rule = maneuver::gauss_rule(terms);
    VectorXd coefficients = VectorXd::Zero(terms);
    for (std::size_t g = 0; g < rule.weight.size(); ++g)
      coefficients += rule.weight[g] * polynomial(rule.fraction[g]) * maneuver::legendre(rule.fraction[g], terms);
    for (double c : {0.0, 0.2, 0.9, 1.0})
      EXPECT_NEAR(maneuver::moments_at(coefficients, c, terms)[0], polynomial(c), tolerance(1e-14)) << terms;
  }
}

// What makes the effort of a step a sum of squares in the scheme's own quadrature too.
TEST(StepPolynomial, has_the_effort_that_the_schemes_own_quadrature_finds) {
  for (Scheme scheme : {Scheme::order4, Scheme::order6}) {
    const int terms = maneuver::polynomial_terms(scheme);
    EXPECT_EQ(2 * terms, integrator::order(scheme));
    const std::vector<double> fraction = maneuver::stage_fractions(scheme);
    VectorXd coefficients(2 * terms);
    for (int n = 0; n < coefficients.size(); ++n) coefficients[n] = std::cos(3.0 * n + 1.0);
    double effort = 0.0;
    for (std::size_t s = 0; s + 1 < fraction.size(); ++s)
      for (double c : {fraction[s], fraction[s + 1]})
        effort += 0.5 * (fraction[s + 1] - fraction[s]) * maneuver::moments_at(coefficients, c, terms).squaredNorm();
    EXPECT_NEAR(effort, coefficients.squaredNorm(), tolerance(1e-13)) << terms;
  }
}

}  // namespace
}  // namespace lamprey::tests
