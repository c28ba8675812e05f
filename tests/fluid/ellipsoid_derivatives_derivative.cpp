#include "fluid/ellipsoid_derivatives.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "difference_order.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

const double density = 3.7;

const std::vector<Vector3d> different_axes = {{8.0, 1.5, 2.0},  {5.0, 0.8, 1.5},   {1.0, 2.0, 2.5},
                                              {1.0, 10.0, 3.0}, {300.0, 1.0, 7.0}, {1e3, 20.0, 1.0}};
const std::vector<Vector3d> equal_axes = {{2.0, 1.0, 1.0}, {1.0, 0.5, 1.0},        {0.7, 0.7, 0.7},
                                          {1e3, 1.0, 1.0}, {1.0, 2.0, 2.0 + 1e-9}, {1.0, 1.0 + 1e-15, 1.0}};

// f(t) with the axes grown by the factors 1 + t direction.
template <typename Entry>
std::function<VectorXd(double)> along(const Vector3d& semi_axes, const Vector3d& direction, Entry entry) {
  return [=](double t) {
    const Vector3d grown = semi_axes.cwiseProduct(Vector3d::Ones() + t * direction);
    return VectorXd(entry(ellipsoid_inertia(grown, density)));
  };
}

// Difference relative to the row's largest entry, per unit of relative change of the axes; at most 3 rows.
double largest_row_difference(const Vector3d& sums, const Vector3d& expected, const Matrix3d& slopes) {
  double largest = 0.0;
  for (int i = 0; i < 3; ++i)
    largest = std::max(largest, std::abs(sums[i] - expected[i]) / slopes.row(i).cwiseAbs().maxCoeff());
  return largest;
}

void expect_differences_match(const Vector3d& semi_axes, const Vector3d& direction) {
  const Vector3d step = semi_axes.cwiseProduct(direction);
  const auto derivatives = ellipsoid_inertia_derivatives(semi_axes, density).by_semi_axes;
  tests::expect_second_order_differences(
      along(semi_axes, direction, [](const EllipsoidInertia& inertia) { return inertia.body_inertia; }),
      derivatives.body_inertia * step, 1e-11);
  tests::expect_second_order_differences(
      along(semi_axes, direction, [](const EllipsoidInertia& inertia) { return inertia.added_mass; }),
      derivatives.added_mass * step, 1e-11);
  if (!ellipsoid_inertia(semi_axes, density).added_inertia.isZero(1e-20)) {
    tests::expect_second_order_differences(
        along(semi_axes, direction, [](const EllipsoidInertia& inertia) { return inertia.added_inertia; }),
        derivatives.added_inertia * step, 1e-11);
  }
}

}  // namespace

TEST(EllipsoidDerivatives, match_central_differences_at_second_order_for_different_axes) {
  for (const Vector3d& semi_axes : different_axes) {
    SCOPED_TRACE(testing::Message() << semi_axes.transpose());
    expect_differences_match(semi_axes, {0.8, -1.1, 0.6});
    expect_differences_match(semi_axes, {-0.4, 0.9, 1.3});
  }
}

TEST(EllipsoidDerivatives, match_central_differences_at_second_order_for_equal_axes) {
  for (const Vector3d& semi_axes : equal_axes) {
    SCOPED_TRACE(testing::Message() << semi_axes.transpose());
    expect_differences_match(semi_axes, {0.8, -1.1, 0.6});
    expect_differences_match(semi_axes, {-0.4, 0.9, 1.3});
  }
}

