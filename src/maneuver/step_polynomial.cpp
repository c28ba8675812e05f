#include "maneuver/step_polynomial.hpp"

#include <cmath>

namespace lamprey::maneuver {

using Eigen::VectorXd;

int polynomial_terms(integrator::Scheme scheme) { return std::max(1, integrator::order(scheme) / 2); }

VectorXd legendre(double fraction, int terms) {
  const double x = 2.0 * fraction - 1.0;
  VectorXd value(terms);
  value[0] = 1.0;
  if (terms > 1) value[1] = std::sqrt(3.0) * x;
  if (terms > 2) value[2] = 0.5 * std::sqrt(5.0) * (3.0 * x * x - 1.0);
  return value;
}

GaussRule gauss_rule(int terms) {
  if (terms == 1) return {{0.5}, {1.0}};
  if (terms == 2) {
    const double away = 0.5 / std::sqrt(3.0);
    return {{0.5 - away, 0.5 + away}, {0.5, 0.5}};
  }
  const double away = 0.5 * std::sqrt(0.6);
  return {{0.5 - away, 0.5, 0.5 + away}, {5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0}};
}

std::vector<double> stage_fractions(integrator::Scheme scheme) {
  std::vector<double> fractions = {0.0};
  for (double fraction : integrator::composition(scheme).fractions) fractions.push_back(fractions.back() + fraction);
  fractions.back() = 1.0;
  return fractions;
}

VectorXd moments_at(const VectorXd& coefficients, double fraction, int terms) {
  return coefficients.reshaped(coefficients.size() / terms, terms) * legendre(fraction, terms);
}

}  // namespace lamprey::maneuver
