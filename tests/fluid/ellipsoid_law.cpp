#include "fluid/ellipsoid.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Vector3d;
using std::numbers::pi;

const std::vector<Vector3d> shapes = {
    {8.0, 1.5, 2.0}, {5.0, 0.8, 1.5}, {1.0, 2.0, 2.5}, {300.0, 1.0, 7.0}, {1.0, 1.0, 0.5}};

double relative_difference(const Vector3d& a, const Vector3d& b) { return (a - b).norm() / b.norm(); }

}  // namespace

TEST(Ellipsoid, a_sphere_drags_half_its_mass_along_and_turns_freely) {
  for (const double radius : {1e-3, 0.7, 40.0}) {
    const auto sphere = ellipsoid_inertia(Vector3d::Constant(radius), 3.0);
    EXPECT_NEAR(sphere.volume / (4.0 / 3.0 * pi * radius * radius * radius), 1.0, tests::tolerance(1e-15));
    EXPECT_LT((sphere.added_mass / sphere.mass - Vector3d::Constant(0.5)).norm(), tests::tolerance(1e-15));
    EXPECT_LT((sphere.body_inertia / (0.4 * sphere.mass * radius * radius) - Vector3d::Ones()).norm(),
              tests::tolerance(1e-15));
    EXPECT_EQ(sphere.added_inertia, Vector3d::Zero());
  }
}

TEST(Ellipsoid, everything_grows_in_proportion_to_density) {
  for (const Vector3d& shape : shapes) {
    const auto one = ellipsoid_inertia(shape, 1.0);
    const auto seven = ellipsoid_inertia(shape, 7.0);
    EXPECT_DOUBLE_EQ(seven.volume, one.volume);
    EXPECT_DOUBLE_EQ(seven.mass, 7.0 * one.mass);
    EXPECT_LT(relative_difference(seven.body_inertia, 7.0 * one.body_inertia), tests::tolerance(1e-15));
    EXPECT_LT(relative_difference(seven.added_mass, 7.0 * one.added_mass), tests::tolerance(1e-15));
    EXPECT_LT(relative_difference(seven.added_inertia, 7.0 * one.added_inertia), tests::tolerance(1e-15));
  }
}

TEST(Ellipsoid, mass_grows_with_the_third_and_inertia_with_the_fifth_power_of_size) {
  for (const Vector3d& shape : shapes) {
    for (const double size : {1e-4, 0.3, 50.0}) {
      const auto unit = ellipsoid_inertia(shape, 1.0);
      const auto scaled = ellipsoid_inertia(size * shape, 1.0);
      EXPECT_LT(relative_difference(scaled.added_mass, std::pow(size, 3) * unit.added_mass), tests::tolerance(1e-14));
      EXPECT_LT(relative_difference(scaled.added_inertia, std::pow(size, 5) * unit.added_inertia),
                tests::tolerance(1e-14));
      EXPECT_LT(relative_difference(scaled.body_inertia, std::pow(size, 5) * unit.body_inertia),
                tests::tolerance(1e-14));
    }
  }
}

