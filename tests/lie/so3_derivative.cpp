#include "lie/so3.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "lie/series.hpp"
#include "tolerance.hpp"

namespace lamprey::lie {

namespace {

using std::numbers::pi;
using tests::tolerance;
using tests::vectors_of_length;

using Curve = std::function<Matrix3(double)>;

// Body-side angular velocity of a curve of rotations at 0 by central differences.
Vector3 body_velocity(const Curve& R, double step) {
  return vee(R(0.0).transpose() * (R(step) - R(-step))) / (2.0 * step);
}

// The claim against differences over four halved steps: the error falls as the step's square and is never nothing.
void expect_second_order(const Curve& R, const Vector3& claimed, double first_step) {
  ASSERT_GT(claimed.norm(), 1e-6);
  double previous = 0.0;
  for (int n = 0; n < 4; ++n) {
    const double error = (body_velocity(R, std::ldexp(first_step, -n)) - claimed).norm();
    EXPECT_GT(error, 0.0);
    if (n > 0) {
      EXPECT_NEAR(std::log2(previous / error), 2.0, 0.1);
    }
    previous = error;
  }
  EXPECT_LT(previous / claimed.norm(), 1e-3);
}

const Vector3 direction(0.48, -0.64, 0.6);

}  // namespace

TEST(ExpTangent, matches_central_differences_of_the_power_series_at_second_order) {
  for (const Vector3& v : vectors_of_length({1e-12, 1e-3, 0.4, 0.6, 2.0, pi - 1e-3, 5.0})) {
    const Curve series = [&](double t) {
      return Matrix3(tests::exponential_series(tests::long_hat(v + t * direction)).cast<double>());
    };
    expect_second_order(series, exp_tangent(v) * direction, 0.04);
  }
}

TEST(ExpTangent, equals_its_power_series_on_both_sides_of_each_branch) {
  for (const Vector3& v :
       vectors_of_length({1e-100, 1e-12, 0.99e-4, 1.01e-4, 1e-2, 0.499999, 0.500001, 1.0, pi, 6.0})) {
    EXPECT_LT((exp_tangent(v) - tests::tangent_series(v).cast<double>()).cwiseAbs().maxCoeff(), tolerance(1e-15))
        << v.transpose();
  }
}

TEST(ExpTangent, differs_from_the_identity_by_minus_half_the_hat_near_zero) {
  const Vector3 v = 1e-5 * direction;
  EXPECT_LT(((Matrix3::Identity() - exp_tangent(v)) / 1e-5 - 0.5 * hat(direction)).norm(), tolerance(1e-5));
}

TEST(ExpTangent, with_the_opposite_sign_is_seen_to_fail) {
  const Vector3 v(0.9, -0.2, 0.7);
  const Curve curve = [&](double t) { return exp(v + t * direction); };
  EXPECT_LT((body_velocity(curve, 1e-5) - exp_tangent(v) * direction).norm(), tolerance(1e-9));
  EXPECT_GT((body_velocity(curve, 1e-5) - exp_tangent(-v) * direction).norm(), 0.1);
}

TEST(CayleyTangent, matches_central_differences_at_second_order) {
  for (const Vector3& zeta : vectors_of_length({1e-12, 1e-3, 0.3, 1.0, 4.0})) {
    const Curve quotient = [&](double t) {
      const Vector3 z = zeta + t * direction;
      const Vector3 v = z.norm() > 0.0 ? Vector3(2.0 * std::atan(z.norm()) / z.norm() * z) : z;
      return Matrix3(tests::exponential_series(tests::long_hat(v)).cast<double>());
    };
    expect_second_order(quotient, cayley_tangent(zeta) * direction, 0.02);
  }
  EXPECT_EQ(cayley_tangent(Vector3::Zero()), 2.0 * Matrix3::Identity());
}

TEST(CayleyTangent, with_the_opposite_sign_is_seen_to_fail) {
  const Vector3 zeta(0.4, 0.3, -0.6);
  const Curve curve = [&](double t) { return cayley(zeta + t * direction); };
  EXPECT_LT((body_velocity(curve, 1e-5) - cayley_tangent(zeta) * direction).norm(), tolerance(1e-9));
  EXPECT_GT((body_velocity(curve, 1e-5) - cayley_tangent(-zeta) * direction).norm(), 0.1);
}

TEST(QuaternionTangent, matches_central_differences_at_second_order_for_any_length) {
  const Vector4 change(0.3, -0.5, 0.7, 0.4);
  for (const Vector3& v : vectors_of_length({1e-9, 0.5, 2.0, pi - 1e-9})) {
    for (const double length : {0.2, 1.0, 5.0}) {
      const Vector4 q = length * quaternion_of_rotation(exp(v));
      const Curve curve = [&](double t) { return rotation_of_quaternion(q + length * t * change); };
      expect_second_order(curve, quaternion_tangent(q) * (length * change), 0.02);
    }
  }
}

TEST(QuaternionTangent, sees_no_rotation_in_a_change_of_length) {
  const Vector4 q(0.3, -0.8, 1.1, 0.2);
  EXPECT_LT((quaternion_tangent(q) * q).norm(), tolerance(1e-15));
}

TEST(QuaternionTangent, of_the_vector_part_at_the_identity_is_twice_the_identity) {
  const Eigen::Matrix<double, 3, 4> T = quaternion_tangent(Vector4(1, 0, 0, 0));
  EXPECT_EQ(T.rightCols<3>(), 2.0 * Matrix3::Identity());
  EXPECT_EQ(T.col(0), Vector3::Zero());
}

TEST(QuaternionProduct, agrees_with_the_tangent_to_first_order) {
  const Vector4 q = quaternion_of_rotation(exp(Vector3(0.7, -1.1, 0.4)));
  for (int i = 0; i < 3; ++i) {
    Vector4 half_turn = Vector4::Zero();
    half_turn[1 + i] = 0.5;
    EXPECT_LT((quaternion_tangent(q) * quaternion_product(q, half_turn) - Vector3::Unit(i)).norm(), tolerance(1e-15));
  }
}

}  // namespace lamprey::lie
