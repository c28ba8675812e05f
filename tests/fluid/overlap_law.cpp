#include "fluid/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "lie/so3.hpp"
#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Draw {
 public:
  explicit Draw(unsigned seed) : generator_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }
  Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  PlacedEllipsoid ellipsoid() {
    const Vector3d axes(uniform(0.3, 3.0), uniform(0.3, 3.0), uniform(0.3, 3.0));
    return {axes, lie::exp(vector(3.0)), vector(4.0)};
  }

 private:
  std::mt19937_64 generator_;
};

// Value of (x − c)ᵀA⁻¹(x − c): below 1 inside the body.
double level(const PlacedEllipsoid& body, const Vector3d& point) {
  return (body.rotation.transpose() * (point - body.centre)).cwiseQuotient(body.semi_axes).squaredNorm();
}

Vector3d outward(const PlacedEllipsoid& body, const Vector3d& point) {
  const Vector3d local = body.rotation.transpose() * (point - body.centre);
  return body.rotation * local.cwiseQuotient(body.semi_axes.cwiseAbs2());
}

PlacedEllipsoid moved(const PlacedEllipsoid& body, const Matrix3d& Q, const Vector3d& shift) {
  return {body.semi_axes, Q * body.rotation, Q * body.centre + shift};
}

}  // namespace

TEST(Contact, of_two_spheres_compares_their_distance_with_the_sum_of_radii) {
  Draw draw(1);
  for (int n = 0; n < 100; ++n) {
    const double first = draw.uniform(0.01, 3.0);
    const double second = draw.uniform(0.01, 3.0);
    const PlacedEllipsoid a{Vector3d::Constant(first), lie::exp(draw.vector(3.0)), draw.vector(4.0)};
    const PlacedEllipsoid b{Vector3d::Constant(second), lie::exp(draw.vector(3.0)), draw.vector(4.0)};
    const double distance = (b.centre - a.centre).norm();
    const Contact result = contact(a, b);
    EXPECT_NEAR(result.value / std::pow(distance / (first + second), 2), 1.0, tests::tolerance(1e-12));
    EXPECT_NEAR(result.centre_line_gap, distance - first - second, tests::tolerance(1e-11));
    EXPECT_NEAR(result.fraction, first / (first + second), tests::tolerance(1e-9));
  }
}

TEST(Contact, is_the_same_after_exchange_of_the_bodies) {
  Draw draw(2);
  for (int n = 0; n < 200; ++n) {
    const PlacedEllipsoid a = draw.ellipsoid();
    const PlacedEllipsoid b = draw.ellipsoid();
    const Contact forth = contact(a, b);
    const Contact back = contact(b, a);
    EXPECT_NEAR(forth.value / back.value, 1.0, tests::tolerance(1e-12));
    EXPECT_NEAR(forth.fraction + back.fraction, 1.0, tests::tolerance(1e-9));
    EXPECT_LT((forth.normal + back.normal).norm() / forth.normal.norm(), tests::tolerance(1e-8));
    EXPECT_LT((forth.point - back.point).norm(), tests::tolerance(1e-8));
  }
}

TEST(Contact, does_not_change_when_both_bodies_move_rigidly_or_the_unit_of_length_changes) {
  Draw draw(3);
  for (int n = 0; n < 200; ++n) {
    const PlacedEllipsoid a = draw.ellipsoid();
    const PlacedEllipsoid b = draw.ellipsoid();
    const double value = contact(a, b).value;
    const Matrix3d Q = lie::exp(draw.vector(3.0));
    const Vector3d shift = draw.vector(100.0);
    EXPECT_NEAR(contact(moved(a, Q, shift), moved(b, Q, shift)).value / value, 1.0, tests::tolerance(1e-11));
    for (const double unit : {1e-3, 1e6}) {
      const PlacedEllipsoid a_scaled{unit * a.semi_axes, a.rotation, unit * a.centre};
      const PlacedEllipsoid b_scaled{unit * b.semi_axes, b.rotation, unit * b.centre};
      EXPECT_NEAR(contact(a_scaled, b_scaled).value / value, 1.0, tests::tolerance(1e-12));
    }
  }
}

