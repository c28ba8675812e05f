#include "fluid/ellipsoid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <boost/math/special_functions/ellint_rd.hpp>

namespace lamprey::fluid {

namespace {

using Eigen::Vector3d;

// ∫ ds / ((y+s)(z+s)Δ), Δ² = (x+s)(y+s)(z+s), s from 0 to ∞: ⅔ (R_D(x,y,z) − R_D(x,z,y))/(y−z) in Carlson's terms. His
// duplication theorem, with y − z divided out by hand, leaves a sum of positive terms that needs no y ≠ z.
double shared_integral(double x, double y, double z) {
  double sum = 0.0;
  double weight = 1.0;
  while (true) {
    const double mean = (x + 3.0 * y + 3.0 * z) / 7.0;  // makes the first-order term of the tail vanish
    const double spread = std::max({std::abs(x - mean), std::abs(y - mean), std::abs(z - mean)});
    if (spread < 1e-8 * mean) return sum + weight * 0.4 / (mean * mean * std::sqrt(mean));
    const double p = std::sqrt(x);
    const double q = std::sqrt(y);
    const double r = std::sqrt(z);
    const double lambda = p * q + q * r + r * p;
    sum += weight * 2.0 * (y + z + q * r + lambda) / ((q + r) * q * r * (y + lambda) * (z + lambda));
    weight /= 16.0;
    x = 0.25 * (x + lambda);
    y = 0.25 * (y + lambda);
    z = 0.25 * (z + lambda);
  }
}

// Lamb's α = abc ∫ ds / ((a²+s)Δ), Δ² = (a²+s)(b²+s)(c²+s); the three of them add up to 2.
double lamb_coefficient(double a, double b, double c) {
  return 2.0 / 3.0 * a * b * c * boost::math::ellint_rd(b * b, c * c, a * a);
}

// J_x/(ρV/5) = (b²−c²)² K/(α+2L) with L = β − c²K; taking c as the shorter axis keeps that difference harmless.
double added_inertia_ratio(double a, double b, double c) {
  if (b < c) std::swap(b, c);
  const double difference = (b - c) * (b + c);
  const double K = a * b * c * shared_integral(a * a, b * b, c * c);
  const double L = lamb_coefficient(b, c, a) - c * c * K;
  return difference * difference * K / (lamb_coefficient(a, b, c) + 2.0 * L);
}

}  // namespace

void require_valid_axes(const Vector3d& semi_axes, double density) {
  for (const double axis : semi_axes) {
    if (!(axis > 0.0) || !std::isfinite(axis)) {
      throw std::invalid_argument("semi-axes must be positive and finite lengths in m");
    }
  }
  if (semi_axes.minCoeff() < 1e-50 * semi_axes.maxCoeff()) {
    throw std::invalid_argument("semi-axes must not differ by more than a factor of 1e50");
  }
  if (!(density >= 0.0) || !std::isfinite(density)) {
    throw std::invalid_argument("density must be finite and not negative, in kg/m³");
  }
}

EllipsoidInertia ellipsoid_inertia(const Vector3d& semi_axes, double density) {
  require_valid_axes(semi_axes, density);
  const double length = std::exp2(std::ilogb(semi_axes.maxCoeff()));  // a power of two leaves differences of axes exact
  const Vector3d s = semi_axes / length;
  const double alpha = lamb_coefficient(s[0], s[1], s[2]);
  const double beta = lamb_coefficient(s[1], s[2], s[0]);
  const double gamma = lamb_coefficient(s[2], s[0], s[1]);

  EllipsoidInertia result;
  result.volume = 4.0 / 3.0 * std::numbers::pi * semi_axes.prod();
  result.mass = density * result.volume;
  const double moment = 0.2 * result.mass * length * length;
  result.body_inertia =
      moment * Vector3d(s[1] * s[1] + s[2] * s[2], s[2] * s[2] + s[0] * s[0], s[0] * s[0] + s[1] * s[1]);
  result.added_mass = result.mass * Vector3d(alpha / (beta + gamma), beta / (gamma + alpha), gamma / (alpha + beta));
  result.added_inertia = moment * Vector3d(added_inertia_ratio(s[0], s[1], s[2]), added_inertia_ratio(s[1], s[2], s[0]),
                                           added_inertia_ratio(s[2], s[0], s[1]));
  return result;
}

}  // namespace lamprey::fluid
