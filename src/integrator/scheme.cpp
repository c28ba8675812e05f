#include "integrator/scheme.hpp"

#include <cmath>

namespace lamprey::integrator {

namespace {

using mechanics::DiscreteLagrangian;

// Seven stages of Suzuki's family: p three times, 1 − 6p, p three times, with 6p³ + (1 − 6p)³ = 0.
std::vector<double> suzuki() {
  const double p = 1.0 / (6.0 - std::cbrt(6.0));
  return {p, p, p, 1.0 - 6.0 * p, p, p, p};
}

// Eleven stages of order 6 (Sofroniou & Spaletta 2005).
std::vector<double> sofroniou_spaletta() {
  const double a = 0.2137558394587825455551807;
  const double b = 0.1832938140742571391138597;
  const double c = 0.1769281947309894379488981;
  const double d = -0.4432908268117021584962283;
  const double e = 0.1172856043286593538540359;
  return {a, b, c, d, e, 1.0 - 2.0 * (a + b + c + d + e), e, d, c, b, a};
}

}  // namespace

const Composition& composition(Scheme scheme) {
  static const Composition paper{DiscreteLagrangian::paper, {1.0}};
  static const Composition trapezoid{DiscreteLagrangian::trapezoid, {1.0}};
  static const Composition midpoint{DiscreteLagrangian::midpoint, {1.0}};
  static const Composition order4{DiscreteLagrangian::midpoint, suzuki()};
  static const Composition order6{DiscreteLagrangian::midpoint, sofroniou_spaletta()};
  switch (scheme) {
    case Scheme::paper:
      return paper;
    case Scheme::trapezoid:
      return trapezoid;
    case Scheme::midpoint:
      return midpoint;
    case Scheme::order4:
      return order4;
    case Scheme::order6:
      break;
  }
  return order6;
}

int order(Scheme scheme) {
  switch (scheme) {
    case Scheme::paper:
      return 1;
    case Scheme::trapezoid:
    case Scheme::midpoint:
      return 2;
    case Scheme::order4:
      return 4;
    case Scheme::order6:
      break;
  }
  return 6;
}

}  // namespace lamprey::integrator
