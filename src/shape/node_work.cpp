#include "shape/node_work.hpp"

#include <cmath>

namespace lamprey::shape {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Where on the edge change = (1 − mean²)/2 the slopes are that are nearest to a point beyond it, both of whose entries are
// positive: the real root of S³ + (1 + 2b) S − 2a = 0 (equation 13.7).
double nearest_on_edge(const Vector2d& beyond) {
  const double p = 1.0 + 2.0 * beyond[1], q = 2.0 * beyond[0];
  return 2.0 * std::sqrt(p / 3.0) * std::sinh(std::asinh(1.5 * q / p * std::sqrt(3.0 / p)) / 3.0);
}

// Slopes of |power| where it changes its sign between the steps.
WorkSlopes slopes_of(const NodePower& power) {
  const double m = power[0], d = power[1];
  if (std::abs(m) >= std::abs(d)) return {m == 0.0 ? 0.0 : std::copysign(1.0, m), 0.0};
  const double S = m / std::abs(d);
  return {S, std::copysign(0.5 * (1.0 - S * S), d)};
}

WorkTerm exact_term(const NodePower& power) {
  const double m = power[0], d = power[1];
  WorkTerm term{mean_work(power), slopes_of(power), Matrix2d::Zero()};
  if (std::abs(m) >= std::abs(d)) return term;
  const Vector2d across(1.0, -m / d);
  term.curvature = across / std::abs(d) * across.transpose();
  return term;
}

}  // namespace

double mean_work(const NodePower& power) {
  const double m = std::abs(power[0]), d = std::abs(power[1]);
  return m >= d ? m : 0.5 * (m * m / d + d);
}

WorkTerm work_term(const NodePower& power, const WorkSlopes& multiplier, double weight) {
  if (weight <= 0.0) return exact_term(power);
  const Vector2d pulled = multiplier + weight * power;
  const Vector2d side(pulled[0] < 0.0 ? -1.0 : 1.0, pulled[1] < 0.0 ? -1.0 : 1.0);
  const Vector2d beyond = pulled.cwiseAbs();
  WorkTerm term{0.0, pulled, Matrix2d::Zero()};
  if (beyond[1] <= 0.5 * (1.0 - beyond[0] * beyond[0])) {
    term.curvature = weight * Matrix2d::Identity();
  } else if (beyond[0] - 1.0 >= beyond[1]) {
    term.slope = {side[0], 0.0};
  } else {
    const double S = nearest_on_edge(beyond);
    const Vector2d along(side[0], -S * side[1]);
    term.slope = {side[0] * S, side[1] * 0.5 * (1.0 - S * S)};
    term.curvature = weight / (1.5 * S * S + 0.5 + beyond[1]) * along * along.transpose();
  }
  term.value = term.slope.dot(power) - 0.5 / weight * (term.slope - multiplier).squaredNorm();
  return term;
}

double work_misfit(const NodePower& power, const WorkSlopes& slopes) {
  return (work_term(power, slopes, 1.0).slope - slopes).norm();
}

}  // namespace lamprey::shape
