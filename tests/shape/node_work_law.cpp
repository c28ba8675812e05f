// Work of a moment about a node whose power goes linearly: the mean of |p|, its slopes, and the smooth terms that have it for a
// fixed point.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "shape/node_work.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using shape::mean_work;
using shape::work_term;
using shape::WorkSlopes;
using shape::WorkTerm;

// Mean of |p| from mean − change to mean + change, in so many parts that only the one with the change of sign is not exact.
double mean_by_parts(const Vector2d& power) {
  constexpr int parts = 20000;
  double sum = 0.0;
  for (int n = 0; n < parts; ++n) sum += std::abs(power[0] + power[1] * ((2.0 * n + 1.0) / parts - 1.0)) / parts;
  return sum;
}

Vector2d drawn(Random& random) { return {random.normal(), random.normal()}; }

double room(const WorkSlopes& slopes) { return 0.5 * (1.0 - slopes[0] * slopes[0]) - std::abs(slopes[1]); }

TEST(NodeWork, is_the_mean_of_the_powers_absolute_value) {
  Random random(1);
  for (int n = 0; n < 20; ++n) {
    const Vector2d power = drawn(random);
    EXPECT_NEAR(mean_work(power), mean_by_parts(power), tolerance(1e-8) * power.norm());
  }
  EXPECT_EQ(mean_work({0.0, 0.0}), 0.0);
  EXPECT_EQ(mean_work({0.0, 2.0}), 1.0) << "of a joint that turns back, half of what it was before and after";
}

TEST(NodeWork, is_what_the_slopes_that_it_can_have_make_of_a_power_at_most) {
  Random random(2);
  for (int n = 0; n < 200; ++n) {
    const Vector2d power = drawn(random), slopes = work_term(power, WorkSlopes::Zero(), 0.0).slope;
    EXPECT_NEAR(slopes.dot(power), mean_work(power), tolerance(1e-14) * power.norm());
    EXPECT_GE(room(slopes), -tolerance(1e-15));
    const double S = random.uniform(-1.0, 1.0), D = random.uniform(-1.0, 1.0) * 0.5 * (1.0 - S * S);
    EXPECT_LE(Vector2d(S, D).dot(power), mean_work(power));
  }
}

TEST(NodeWork, has_the_slopes_and_curvatures_of_its_value) {
  Random random(3);
  int inside = 0, on_edge = 0, at_end = 0;
  for (int n = 0; n < 400; ++n) {
    const Vector2d power = drawn(random);
    const double S = random.uniform(-1.0, 1.0);
    const WorkSlopes multiplier(S, random.uniform(-0.5, 0.5) * (1.0 - S * S));
    for (const double weight : {0.0, 0.2, 1.0, 30.0}) {
      const WorkTerm term = work_term(power, multiplier, weight);
      EXPECT_GE(room(term.slope), -tolerance(1e-14));
      if (weight > 0.0) ++(room(term.slope) > 1e-9 ? inside : std::abs(term.slope[0]) < 1.0 - 1e-9 ? on_edge : at_end);
      // short of where one kind of slopes ends and another begins
      const double step = 1e-6, far = 100.0 * step;
      bool smooth = true;
      for (const Vector2d& way : {Vector2d(far, 0.0), Vector2d(0.0, far), Vector2d(-far, 0.0), Vector2d(0.0, -far)})
        smooth = smooth && (work_term(power + way, multiplier, weight).curvature - term.curvature).norm() <=
                               0.01 * term.curvature.norm();
      if (!smooth) continue;
      for (int a = 0; a < 2; ++a) {
        const WorkTerm up = work_term(power + step * Vector2d::Unit(a), multiplier, weight);
        const WorkTerm down = work_term(power - step * Vector2d::Unit(a), multiplier, weight);
        EXPECT_NEAR((up.value - down.value) / (2.0 * step), term.slope[a], tolerance(1e-8));
        EXPECT_LE(((up.slope - down.slope) / (2.0 * step) - term.curvature.col(a)).norm(),
                  tolerance(1e-6) * (1.0 + weight));
      }
    }
  }
  EXPECT_GT(std::min({inside, on_edge, at_end}), 100);
}

// Multipliers renewed at a power go to the slopes of the work there, whose term is the work itself; at rest they stay.
TEST(NodeWork, is_its_own_term_where_multipliers_stay) {
  Random random(4);
  for (int n = 0; n < 50; ++n) {
    const Vector2d power = drawn(random);
    WorkSlopes multiplier(0.1, -0.2);
    EXPECT_EQ(work_term(Vector2d::Zero(), multiplier, 1.0).slope, multiplier);
    for (int times = 0; times < 2000; ++times) multiplier = work_term(power, multiplier, 10.0).slope;
    const WorkTerm term = work_term(power, multiplier, 10.0);
    EXPECT_NEAR(term.value, mean_work(power), tolerance(1e-12) * power.norm());
    EXPECT_LE((multiplier - work_term(power, multiplier, 0.0).slope).norm(), tolerance(1e-9));
  }
}

TEST(NodeWork, is_convex_and_no_more_than_the_work_with_any_multipliers) {
  Random random(5);
  for (int n = 0; n < 200; ++n) {
    const Vector2d left = drawn(random), right = drawn(random);
    const double S = random.uniform(-1.0, 1.0), weight = std::exp(random.normal());
    const WorkSlopes multiplier(S, random.uniform(-0.5, 0.5) * (1.0 - S * S));
    const auto value = [&](const Vector2d& power) { return work_term(power, multiplier, weight).value; };
    EXPECT_LE(value(0.5 * (left + right)), 0.5 * (value(left) + value(right)) + tolerance(1e-14));
    EXPECT_LE(value(left), mean_work(left) + tolerance(1e-14));
  }
}

}  // namespace
}  // namespace lamprey::tests
