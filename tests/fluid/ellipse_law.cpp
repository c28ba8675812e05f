// Ellipses in the plane: limits of long ellipsoids, and what symmetry and units say.
#include "fluid/ellipse.hpp"

#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

}  // namespace

TEST(Ellipse, is_the_limit_of_ellipsoids_that_grow_out_of_the_plane) {
  for (const Vector2d& axes : {Vector2d(2.0, 1.0), Vector2d(0.1, 0.01), Vector2d(3.0, 5.0)}) {
    const EllipsoidInertia flat = ellipse_inertia(axes, 7.0);
    double before = 1.0;
    for (const double aspect : {1e2, 1e3, 1e4}) {
      const double c = aspect * axes.maxCoeff();
      const EllipsoidInertia deep = ellipsoid_inertia({axes[0], axes[1], c}, 7.0);
      const double length = 4.0 / 3.0 * c, thinning = 16.0 / 15.0 * c;
      double off = std::abs(deep.mass / length / flat.mass - 1.0);
      EXPECT_LE(off, tests::tolerance(1e-14));
      for (int axis = 0; axis < 2; ++axis)
        off = std::max(off, std::abs(deep.added_mass[axis] / length / flat.added_mass[axis] - 1.0));
      off = std::max(off, std::abs(deep.added_inertia[2] / thinning / flat.added_inertia[2] - 1.0));
      EXPECT_LT(off, before / 30.0) << "second order in 1/c, but for a logarithm";
      before = off;
    }
    EXPECT_LT(before, 1e-6);
  }
}

TEST(Ellipse, of_a_circle_turns_freely_and_drags_its_own_mass_along) {
  const EllipsoidInertia circle = ellipse_inertia({0.3, 0.3}, 1000.0);
  EXPECT_NEAR(circle.mass, 1000.0 * pi * 0.09, 1e-12);
  EXPECT_EQ(circle.added_mass[0], circle.added_mass[1]);
  EXPECT_NEAR(circle.added_mass[0] / circle.mass, 1.0, tests::tolerance(1e-15));
  EXPECT_EQ(circle.added_inertia, Vector3d::Zero());
  EXPECT_NEAR(circle.body_inertia[2], 0.5 * circle.mass * 0.09, tests::tolerance(1e-15) * circle.mass);
}

TEST(Ellipse, renaming_the_axes_renames_the_entries_and_size_counts_by_its_powers) {
  const EllipsoidInertia one = ellipse_inertia({2.0, 0.7}, 3.0), other = ellipse_inertia({0.7, 2.0}, 3.0);
  EXPECT_EQ(one.added_mass[0], other.added_mass[1]);
  EXPECT_EQ(one.added_inertia[2], other.added_inertia[2]);
  EXPECT_EQ(one.body_inertia[0], other.body_inertia[1]);
  const EllipsoidInertia twice = ellipse_inertia({4.0, 1.4}, 3.0);
  EXPECT_NEAR(twice.mass / one.mass, 4.0, tests::tolerance(1e-15) * 4.0);
  EXPECT_NEAR(twice.added_inertia[2] / one.added_inertia[2], 16.0, tests::tolerance(1e-15) * 16.0);
  EXPECT_NEAR(twice.body_inertia[2] / one.body_inertia[2], 16.0, tests::tolerance(1e-15) * 16.0);
}

TEST(Ellipse, impossible_shapes_and_densities_are_refused) {
  EXPECT_THROW(ellipse_inertia({1.0, 0.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(ellipse_inertia({-1.0, 1.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(ellipse_inertia({1.0, 1.0}, -1.0), std::invalid_argument);
  EXPECT_NO_THROW(ellipse_inertia({1.0, 1.0}, 0.0));
}

}  // namespace lamprey::fluid
