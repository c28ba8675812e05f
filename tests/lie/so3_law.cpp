#include "lie/so3.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "lie/series.hpp"
#include "tolerance.hpp"

namespace lamprey::lie {

namespace {

using std::numbers::pi;
using tests::tolerance;
using tests::vectors_of_length;

const std::vector<double> all_scales = {1e-100, 1e-12, 1e-9, 1e-6, 0.99e-4, 1.01e-4,   1e-3,      0.1,       0.5,
                                        1.0,    2.0,   2.09, 2.1,  3.0,     pi - 1e-4, pi - 1e-7, pi - 1e-10};

double largest(const Matrix3& m) { return m.cwiseAbs().maxCoeff(); }
double orthogonality(const Matrix3& R) { return largest(R.transpose() * R - Matrix3::Identity()); }
Vector3 series_rotation_vector_part(const Vector3& v) {
  const tests::LongMatrix3 R = tests::exponential_series(tests::long_hat(v));
  return Vector3(static_cast<double>(R(2, 1) - R(1, 2)), static_cast<double>(R(0, 2) - R(2, 0)),
                 static_cast<double>(R(1, 0) - R(0, 1))) /
         2.0;
}

}  // namespace

TEST(Hat, is_the_cross_product_and_vee_takes_it_back) {
  const Vector3 v(0.3, -1.7, 2.2);
  const Vector3 w(-0.4, 0.9, 1.1);
  EXPECT_LT((hat(v) * w - v.cross(w)).norm(), tolerance(1e-15));
  EXPECT_EQ(vee(hat(v)), v);
  EXPECT_EQ(hat(v).transpose(), -hat(v));
  Matrix3 symmetric;
  symmetric << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  EXPECT_LT((vee(hat(v) + symmetric) - v).norm(), tolerance(1e-15));
}

TEST(Exponential, equals_the_power_series_at_every_scale) {
  for (const Vector3& v : vectors_of_length(all_scales)) {
    const Matrix3 series = tests::exponential_series(tests::long_hat(v)).cast<double>();
    EXPECT_LT(largest(exp(v) - series), tolerance(2e-15)) << v.transpose();
  }
}

TEST(Exponential, keeps_the_relative_accuracy_of_small_rotations) {
  for (const Vector3& v : vectors_of_length({1e-100, 1e-12, 1e-6, 1e-4, 1e-2})) {
    EXPECT_LT((vee(exp(v)) - series_rotation_vector_part(v)).norm() / v.norm(), tolerance(1e-15)) << v.transpose();
  }
}

TEST(Exponential, of_a_quarter_turn_about_e3_takes_e1_to_e2) {
  EXPECT_LT((exp({0.0, 0.0, pi / 2.0}) * Vector3::UnitX() - Vector3::UnitY()).norm(), tolerance(1e-15));
}

TEST(Exponential, is_a_rotation_and_keeps_its_axis) {
  for (const Vector3& v : vectors_of_length(all_scales)) {
    EXPECT_LT(orthogonality(exp(v)), tolerance(4e-15));
    EXPECT_NEAR(exp(v).determinant(), 1.0, tolerance(2e-15));
    EXPECT_LT((exp(v) * v - v).norm() / v.norm(), tolerance(1e-15));
  }
}

TEST(Logarithm, undoes_the_exponential_with_full_relative_accuracy_up_to_the_half_turn) {
  for (const Vector3& v : vectors_of_length(all_scales)) {
    EXPECT_LT((log(exp(v)) - v).norm() / v.norm(), tolerance(2e-15)) << v.transpose();
  }
}

TEST(Logarithm, undoes_the_power_series) {
  for (const Vector3& v : vectors_of_length(all_scales)) {
    const Matrix3 series = tests::exponential_series(tests::long_hat(v)).cast<double>();
    EXPECT_LT((log(series) - v).norm() / v.norm(), tolerance(2e-15)) << v.transpose();
  }
}

TEST(Logarithm, of_a_turn_beyond_half_is_the_shorter_way_back) {
  for (const Vector3& v : vectors_of_length({pi + 1e-7, pi + 1e-3, 4.0, 6.0, 2.0 * pi - 1e-6})) {
    const Vector3 shorter = (1.0 - 2.0 * pi / v.norm()) * v;
    EXPECT_LT((log(exp(v)) - shorter).norm(), tolerance(4e-15)) << v.transpose();
  }
}

TEST(Logarithm, of_a_half_turn_is_one_of_the_two_vectors) {
  for (const Vector3& v : vectors_of_length({pi})) {
    const Vector3 result = log(exp(v));
    EXPECT_NEAR(result.norm(), pi, tolerance(2e-15));
    EXPECT_LT(std::min((result - v).norm(), (result + v).norm()), tolerance(4e-15)) << v.transpose();
  }
  EXPECT_EQ(log(Vector3(-1.0, -1.0, 1.0).asDiagonal()).cwiseAbs(), Vector3(0.0, 0.0, pi));
}

TEST(Logarithm, of_the_identity_is_zero) { EXPECT_EQ(log(Matrix3::Identity()), Vector3::Zero()); }

TEST(Cayley, turns_by_twice_the_angle_whose_tangent_is_the_vectors_length) {
  for (const Vector3& zeta : vectors_of_length({1e-100, 1e-12, 1e-6, 1e-3, 0.3, 1.0, 5.0, 1e3, 1e8})) {
    const Vector3 v = 2.0 * std::atan(zeta.norm()) / zeta.norm() * zeta;
    const Matrix3 series = tests::exponential_series(tests::long_hat(v)).cast<double>();
    EXPECT_LT(largest(cayley(zeta) - series), tolerance(2e-15)) << zeta.transpose();
  }
}

TEST(Cayley, is_the_quotient_of_identity_plus_and_minus_hat) {
  for (const Vector3& zeta : vectors_of_length({1e-3, 0.3, 1.0, 5.0})) {
    const Matrix3 quotient = (Matrix3::Identity() + hat(zeta)) * (Matrix3::Identity() - hat(zeta)).inverse();
    EXPECT_LT(largest(cayley(zeta) - quotient), tolerance(1e-14)) << zeta.transpose();
  }
}

TEST(Cayley, minus_identity_loses_no_digit_of_small_rotations) {
  for (const Vector3& zeta : vectors_of_length({1e-100, 1e-12, 1e-8, 1e-4, 0.1, 3.0})) {
    const long double length = zeta.cast<long double>().norm();
    const long double scale = 2.0L * std::atan(length) / length;
    const Matrix3 series = tests::exponential_series(scale * tests::long_hat(zeta), 1).cast<double>();
    EXPECT_LT(largest(cayley_minus_identity(zeta) - series) / largest(series), tolerance(1e-15)) << zeta.transpose();
  }
}

TEST(Cayley, vector_is_recovered_from_the_rotation) {
  for (const Vector3& zeta : vectors_of_length({1e-100, 1e-12, 1e-6, 1e-3, 0.3, 1.0, 5.0, 1e3})) {
    const double conditioning = 1.0 + zeta.norm();  // the half turn lies at infinity
    EXPECT_LT((inverse_cayley(cayley(zeta)) - zeta).norm() / zeta.norm(), tolerance(4e-15 * conditioning))
        << zeta.transpose();
  }
}

TEST(Quaternion, of_a_rotation_is_cosine_and_sine_of_half_the_angle_with_scalar_part_not_negative) {
  for (const Vector3& v : vectors_of_length(all_scales)) {
    const Vector4 q = quaternion_of_rotation(exp(v));
    EXPECT_NEAR(q[0], std::cos(0.5 * v.norm()), tolerance(1e-15));
    EXPECT_LT((q.tail<3>() - std::sin(0.5 * v.norm()) * v.normalized()).norm() / q.tail<3>().norm(), tolerance(2e-15));
    EXPECT_GE(q[0], 0.0);
    EXPECT_NEAR(q.norm(), 1.0, tolerance(1e-15));
  }
  for (const Vector3& v : vectors_of_length({4.0, 6.0})) EXPECT_GE(quaternion_of_rotation(exp(v))[0], 0.0);
}

TEST(Quaternion, of_any_length_and_sign_gives_the_same_rotation) {
  for (const Vector3& v : vectors_of_length({1e-12, 0.3, 2.0, pi - 1e-10})) {
    const Vector4 q = quaternion_of_rotation(exp(v));
    for (const double factor : {1.0, -1.0, 1e-3, -7.0, 1e100}) {
      EXPECT_LT(largest(rotation_of_quaternion(factor * q) - exp(v)), tolerance(2e-15));
    }
    EXPECT_LT(orthogonality(rotation_of_quaternion(Vector4(0.1, -3.0, 2.0, 0.7) + q)), tolerance(2e-15));
  }
}

TEST(Quaternion, product_stands_for_the_product_of_rotations) {
  const auto vectors = vectors_of_length({1e-6, 0.4, 2.5});
  for (std::size_t n = 1; n < vectors.size(); ++n) {
    const Vector4 a = quaternion_of_rotation(exp(vectors[n - 1]));
    const Vector4 b = 3.0 * quaternion_of_rotation(exp(vectors[n]));
    EXPECT_LT(largest(rotation_of_quaternion(quaternion_product(a, b)) - exp(vectors[n - 1]) * exp(vectors[n])),
              tolerance(3e-15));
    EXPECT_NEAR(quaternion_product(a, b).norm(), 3.0, tolerance(1e-14));
  }
  const Vector4 i(0, 1, 0, 0);
  const Vector4 j(0, 0, 1, 0);
  EXPECT_EQ(quaternion_product(i, j), Vector4(0, 0, 0, 1));
  EXPECT_EQ(quaternion_product(j, i), Vector4(0, 0, 0, -1));
}

TEST(RotationAngle, is_accurate_at_both_ends) {
  for (const Vector3& v : vectors_of_length(all_scales)) {
    EXPECT_NEAR(rotation_angle(exp(v)) / v.norm(), 1.0, tolerance(2e-15)) << v.transpose();
  }
  EXPECT_EQ(rotation_angle(Matrix3::Identity()), 0.0);
  EXPECT_EQ(rotation_angle(Vector3(-1.0, 1.0, -1.0).asDiagonal()), pi);
}

TEST(Renormalized, is_a_rotation_as_near_as_the_matrix_was_to_one) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  for (const double size : {1e-15, 1e-12, 1e-8}) {
    for (const Vector3& v : vectors_of_length({1e-9, 1.0, 2.1, pi - 1e-10})) {
      const Matrix3 disturbed = exp(v) + size * Matrix3::NullaryExpr([&] { return noise(generator); });
      const Matrix3 mended = renormalized(disturbed);
      EXPECT_LT(orthogonality(mended), tolerance(2e-15));
      EXPECT_NEAR(mended.determinant(), 1.0, tolerance(2e-15));
      EXPECT_LT(largest(mended - exp(v)), tolerance(4.0 * size + 1e-15));
    }
  }
}

TEST(ShorterWay, ends_where_the_angle_does_and_is_no_more_than_half_a_turn) {
  for (double angle = -20.0; angle <= 20.0; angle += 0.1) {
    const double way = shorter_way(angle);
    EXPECT_LE(std::abs(way), std::numbers::pi);
    EXPECT_NEAR(std::cos(way - angle), 1.0, 1e-14) << angle;
  }
}

}  // namespace lamprey::lie
