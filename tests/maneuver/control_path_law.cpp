#include "maneuver/control_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::ControlPath;
using maneuver::Interpolation;

// Uneven times from −0.5 on.
VectorXd uneven_times(Random& random, int count) {
  VectorXd times(count);
  times[0] = -0.5;
  for (int s = 1; s < count; ++s) times[s] = times[s - 1] + random.uniform(0.2, 1.5);
  return times;
}

MatrixXd random_samples(Random& random, int components, int count) {
  MatrixXd samples(components, count);
  for (double& v : samples.reshaped()) v = random.normal();
  return samples;
}

// Polynomials, one a row of coefficients in rising order.
VectorXd polynomial(const MatrixXd& coefficients, double t) {
  VectorXd value = VectorXd::Zero(coefficients.rows());
  for (Eigen::Index d = coefficients.cols(); d-- > 0;) value = value * t + coefficients.col(d);
  return value;
}

// Largest miss of a path through samples of a polynomial, at and between the samples and a little beyond both ends.
double miss(Interpolation interpolation, const MatrixXd& coefficients, const VectorXd& times) {
  MatrixXd samples(coefficients.rows(), times.size());
  for (Eigen::Index s = 0; s < times.size(); ++s) samples.col(s) = polynomial(coefficients, times[s]);
  const ControlPath path(interpolation, times, samples);
  const double length = times[times.size() - 1] - times[0];
  double largest = 0.0;
  for (double s = -0.1; s <= 1.1; s += 0.0137) {
    const VectorXd expected = polynomial(coefficients, times[0] + s * length);
    largest = std::max(largest, (path.value(times[0] + s * length) - expected).norm() / (1.0 + expected.norm()));
  }
  return largest;
}

TEST(ControlPath, slopes_are_those_of_the_cubic_it_gives_back) {
  Random random(73);
  const VectorXd times = uneven_times(random, 7);
  const MatrixXd coefficients = random_samples(random, 3, 4);
  MatrixXd samples(3, times.size());
  for (Eigen::Index s = 0; s < times.size(); ++s) samples.col(s) = polynomial(coefficients, times[s]);
  const ControlPath path(Interpolation::not_a_knot_cubic, times, samples);
  MatrixXd slopes(3, 3);
  for (Eigen::Index d = 0; d < 3; ++d) slopes.col(d) = static_cast<double>(d + 1) * coefficients.col(d + 1);
  for (double t = times[0] - 0.2; t < times[6] + 0.2; t += 0.0931) {
    const VectorXd expected = polynomial(slopes, t);
    EXPECT_LE((path.slope(t) - expected).norm(), tolerance(1e-11) * (1.0 + expected.norm())) << t;
  }
  EXPECT_EQ(ControlPath(Interpolation::linear, VectorXd::Zero(1), MatrixXd::Ones(2, 1)).slope(3.0), VectorXd::Zero(2));
}

TEST(ControlPath, not_a_knot_gives_back_any_cubic) {
  Random random(71);
  for (int count : {4, 5, 6, 12}) {
    const VectorXd times = uneven_times(random, count);
    EXPECT_LE(miss(Interpolation::not_a_knot_cubic, random_samples(random, 3, 4), times), tolerance(1e-11)) << count;
  }
  EXPECT_GT(miss(Interpolation::not_a_knot_cubic, random_samples(random, 3, 5), uneven_times(random, 12)), 1e-4)
      << "no spline gives back a quartic";
}

TEST(ControlPath, few_samples_give_the_polynomial_through_them) {
  Random random(72);
  for (int count : {1, 2, 3})
    EXPECT_LE(miss(Interpolation::not_a_knot_cubic, random_samples(random, 2, count), uneven_times(random, count)),
              tolerance(1e-12))
        << count;
}

TEST(ControlPath, the_natural_spline_and_the_polygon_give_back_straight_lines) {
  Random random(73);
  for (int count : {2, 3, 4, 9})
    for (Interpolation interpolation : {Interpolation::natural_cubic, Interpolation::linear})
      EXPECT_LE(miss(interpolation, random_samples(random, 2, 2), uneven_times(random, count)), tolerance(1e-12))
          << count;
}

TEST(ControlPath, every_path_goes_through_its_samples) {
  Random random(74);
  const VectorXd times = uneven_times(random, 9);
  const MatrixXd samples = random_samples(random, 3, 9);
  for (Interpolation interpolation :
       {Interpolation::linear, Interpolation::natural_cubic, Interpolation::not_a_knot_cubic}) {
    const ControlPath path(interpolation, times, samples);
    for (Eigen::Index s = 0; s < times.size(); ++s)
      EXPECT_LE((path.value(times[s]) - samples.col(s)).norm(), tolerance(1e-13));
  }
}

