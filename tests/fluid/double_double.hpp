// Arithmetic with 31 digits: a number as the unevaluated sum of two doubles (Dekker 1971, Knuth, TAOCP 4.2.2).
#pragma once

#include <cmath>

namespace lamprey::tests {

struct DoubleDouble {
  double high = 0.0;
  double low = 0.0;
};

inline DoubleDouble quick_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

inline DoubleDouble two_sum(double a, double b) {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

inline DoubleDouble two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble high = two_sum(a.high, b.high);
  const DoubleDouble low = two_sum(a.low, b.low);
  const DoubleDouble sum = quick_two_sum(high.high, high.low + low.high);
  return quick_two_sum(sum.high, sum.low + low.low);
}

inline DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }
inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + (-b); }

inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble product = two_product(a.high, b.high);
  return quick_two_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

inline DoubleDouble operator*(double a, DoubleDouble b) { return DoubleDouble{a} * b; }

inline DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
  const double first = a.high / b.high;
  const DoubleDouble remainder = a - first * b;
  const double second = remainder.high / b.high;
  const double third = (remainder - second * b).high / b.high;
  return quick_two_sum(first, second) + DoubleDouble{third};
}

inline DoubleDouble sqrt(DoubleDouble a) {
  const double root = std::sqrt(a.high);
  return quick_two_sum(root, 0.5 * (a - two_product(root, root)).high / root);
}

}  // namespace lamprey::tests