// One by one, so that no small entry hides behind a large one; relative to each entry's own value.
TEST(EllipsoidDerivatives, single_entries_match_central_differences_at_second_order) {
  const Vector3d semi_axes(8.0, 1.5, 2.0);
  const auto derivatives = ellipsoid_inertia_derivatives(semi_axes, density).by_semi_axes;
  for (int column = 0; column < 3; ++column) {
    const Vector3d direction = Vector3d::Unit(column);
    for (int row = 0; row < 3; ++row) {
      SCOPED_TRACE(testing::Message() << "row " << row << ", column " << column);
      const auto mass = [row](const EllipsoidInertia& inertia) { return VectorXd(inertia.added_mass.segment(row, 1)); };
      const auto moment = [row](const EllipsoidInertia& inertia) {
        return VectorXd(inertia.added_inertia.segment(row, 1));
      };
      tests::expect_second_order_differences(
          along(semi_axes, direction, mass),
          VectorXd::Constant(1, derivatives.added_mass(row, column) * semi_axes[column]), 1e-10);
      tests::expect_second_order_differences(
          along(semi_axes, direction, moment),
          VectorXd::Constant(1, derivatives.added_inertia(row, column) * semi_axes[column]), 1e-10);
    }
  }
}

TEST(EllipsoidDerivatives, of_volume_and_mass_match_central_differences_at_second_order) {
  const Vector3d semi_axes(5.0, 0.8, 1.5);
  const Vector3d direction(0.8, -1.1, 0.6);
  const auto derivatives = ellipsoid_inertia_derivatives(semi_axes, density).by_semi_axes;
  const auto both = [](const EllipsoidInertia& inertia) { return Eigen::Vector2d(inertia.volume, inertia.mass); };
  const Vector3d step = semi_axes.cwiseProduct(direction);
  tests::expect_second_order_differences(along(semi_axes, direction, both),
                                         Eigen::Vector2d(derivatives.volume.dot(step), derivatives.mass.dot(step)),
                                         1e-11);
}

// Proportional to density: a difference over any distance is the derivative.
TEST(EllipsoidDerivatives, by_density_are_differences_over_any_distance) {
  for (const Vector3d& semi_axes : different_axes) {
    const auto derivatives = ellipsoid_inertia_derivatives(semi_axes, density).by_density;
    const auto high = ellipsoid_inertia(semi_axes, density + 2.0);
    const auto low = ellipsoid_inertia(semi_axes, density - 2.0);
    EXPECT_NEAR((high.mass - low.mass) / (4.0 * derivatives.mass), 1.0, tests::tolerance(1e-14));
    const auto expect_slope = [](const Vector3d& difference, const Vector3d& slope) {
      EXPECT_LT((difference / 4.0 - slope).cwiseQuotient(slope).norm(), tests::tolerance(1e-14));
    };
    expect_slope(high.body_inertia - low.body_inertia, derivatives.body_inertia);
    expect_slope(high.added_mass - low.added_mass, derivatives.added_mass);
    expect_slope(high.added_inertia - low.added_inertia, derivatives.added_inertia);
  }
}

TEST(EllipsoidDerivatives, of_a_given_mass_match_central_differences_at_second_order) {
  const Vector3d semi_axes(5.0, 0.8, 1.5);
  const Vector3d step(0.7, -0.3, 0.4);
  const auto inertia = [&](double t) {
    const Vector3d s = (semi_axes + t * step).cwiseAbs2();
    const double mass = 2.4 * (1.0 + t);  // both change, so that the difference quotient is not exact
    return VectorXd(mass / 5.0 * Vector3d(s[1] + s[2], s[2] + s[0], s[0] + s[1]));
  };
  const auto derivatives = homogeneous_inertia_derivatives(semi_axes, 2.4);
  tests::expect_second_order_differences(inertia, derivatives.by_semi_axes * step + derivatives.by_mass * 2.4, 1e-11);
}

// Euler: mass and added mass are of degree 3 in the axes, inertia of degree 5. The values come from Carlson's R_D and
// another integral, the derivatives from three others, so that this is no identity of the code.
TEST(EllipsoidDerivatives, a_thousand_random_ellipsoids_obey_eulers_theorem_up_to_aspect_a_million) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> exponent(0.0, std::log(1e6));
  double mass_difference = 0.0;
  double inertia_difference = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const Vector3d axes(std::exp(exponent(generator)), std::exp(exponent(generator)), std::exp(exponent(generator)));
    const auto inertia = ellipsoid_inertia(axes, 1.0);
    const auto derivatives = ellipsoid_inertia_derivatives(axes, 1.0).by_semi_axes;
    mass_difference =
        std::max(mass_difference, largest_row_difference(derivatives.added_mass * axes, 3.0 * inertia.added_mass,
                                                         derivatives.added_mass * axes.asDiagonal()));
    inertia_difference = std::max(inertia_difference,
                                  largest_row_difference(derivatives.added_inertia * axes, 5.0 * inertia.added_inertia,
                                                         derivatives.added_inertia * axes.asDiagonal()));
  }
  EXPECT_LT(mass_difference, tests::tolerance(2e-14));
  EXPECT_LT(inertia_difference, tests::tolerance(2e-14));
  EXPECT_GT(mass_difference + inertia_difference, 0.0);
}

