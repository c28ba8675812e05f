#include "fluid/ellipsoid_derivatives.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// ∫ s^k ds / Δ³, Δ² = (x+s)(y+s)(z+s), s from 0 to ∞.
struct ShapeIntegrals {
  double I0;
  double I1;
  double I2;
};

// Duplication (1.18): positive terms only, symmetric in x, y, z; equal arguments end it at once.
ShapeIntegrals shape_integrals(double x, double y, double z) {
  const double mean = (x + y + z) / 3.0;  // makes the first-order term of the tail vanish
  const double spread = std::max({std::abs(x - mean), std::abs(y - mean), std::abs(z - mean)});
  if (spread < 1e-8 * mean) {
    const double power = 1.0 / (mean * std::sqrt(mean));
    return {2.0 / 7.0 * power / (mean * mean), 4.0 / 35.0 * power / mean, 16.0 / 105.0 * power};
  }
  const double p = std::sqrt(x);
  const double q = std::sqrt(y);
  const double r = std::sqrt(z);
  const double lambda = p * q + q * r + r * p;
  const double sum = p + q + r;
  const double pairs = (p + q) * (q + r) * (r + p);
  const double weight = 2.0 / (pairs * pairs);
  const ShapeIntegrals next = shape_integrals(0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
  const double shifted = 0.25 * lambda;
  return {weight * sum * sum / (p * q * r) + next.I0 / 64.0, weight * sum + (shifted * next.I0 + next.I1) / 16.0,
          weight * p * q * r + (shifted * (shifted * next.I0 + 2.0 * next.I1) + next.I2) / 4.0};
}

// (a ∂/∂a, b ∂/∂b, c ∂/∂c) of m_a/ρ, over V (1.15); x, y, z are the squares of a, b, c, I includes the factor abc.
Vector3d added_mass_slopes(double x, double y, double z, const ShapeIntegrals& I) {
  const double alpha = y * z * I.I0 + (y + z) * I.I1 + I.I2;
  const double others = x * (y + z) * I.I0 + (2.0 * x + y + z) * I.I1 + 2.0 * I.I2;  // β + γ
  const double L_ab = z * I.I1 + I.I2;
  const double L_ac = y * I.I1 + I.I2;
  const double own =
      x * ((y + z) * I.I0 + 2.0 * I.I1) * (y * z * I.I0 - I.I2) - (L_ab + L_ac) * (L_ab + L_ac);  // K_ab, K_ac inside
  return Vector3d(own, alpha * others + 2.0 * L_ab, alpha * others + 2.0 * L_ac) / (others * others);
}

// (E²/D) b ∂J_a/∂b over ρV/5, written in the integrals so that what grows in flat shapes is gone (1.16).
double crosswise_slope(double x, double y, double z, const ShapeIntegrals& I) {
  return x * y * z * (3.0 * y - z - 4.0 * x) * I.I0 * I.I0 +
         y * (8.0 * x * x + 3.0 * (y * z + x * y - x * z)) * I.I0 * I.I1 + 3.0 * y * (4.0 * x + z) * I.I0 * I.I2 +
         (4.0 * x * (x + z) + 10.0 * x * y + 3.0 * y * y + z * z) * I.I1 * I.I1 +
         (12.0 * x + 15.0 * y + 6.0 * z) * I.I1 * I.I2 + 9.0 * I.I2 * I.I2;
}

// (a ∂/∂a, b ∂/∂b, c ∂/∂c) of J_a/ρ, over V/5 (1.16).
Vector3d added_inertia_slopes(double a, double b, double c, const ShapeIntegrals& I) {
  const double x = a * a;
  const double y = b * b;
  const double z = c * c;
  const double D = (b - c) * (b + c);
  const double K = x * I.I0 + I.I1;
  const double E = y * z * I.I0 + (2.0 * x + y + z) * I.I1 + 3.0 * I.I2;  // α + 2L
  return D / (E * E) * Vector3d(D * (K * E + 2.0 * I.I1), crosswise_slope(x, y, z, I), -crosswise_slope(x, z, y, I));
}

}  // namespace

HomogeneousInertiaDerivatives homogeneous_inertia_derivatives(const Vector3d& semi_axes, double mass) {
  const Vector3d squares = semi_axes.cwiseAbs2();
  HomogeneousInertiaDerivatives result;
  result.by_semi_axes = 0.4 * mass * (Matrix3d::Ones() - Matrix3d::Identity()) * semi_axes.asDiagonal();
  result.by_mass = 0.2 * Vector3d(squares[1] + squares[2], squares[2] + squares[0], squares[0] + squares[1]);
  return result;
}

EllipsoidInertiaDerivatives ellipsoid_inertia_derivatives(const Vector3d& semi_axes, double density) {
  const EllipsoidInertia inertia = ellipsoid_inertia(semi_axes, density);  // refuses impossible arguments
  const EllipsoidInertia unit = ellipsoid_inertia(semi_axes, 1.0);         // all is proportional to density
  const double length = std::exp2(std::ilogb(semi_axes.maxCoeff()));  // a power of two leaves differences of axes exact
  const Vector3d s = semi_axes / length;
  ShapeIntegrals I = shape_integrals(s[0] * s[0], s[1] * s[1], s[2] * s[2]);
  for (double* integral : {&I.I0, &I.I1, &I.I2}) *integral *= s.prod();

  EllipsoidInertiaDerivatives result;
  result.by_density = {unit.mass, unit.body_inertia, unit.added_mass, unit.added_inertia};
  EllipsoidInertiaBySemiAxes& by_axes = result.by_semi_axes;
  by_axes.volume = inertia.volume * semi_axes.cwiseInverse();
  by_axes.mass = density * by_axes.volume;
  const HomogeneousInertiaDerivatives homogeneous = homogeneous_inertia_derivatives(semi_axes, inertia.mass);
  by_axes.body_inertia = homogeneous.by_semi_axes + homogeneous.by_mass * by_axes.mass.transpose();
  const double moment = 0.2 * inertia.mass * length * length;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    const Vector3d mass_slopes = inertia.mass * added_mass_slopes(s[i] * s[i], s[j] * s[j], s[k] * s[k], I);
    const Vector3d inertia_slopes = moment * added_inertia_slopes(s[i], s[j], s[k], I);
    const std::array<int, 3> columns = {i, j, k};
    for (int n = 0; n < 3; ++n) {
      const int column = columns[static_cast<std::size_t>(n)];
      by_axes.added_mass(i, column) = mass_slopes[n] / semi_axes[column];
      by_axes.added_inertia(i, column) = inertia_slopes[n] / semi_axes[column];
    }
  }
  return result;
}

}  // namespace lamprey::fluid
