#include "fluid/ellipse.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace lamprey::fluid {

using Eigen::Vector3d;

Vector3d ellipse_spread(const Eigen::Vector2d& semi_axes) {
  const Eigen::Vector2d s = semi_axes.cwiseAbs2();
  return {0.25 * s[1] + 1.0 / 12.0, 0.25 * s[0] + 1.0 / 12.0, 0.25 * (s[0] + s[1])};
}

EllipsoidInertia ellipse_inertia(const Eigen::Vector2d& semi_axes, double density) {
  require_valid_axes({semi_axes[0], semi_axes[1], semi_axes[1]}, density);
  const double a = semi_axes[0], b = semi_axes[1];
  const double displaced = density * std::numbers::pi;  // of a unit circle, kg/m²
  EllipsoidInertia result;
  result.volume = std::numbers::pi * a * b;
  result.mass = displaced * a * b;
  result.body_inertia = result.mass * ellipse_spread(semi_axes);
  result.added_mass = displaced * Vector3d(b * b, a * a, 0.0);
  const double difference = (a - b) * (a + b);
  result.added_inertia = Vector3d(0.0, 0.0, 0.125 * displaced * difference * difference);
  return result;
}

}  // namespace lamprey::fluid