TEST(Ellipsoid, renaming_the_axes_renames_the_entries) {
  for (const Vector3d& shape : shapes) {
    const auto plain = ellipsoid_inertia(shape, 1.0);
    const std::vector<std::array<int, 3>> orders = {{1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
    for (const auto& order : orders) {
      const auto renamed = ellipsoid_inertia(shape(order), 1.0);
      EXPECT_LT(relative_difference(renamed.added_mass, plain.added_mass(order)), tests::tolerance(2e-15));
      EXPECT_LT(relative_difference(renamed.added_inertia, plain.added_inertia(order)), tests::tolerance(2e-15));
      EXPECT_LT(relative_difference(renamed.body_inertia, plain.body_inertia(order)), tests::tolerance(2e-15));
    }
  }
}

TEST(Ellipsoid, moving_along_a_longer_axis_drags_less_fluid) {
  const auto inertia = ellipsoid_inertia({3.0, 2.0, 1.0}, 1.0);
  EXPECT_LT(inertia.added_mass[0], inertia.added_mass[1]);
  EXPECT_LT(inertia.added_mass[1], inertia.added_mass[2]);
}

TEST(Ellipsoid, a_spheroid_adds_no_inertia_about_its_axis) {
  for (const double axis : {1e-3, 0.5, 2.0, 1e4}) {
    EXPECT_EQ(ellipsoid_inertia({axis, 1.0, 1.0}, 1.0).added_inertia[0], 0.0);
    EXPECT_EQ(ellipsoid_inertia({1.0, axis, 1.0}, 1.0).added_inertia[1], 0.0);
    EXPECT_EQ(ellipsoid_inertia({1.0, 1.0, axis}, 1.0).added_inertia[2], 0.0);
  }
}

TEST(Ellipsoid, added_inertia_vanishes_with_the_square_of_the_axes_difference) {
  const double limit = ellipsoid_inertia({2.0, 1.0 + 1e-7, 1.0}, 1.0).added_inertia[0] / 1e-14;
  for (const double gap : {1e-3, 1e-4, 1e-5, 1e-6}) {
    const double exact_gap = (1.0 + gap) - 1.0;
    const double ratio =
        ellipsoid_inertia({2.0, 1.0 + gap, 1.0}, 1.0).added_inertia[0] / (exact_gap * exact_gap * limit);
    EXPECT_NEAR(ratio, 1.0, tests::tolerance(4.0 * gap));
    EXPECT_NE(ratio, 1.0);
  }
}

TEST(Ellipsoid, a_thin_disc_approaches_the_known_limits_at_first_order_in_its_thickness) {
  const double broadside = 8.0 / 3.0;
  const double about_a_diameter = 16.0 / 45.0;
  double previous_mass_error = 0.0;
  double previous_inertia_error = 0.0;
  for (const double thickness : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const auto disc = ellipsoid_inertia({1.0, 1.0, thickness}, 1.0);
    const double mass_error = std::abs(disc.added_mass[2] / broadside - 1.0);
    const double inertia_error = std::abs(disc.added_inertia[0] / about_a_diameter - 1.0);
    EXPECT_LT(mass_error, 2.0 * thickness);
    EXPECT_LT(inertia_error, 2.0 * thickness);
    if (previous_mass_error > 0.0) {
      EXPECT_NEAR(std::log10(previous_mass_error / mass_error), 1.0, 0.05);
      EXPECT_NEAR(std::log10(previous_inertia_error / inertia_error), 1.0, 0.05);
    }
    previous_mass_error = mass_error;
    previous_inertia_error = inertia_error;
  }
}

TEST(Ellipsoid, a_long_needle_moves_sideways_like_a_cylinder) {
  const auto needle = ellipsoid_inertia({1e5, 1.0, 2.0}, 1.0);
  EXPECT_NEAR(needle.added_mass[1] / needle.mass, 2.0, 1e-8);
  EXPECT_NEAR(needle.added_mass[2] / needle.mass, 0.5, 1e-8);
  EXPECT_LT(needle.added_mass[0] / needle.mass, 1e-8);
}

// Closed forms of a spheroid with axis ratio r > 1 along x, e its eccentricity (Lamb, §114).
TEST(Ellipsoid, prolate_spheroids_agree_with_elementary_functions) {
  for (const double r : {1.5, 2.0, 10.0, 50.0}) {
    const double e = std::sqrt((r - 1.0) * (r + 1.0)) / r;
    const double cube = std::pow(r * e, 3) / r;  // e³/(1−e²)
    const double alpha = 2.0 * (std::acosh(r) - e) / cube;
    const double beta = 1.0 / (e * e) - std::acosh(r) / cube;
    const auto spheroid = ellipsoid_inertia({r, 1.0, 1.0}, 1.0);
    const double difference = r * r - 1.0;
    const double sum = r * r + 1.0;
    const double inertia = 0.2 * difference * difference * (beta - alpha) / (2.0 * difference + sum * (alpha - beta));
    EXPECT_NEAR(spheroid.added_mass[0] / spheroid.mass * (2.0 - alpha) / alpha, 1.0, tests::tolerance(1e-13));
    EXPECT_NEAR(spheroid.added_mass[1] / spheroid.mass * (2.0 - beta) / beta, 1.0, tests::tolerance(1e-13));
    EXPECT_NEAR(spheroid.added_inertia[1] / spheroid.mass / inertia, 1.0, tests::tolerance(1e-13));
  }
}

TEST(Ellipsoid, a_vacuum_has_no_inertia_and_keeps_the_volume) {
  const auto inertia = ellipsoid_inertia({1.0, 2.0, 3.0}, 0.0);
  EXPECT_DOUBLE_EQ(inertia.volume, 8.0 * pi);
  EXPECT_EQ(inertia.mass, 0.0);
  EXPECT_EQ(inertia.added_mass, Vector3d::Zero());
  EXPECT_EQ(inertia.added_inertia, Vector3d::Zero());
}

TEST(Ellipsoid, impossible_shapes_and_densities_are_refused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {0.0, -1.0, nan, infinity}) {
    EXPECT_THROW(ellipsoid_inertia({1.0, wrong, 1.0}, 1.0), std::invalid_argument) << wrong;
  }
  EXPECT_THROW(ellipsoid_inertia({1.0, 1.0, 1e-60}, 1.0), std::invalid_argument);
  EXPECT_TRUE(ellipsoid_inertia({1.0, 1e-49, 1e-49}, 1.0).added_inertia.allFinite());
  EXPECT_NEAR(ellipsoid_inertia({1.0, 1.0, 1e-49}, 1.0).added_mass[2], 8.0 / 3.0, tests::tolerance(1e-14));
  for (const double wrong : {-1.0, nan, infinity}) {
    EXPECT_THROW(ellipsoid_inertia({1.0, 1.0, 1.0}, wrong), std::invalid_argument) << wrong;
  }
}

}  // namespace lamprey::fluid
