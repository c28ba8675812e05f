#include "fluid/overlap.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "lie/so3.hpp"
#include "tolerance.hpp"

namespace lamprey::fluid {

TEST(ContactDerivative, with_respect_to_the_centre_matches_central_differences_at_second_order) {
  using Eigen::Vector3d;
  const PlacedEllipsoid a{{2.0, 0.7, 1.1}, lie::exp(Vector3d(0.3, -0.8, 1.2)), {0.1, 0.2, -0.3}};
  const PlacedEllipsoid b{{0.5, 1.9, 0.8}, lie::exp(Vector3d(-1.0, 0.4, 0.6)), {1.5, -1.1, 0.9}};
  const Contact here = contact(a, b);
  const Vector3d gradient = 2.0 * here.fraction * (1.0 - here.fraction) * here.normal;
  ASSERT_GT(gradient.cwiseAbs().minCoeff(), 1e-3);
  double previous = 0.0;
  for (const double step : {4e-2, 2e-2, 1e-2, 5e-3}) {
    Vector3d difference;
    for (int i = 0; i < 3; ++i) {
      PlacedEllipsoid ahead = b;
      PlacedEllipsoid behind = b;
      ahead.centre[i] += step;
      behind.centre[i] -= step;
      difference[i] = (contact(a, ahead).value - contact(a, behind).value) / (2.0 * step);
    }
    const double error = (difference - gradient).norm();
    EXPECT_GT(error, 0.0);
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), 2.0, 0.1);
    }
    previous = error;
  }
  EXPECT_LT(previous / gradient.norm(), tests::tolerance(1e-4));
}

}  // namespace lamprey::fluid
