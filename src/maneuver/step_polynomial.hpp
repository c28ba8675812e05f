// Moments as polynomials within a step, for schemes above order 2: orthonormal Legendre polynomials, so that the effort
// of a step is a plain sum of squares (chapter 12).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "integrator/scheme.hpp"

namespace lamprey::maneuver {

/// Number of coefficients of each moment in a step: half the scheme's order, for a cost of that order.
int polynomial_terms(integrator::Scheme scheme);

/// Values of the first `terms` ≤ 3 orthonormal Legendre polynomials of [0, 1] at a fraction of the step.
Eigen::VectorXd legendre(double fraction, int terms);

/// Fractions and weights of the Gauss rule with `terms` points: it takes coefficients from samples.
struct GaussRule {
  std::vector<double> fraction;
  std::vector<double> weight;
};
GaussRule gauss_rule(int terms);

/// Fractions of a step at which the stages of a scheme meet, [stages + 1]: from 0 to 1.
std::vector<double> stage_fractions(integrator::Scheme scheme);

/// Moments at a fraction of a step whose coefficients are stacked term by term, [terms · moments].
Eigen::VectorXd moments_at(const Eigen::VectorXd& coefficients, double fraction, int terms);

}  // namespace lamprey::maneuver