// Whatever λ the search ends at, these two facts single out the touching of the grown bodies.
TEST(Contact, bodies_grown_by_the_contact_function_touch_in_one_point_with_opposite_normals) {
  Draw draw(4);
  int apart = 0;
  for (int n = 0; n < 300; ++n) {
    const PlacedEllipsoid a = draw.ellipsoid();
    const PlacedEllipsoid b = draw.ellipsoid();
    const Contact result = contact(a, b);
    EXPECT_NEAR(level(a, result.point) / result.value, 1.0, tests::tolerance(1e-8));
    EXPECT_NEAR(level(b, result.point) / result.value, 1.0, tests::tolerance(1e-8));
    const Vector3d n_a = outward(a, result.point).normalized();
    const Vector3d n_b = outward(b, result.point).normalized();
    EXPECT_LT((n_a + n_b).norm(), tests::tolerance(1e-8));
    EXPECT_GT(n_a.dot(result.normal), 0.0);
    apart += result.value > 1.0;
  }
  EXPECT_GT(apart, 50);
  EXPECT_LT(apart, 250);
}

// Independent road: points of one surface tested against the other body.
TEST(Contact, a_point_in_both_bodies_is_found_exactly_when_the_value_is_below_one) {
  Draw draw(5);
  int overlapping = 0;
  for (int n = 0; n < 100; ++n) {
    const PlacedEllipsoid a = draw.ellipsoid();
    const PlacedEllipsoid b = draw.ellipsoid();
    const double value = contact(a, b).value;
    double least = level(b, a.centre);
    for (int i = 0; i < 80; ++i) {
      for (int k = 0; k < 160; ++k) {
        const double polar = std::numbers::pi * (i + 0.5) / 80.0;
        const double azimuth = 2.0 * std::numbers::pi * k / 160.0;
        const Vector3d direction(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                 std::cos(polar));
        const Vector3d surface = a.centre + a.rotation * a.semi_axes.cwiseProduct(direction);
        least = std::min(least, level(b, surface));
      }
    }
    if (least < 1.0) {
      EXPECT_LT(value, 1.0);
      ++overlapping;
    } else if (least > 1.1 && level(a, b.centre) > 1.0) {
      EXPECT_GT(value, 1.0);
    }
  }
  EXPECT_GT(overlapping, 20);
}

TEST(Contact, the_centre_line_gap_is_where_a_shifted_body_touches) {
  Draw draw(6);
  for (int n = 0; n < 100; ++n) {
    const PlacedEllipsoid a = draw.ellipsoid();
    PlacedEllipsoid b = draw.ellipsoid();
    const Contact before = contact(a, b);
    b.centre -= before.centre_line_gap * (b.centre - a.centre).normalized();
    EXPECT_NEAR(contact(a, b).value, 1.0, tests::tolerance(1e-12));
  }
}

TEST(Contact, of_the_straight_chain_of_the_paper_leaves_gaps_of_1_30_m_and_equal_centres_overlap_fully) {
  const PlacedEllipsoid middle{{8.0, 1.5, 2.0}, Matrix3d::Identity(), Vector3d::Zero()};
  const PlacedEllipsoid front{{5.0, 0.8, 1.5}, Matrix3d::Identity(), {14.3, 0.0, 0.0}};
  EXPECT_NEAR(contact(middle, front).value, std::pow(14.3 / 13.0, 2), tests::tolerance(1e-13));
  EXPECT_NEAR(contact(middle, front).centre_line_gap, 1.3, tests::tolerance(1e-12));
  EXPECT_NEAR(contact(middle, front).fraction, 8.0 / 13.0, tests::tolerance(1e-9));
  EXPECT_EQ(contact(middle, middle).value, 0.0);
  EXPECT_LT(contact(middle, middle).centre_line_gap, 0.0);
}

}  // namespace lamprey::fluid
