// Derivative against central differences, with the order of the error checked.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "tolerance.hpp"

namespace lamprey::tests {

/// Checks that central differences of f at 0 approach `derivative` at second order in the step, and how near they come.
/// The sweep halves the step from `first`; the order is read from plain quotients where truncation rules, the nearest
/// approach from two neighbouring quotients combined (Richardson), which leaves more room above round-off. Where f has
/// kinks in higher derivatives near 0, the order shows within them alone: at one of the first `scales` steps.
inline void expect_second_order_differences(const std::function<Eigen::VectorXd(double)>& f,
                                            const Eigen::VectorXd& derivative, double best_relative = 1e-9,
                                            double first = 0.02, int scales = 1) {
  const double size = derivative.lpNorm<Eigen::Infinity>();
  ASSERT_GT(size, 0.0) << "the derivative must not vanish, or the check says nothing";
  double best = INFINITY;
  std::vector<double> errors;
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
    errors.push_back(error);
  }
  EXPECT_FALSE(equal) << "bit-equal: the same path ran twice";
  EXPECT_LE(best, tolerance(best_relative));
  if (errors.front() <= 1e-9) return;
  double order = 0.0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(scales) && std::abs(order - 2.0) > 0.1; ++n)
    order = std::log2(errors[n] / errors[n + 3]) / 3.0;
  EXPECT_NEAR(order, 2.0, 0.1) << "coarse " << errors[0] << ", fine " << errors[3];
}

/// Checks that (f(t) + f(−t) − 2 f(0))/t² approaches `expected` at second order: at one of the steps 1, ½, … 1/32, for
/// kinks in f's higher derivatives hide the order until they are left outside.
inline void expect_second_order_curvature(const std::function<double(double)>& f, double expected) {
  ASSERT_NE(expected, 0.0) << "the curvature must not vanish, or the check says nothing";
  const double here = f(0.0);
  const auto error = [&](double t) { return ((f(t) + f(-t) - 2.0 * here) / (t * t) - expected) / std::abs(expected); };
  double nearest = INFINITY;
  std::string seen;
  for (int halving = 0; halving < 6; ++halving) {
    const double t = std::ldexp(1.0, -halving), coarse = error(t), fine = error(t / 4.0);
    const double order = std::log2(std::abs(coarse / fine)) / 2.0;
    const double left = std::abs((16.0 * fine - coarse) / 15.0);
    seen += "\n  step " + std::to_string(t) + ": errors " + std::to_string(coarse) + " and " + std::to_string(fine);
    if (std::abs(coarse) > 1e-5 && std::abs(order - 2.0) > 0.2) continue;  // else as good as exact
    nearest = std::min(nearest, left);
    if (nearest <= tolerance(1e-4)) break;
  }
  EXPECT_LE(nearest, tolerance(1e-4)) << seen;
}

}  // namespace lamprey::tests
