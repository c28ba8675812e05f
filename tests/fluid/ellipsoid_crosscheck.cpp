// Ellipsoids drawn at random against Lamb's integrals by the trapezoidal rule in log s, in 31-digit arithmetic: no
// Carlson function, no rearrangement, the cancelling textbook form of the moment.
#include "fluid/ellipsoid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fluid/double_double.hpp"
#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using tests::DoubleDouble;
using tests::two_product;
using Axes = std::array<double, 3>;

// Lamb's α, β, γ = abc ∫ ds / ((a²+s)Δ) …. With s = e^x the integrand is analytic for |Im x| < π, so that the
// trapezoidal rule of step log(2)/3 is wrong by exp(−2π²/step), 1e-37. The nodes 2^{k/3} span both tails down to 1e-31.
std::array<DoubleDouble, 3> lamb_integrals(const Axes& axes) {
  const DoubleDouble step = DoubleDouble{0.6931471805599453, 2.3190468138462996e-17} / DoubleDouble{3.0};
  const std::array<DoubleDouble, 3> roots = {DoubleDouble{1.0},
                                             DoubleDouble{1.2599210498948732, -2.589933375300507e-17},
                                             DoubleDouble{1.5874010519681996, -1.0869008194197823e-16}};
  const auto [shortest, longest] = std::minmax_element(axes.begin(), axes.end());
  const int first = static_cast<int>(std::floor(2.0 * std::log2(*shortest))) - 104;
  const int last = static_cast<int>(std::ceil(2.0 * std::log2(*longest))) + 70;
  std::array<DoubleDouble, 3> squares;
  std::transform(axes.begin(), axes.end(), squares.begin(), [](double a) { return two_product(a, a); });
  std::array<DoubleDouble, 3> sums;
  for (int octave = first; octave <= last; ++octave) {
    for (const DoubleDouble& root : roots) {
      const DoubleDouble s = {std::ldexp(root.high, octave), std::ldexp(root.low, octave)};
      const DoubleDouble A = squares[0] + s;
      const DoubleDouble B = squares[1] + s;
      const DoubleDouble C = squares[2] + s;
      const DoubleDouble product = A * B * C;
      const DoubleDouble common = s / (product * sqrt(product));
      sums[0] = sums[0] + common * B * C;
      sums[1] = sums[1] + common * C * A;
      sums[2] = sums[2] + common * A * B;
    }
  }
  for (DoubleDouble& sum : sums) sum = sum * step * (axes[0] * (axes[1] * DoubleDouble{axes[2]}));
  return sums;
}

// Added mass over ρV, then added inertia over ρV m².
std::array<double, 6> reference(const Axes& axes) {
  const std::array<DoubleDouble, 3> lamb = lamb_integrals(axes);
  std::array<double, 6> result{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    const DoubleDouble b = two_product(axes[j], axes[j]);
    const DoubleDouble c = two_product(axes[k], axes[k]);
    const DoubleDouble numerator = (b - c) * (b - c) * (lamb[k] - lamb[j]);
    const DoubleDouble denominator = 5.0 * (2.0 * (b - c) + (b + c) * (lamb[j] - lamb[k]));
    result[i] = (lamb[i] / (DoubleDouble{2.0} - lamb[i])).high;
    result[3 + i] = (numerator / denominator).high;
  }
  return result;
}

// Largest relative difference of the six added coefficients over `count` ellipsoids, axes log-uniform in [1, aspect].
double largest_difference(double aspect, int count, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> exponent(0.0, std::log(aspect));
  double largest = 0.0;
  for (int n = 0; n < count; ++n) {
    const Axes axes = {std::exp(exponent(generator)), std::exp(exponent(generator)), std::exp(exponent(generator))};
    const EllipsoidInertia inertia = ellipsoid_inertia({axes[0], axes[1], axes[2]}, 1.0);
    const std::array<double, 6> expected = reference(axes);
    for (int i = 0; i < 3; ++i) {
      const double mass = inertia.added_mass[i] / inertia.mass;
      const double moment = inertia.added_inertia[i] / inertia.mass;
      const auto at = static_cast<std::size_t>(i);
      largest = std::max(largest, std::abs(mass / expected[at] - 1.0));
      largest = std::max(largest, std::abs(moment / expected[3 + at] - 1.0));
    }
  }
  return largest;
}

}  // namespace

TEST(EllipsoidAgainstLamb, the_reference_obeys_the_sum_rule_to_thirty_digits) {
  for (const Axes& axes : {Axes{1.0, 1.0, 1.0}, Axes{8.0, 1.5, 2.0}, Axes{1000.0, 1.0, 31.0}}) {
    const auto lamb = lamb_integrals(axes);
    EXPECT_LT(std::abs((lamb[0] + lamb[1] + lamb[2] - DoubleDouble{2.0}).high), tests::tolerance(1e-30));
  }
}

TEST(EllipsoidAgainstLamb, six_thousand_random_ellipsoids_up_to_aspect_ten_agree) {
  EXPECT_LT(largest_difference(10.0, 6000, 1), tests::tolerance(1e-14));
}

TEST(EllipsoidAgainstLamb, four_thousand_random_ellipsoids_up_to_aspect_a_thousand_agree) {
  EXPECT_LT(largest_difference(1e3, 4000, 2), tests::tolerance(1e-14));
}

TEST(EllipsoidAgainstLamb, a_thousand_random_ellipsoids_up_to_aspect_a_million_agree) {
  EXPECT_LT(largest_difference(1e6, 1000, 3), tests::tolerance(1e-14));
}

}  // namespace lamprey::fluid
