// Derivative against central differences, with the order of the error checked.
#pragma once

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "tolerance.hpp"

namespace lamprey::tests {

/// Checks that central differences of f at 0 approach `derivative` at second order in the step, and how near they come.
/// The sweep halves the step from `first`; the order is read from plain quotients where truncation rules, the nearest
/// approach from two neighbouring quotients combined (Richardson), which leaves more room above round-off.
inline void expect_second_order_differences(const std::function<Eigen::VectorXd(double)>& f,
                                            const Eigen::VectorXd& derivative, double best_relative = 1e-9,
                                            double first = 0.02) {
  const double size = derivative.lpNorm<Eigen::Infinity>();
  ASSERT_GT(size, 0.0) << "the derivative must not vanish, or the check says nothing";
  double best = INFINITY;
  double coarse = 0.0, fine = 0.0;
  bool equal = true;
  Eigen::VectorXd previous;
  for (int halving = 0; halving < 14; ++halving) {
    const double t = std::ldexp(first, -halving);
    const Eigen::VectorXd quotient = (f(t) - f(-t)) / (2.0 * t);
    const double error = (quotient - derivative).lpNorm<Eigen::Infinity>() / size;
    equal = equal && error == 0.0;
    best = std::min(best, error);
    if (halving > 0)
      best = std::min(best, ((4.0 * quotient - previous) / 3.0 - derivative).lpNorm<Eigen::Infinity>() / size);
    previous = quotient;
    if (halving == 0) coarse = error;
    if (halving == 3) fine = error;
  }
  EXPECT_FALSE(equal) << "bit-equal: the same path ran twice";
  EXPECT_LE(best, tolerance(best_relative));
  if (coarse > 1e-9) {
    EXPECT_NEAR(std::log2(coarse / fine) / 3.0, 2.0, 0.1) << "coarse " << coarse << ", fine " << fine;
  }
}

}  // namespace lamprey::tests
