// Four numbers, each with its rate along one direction: what is written for Four gives its derivative as well.
#pragma once

#include "algebra/four.hpp"

namespace lamprey::algebra {

struct DualFour {
  Four value, rate;
};

inline DualFour operator+(const DualFour& a, const DualFour& b) { return {a.value + b.value, a.rate + b.rate}; }
inline DualFour operator-(const DualFour& a, const DualFour& b) { return {a.value - b.value, a.rate - b.rate}; }
inline DualFour operator-(const DualFour& a) { return {-a.value, -a.rate}; }
inline DualFour operator*(const DualFour& a, const DualFour& b) {
  return {a.value * b.value, a.value * b.rate + a.rate * b.value};
}
inline DualFour operator*(double s, const DualFour& a) { return {s * a.value, s * a.rate}; }
inline DualFour operator*(const DualFour& a, double s) { return s * a; }
inline DualFour operator+(const DualFour& a, double s) { return {a.value + s, a.rate}; }
inline DualFour operator/(double s, const DualFour& a) {
  const Four value = s / a.value;
  return {value, -value / a.value * a.rate};
}
inline DualFour square_root(const DualFour& a) {
  const Four value = square_root(a.value);
  return {value, 0.5 / value * a.rate};
}

}  // namespace lamprey::algebra