TEST(ControlPath, linear_runs_straight_between_samples) {
  Random random(75);
  const VectorXd times = uneven_times(random, 6);
  const MatrixXd samples = random_samples(random, 2, 6);
  const ControlPath path(Interpolation::linear, times, samples);
  for (Eigen::Index s = 0; s + 1 < times.size(); ++s)
    EXPECT_LE(
        (path.value(0.3 * times[s] + 0.7 * times[s + 1]) - 0.3 * samples.col(s) - 0.7 * samples.col(s + 1)).norm(),
        tolerance(1e-13));
}

// Second derivative at t of the cubic that runs from t in the direction of `step`: exact for cubics.
VectorXd curvature(const ControlPath& path, double t, double step) {
  return (2.0 * path.value(t) - 5.0 * path.value(t + step) + 4.0 * path.value(t + 2.0 * step) -
          path.value(t + 3.0 * step)) /
         (step * step);
}

VectorXd slope(const ControlPath& path, double t, double step) {
  return (-11.0 * path.value(t) + 18.0 * path.value(t + step) - 9.0 * path.value(t + 2.0 * step) +
          2.0 * path.value(t + 3.0 * step)) /
         (6.0 * step);
}

TEST(ControlPath, splines_join_in_slope_and_curvature_and_the_natural_one_ends_uncurved) {
  Random random(76);
  const VectorXd times = uneven_times(random, 8);
  const MatrixXd samples = random_samples(random, 3, 8);
  constexpr double step = 0.05;  // three of them stay within a piece
  for (Interpolation interpolation : {Interpolation::natural_cubic, Interpolation::not_a_knot_cubic}) {
    const ControlPath path(interpolation, times, samples);
    double largest = 0.0;
    for (Eigen::Index s = 1; s + 1 < times.size(); ++s) {
      EXPECT_LE((curvature(path, times[s], step) - curvature(path, times[s], -step)).norm(), tolerance(1e-9));
      EXPECT_LE((slope(path, times[s], step) - slope(path, times[s], -step)).norm(), tolerance(1e-11));
      largest = std::max(largest, curvature(path, times[s], step).norm());
    }
    EXPECT_GT(largest, 1.0);
    const double ends = curvature(path, times[0], step).norm() + curvature(path, times[7], -step).norm();
    if (interpolation == Interpolation::natural_cubic)
      EXPECT_LE(ends, tolerance(1e-9));
    else
      EXPECT_GT(ends, 1.0);
  }
}

TEST(SplineBasis, columns_are_unit_paths_that_sum_to_one) {
  for (int points : {2, 3, 5, 21}) {
    const double duration = 1.7;
    const VectorXd times = VectorXd::LinSpaced(101, 0.0, duration);
    const MatrixXd basis = maneuver::natural_spline_basis(points, duration, times);
    ASSERT_EQ(basis.rows(), 101);
    ASSERT_EQ(basis.cols(), points);
    EXPECT_LE((basis.rowwise().sum() - VectorXd::Ones(101)).lpNorm<Eigen::Infinity>(), tolerance(1e-13));
    const MatrixXd at_points =
        maneuver::natural_spline_basis(points, duration, VectorXd::LinSpaced(points, 0.0, duration));
    EXPECT_LE((at_points - MatrixXd::Identity(points, points)).lpNorm<Eigen::Infinity>(), tolerance(1e-13));
  }
}

TEST(SplineBasis, makes_the_same_path_as_the_spline_through_the_points) {
  Random random(77);
  const VectorXd times = VectorXd::LinSpaced(64, 0.0, 0.8);
  const MatrixXd values = random_samples(random, 2, 7);
  const ControlPath path(Interpolation::natural_cubic, VectorXd::LinSpaced(7, 0.0, 0.8), values);
  const MatrixXd by_basis = values * maneuver::natural_spline_basis(7, 0.8, times).transpose();
  for (Eigen::Index k = 0; k < times.size(); ++k)
    EXPECT_LE((path.value(times[k]) - by_basis.col(k)).norm(), tolerance(1e-13));
}

TEST(SplineThroughNodes, gives_back_the_spline_whose_samples_it_gets) {
  Random random(78);
  const VectorXd times = VectorXd::LinSpaced(101, 0.0, 1.0);
  const ControlPath path(Interpolation::natural_cubic, VectorXd::LinSpaced(11, 0.0, 1.0),
                         random_samples(random, 3, 11));
  MatrixXd samples(3, times.size());
  for (Eigen::Index k = 0; k < times.size(); ++k) samples.col(k) = path.value(times[k]);
  const ControlPath found = maneuver::natural_spline_through_nodes(11, times, samples);
  for (double t = 0.0; t <= 1.0; t += 0.0173) EXPECT_LE((found.value(t) - path.value(t)).norm(), tolerance(1e-12));
}

}  // namespace
}  // namespace lamprey::tests