TEST(EllipsoidDerivatives, renaming_the_axes_renames_rows_and_columns) {
  const std::vector<std::array<int, 3>> orders = {{1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  for (const Vector3d& semi_axes : different_axes) {
    const auto plain = ellipsoid_inertia_derivatives(semi_axes, density).by_semi_axes;
    for (const auto& order : orders) {
      const auto renamed = ellipsoid_inertia_derivatives(semi_axes(order), density).by_semi_axes;
      const auto expect_renamed = [&](const Matrix3d& value, const Matrix3d& expected) {
        EXPECT_LT((value - expected(order, order)).norm() / expected.norm(), tests::tolerance(2e-15));
      };
      expect_renamed(renamed.body_inertia, plain.body_inertia);
      expect_renamed(renamed.added_mass, plain.added_mass);
      expect_renamed(renamed.added_inertia, plain.added_inertia);
    }
  }
}

TEST(EllipsoidDerivatives, nearly_equal_axes_approach_equal_ones_in_proportion_to_the_gap) {
  const auto equal = ellipsoid_inertia_derivatives({2.0, 1.0, 1.0}, 1.0).by_semi_axes;
  for (const double gap : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13}) {
    const auto near = ellipsoid_inertia_derivatives({2.0, 1.0 + gap, 1.0}, 1.0).by_semi_axes;
    const double mass = (near.added_mass - equal.added_mass).norm() / gap;
    const double inertia = (near.added_inertia - equal.added_inertia).norm() / gap;
    EXPECT_GT(mass, 1.0);
    EXPECT_LT(mass, 20.0);
    EXPECT_GT(inertia, 1.0);
    EXPECT_LT(inertia, 20.0);
  }
}

TEST(EllipsoidDerivatives, about_an_axis_of_revolution_are_exactly_zero) {
  for (const double axis : {1e-3, 0.5, 2.0, 1e4}) {
    EXPECT_EQ(ellipsoid_inertia_derivatives({axis, 1.0, 1.0}, 1.0).by_semi_axes.added_inertia.row(0),
              Eigen::RowVector3d::Zero());
    EXPECT_NE(ellipsoid_inertia_derivatives({axis, 1.0, 1.0}, 1.0).by_semi_axes.added_inertia(1, 0), 0.0);
  }
  EXPECT_EQ(ellipsoid_inertia_derivatives({0.3, 0.3, 0.3}, 1.0).by_semi_axes.added_inertia, Matrix3d::Zero());
}

TEST(EllipsoidDerivatives, stay_finite_at_the_edge_of_the_domain_and_refuse_what_lies_beyond) {
  for (const Vector3d& edge : {Vector3d(1.0, 1e-49, 1e-49), Vector3d(1.0, 1.0, 1e-49), Vector3d(1e-49, 1e-20, 1.0)}) {
    const auto derivatives = ellipsoid_inertia_derivatives(edge, 1.0).by_semi_axes;
    EXPECT_TRUE(derivatives.added_mass.allFinite()) << derivatives.added_mass;
    EXPECT_TRUE(derivatives.added_inertia.allFinite()) << derivatives.added_inertia;
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ellipsoid_inertia_derivatives({1.0, 0.0, 1.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(ellipsoid_inertia_derivatives({1.0, nan, 1.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(ellipsoid_inertia_derivatives({1.0, 1.0, 1.0}, -1.0), std::invalid_argument);
}

}  // namespace lamprey::fluid
