#include "maneuver/step_chart.hpp"

#include <cmath>

namespace lamprey::maneuver {

namespace {

using lie::hat;

// q ∘ p = left_product(q) p
Matrix4 left_product(const Vector4& q) {
  Matrix4 m;
  m(0, 0) = q[0];
  m.block<1, 3>(0, 1) = -q.tail<3>().transpose();
  m.block<3, 1>(1, 0) = q.tail<3>();
  m.block<3, 3>(1, 1) = q[0] * Matrix3::Identity() + hat(q.tail<3>());
  return m;
}

// q ∘ p = right_product(p) q
Matrix4 right_product(const Vector4& p) {
  Matrix4 m;
  m(0, 0) = p[0];
  m.block<1, 3>(0, 1) = -p.tail<3>().transpose();
  m.block<3, 1>(1, 0) = p.tail<3>();
  m.block<3, 3>(1, 1) = p[0] * Matrix3::Identity() - hat(p.tail<3>());
  return m;
}

Vector4 conjugate(const Vector4& q) { return {q[0], -q[1], -q[2], -q[3]}; }

Vector4 unscaled(const Vector3& zeta) { return Vector4(1.0, zeta[0], zeta[1], zeta[2]); }

}  // namespace

StepChart::StepChart(const Vector4& q, const Vector3& zeta, const Matrix3& F, double h)
    : left_by_quaternion(lie::quaternion_tangent(q)),
      right_by_quaternion(F.transpose() * left_by_quaternion),
      right_by_turn(0.5 * h * lie::cayley_tangent(zeta)) {}

ChartCurvature::ChartCurvature(const StepChart& chart, const Vector4& q, const Vector3& zeta, double h,
                               const Vector3& g, const Vector3& g_next) {
  // η = T δq − (q·δq/|q|²) T δq;  η_F = T' δω̃ (1 − ζ·δζ/(1 + ζ²));  η' = Fᵀη + η_F + ½ (Fᵀη) × η_F
  const Vector4 by_quaternion =
      chart.left_by_quaternion.transpose() * g + chart.right_by_quaternion.transpose() * g_next;
  quaternion_quaternion = -(q * by_quaternion.transpose() + by_quaternion * q.transpose()) / q.squaredNorm();
  quaternion_turn = -0.5 * chart.right_by_quaternion.transpose() * hat(g_next) * chart.right_by_turn;
  const Vector3 by_turn = chart.right_by_turn.transpose() * g_next;
  const Vector3 pull = 0.5 * h / (1.0 + zeta.squaredNorm()) * zeta;
  turn_turn = -(pull * by_turn.transpose() + by_turn * pull.transpose());
}

Matrix4 quaternion_curvature(const Vector4& q, const Vector3& g) {
  const Vector4 by_quaternion = lie::quaternion_tangent(q).transpose() * g;
  return -(q * by_quaternion.transpose() + by_quaternion * q.transpose()) / q.squaredNorm();
}

Vector4 advanced_quaternion(const Vector4& q, const Vector3& zeta) {
  return lie::quaternion_product(q, unscaled(zeta)) / std::sqrt(1.0 + zeta.squaredNorm());
}

Matrix4 advanced_quaternion_by_quaternion(const Vector3& zeta) {
  return right_product(unscaled(zeta)) / std::sqrt(1.0 + zeta.squaredNorm());
}

Matrix43 advanced_quaternion_by_cayley(const Vector4& q, const Vector3& zeta) {
  const double n = 1.0 / std::sqrt(1.0 + zeta.squaredNorm());
  const Vector4 product = lie::quaternion_product(q, unscaled(zeta));
  return n * left_product(q).rightCols<3>() - n * n * n * product * zeta.transpose();
}

AdvancedQuaternionCurvature::AdvancedQuaternionCurvature(const Vector4& multiplier, const Vector4& q,
                                                         const Vector3& zeta) {
  // multiplier · (n(ζ) q ∘ (1, ζ)) with n = (1 + ζ²)^(−1/2)
  const double n = 1.0 / std::sqrt(1.0 + zeta.squaredNorm());
  const double n3 = n * n * n;
  const Vector4 by_q = right_product(unscaled(zeta)).transpose() * multiplier;
  const Vector3 by_zeta = left_product(q).rightCols<3>().transpose() * multiplier;
  const double value = by_q.dot(q);
  Matrix43 mixed;  // derivative of by_q by ζ
  for (int c = 0; c < 3; ++c) mixed.col(c) = right_product(Vector4::Unit(c + 1)).transpose() * multiplier;
  quaternion_cayley = n * mixed - n3 * by_q * zeta.transpose();
  cayley_cayley = -n3 * (zeta * by_zeta.transpose() + by_zeta * zeta.transpose()) +
                  value * (3.0 * n3 * n * n * zeta * zeta.transpose() - n3 * Matrix3::Identity());
}

Vector4 shape_difference(const Vector4& first, const Vector4& first_root, const Vector4& root, const Vector4& last) {
  return lie::quaternion_product(lie::quaternion_product(conjugate(first), first_root),
                                 lie::quaternion_product(conjugate(root), last));
}

Matrix34 rotation_goal_rows(const Matrix3& goal) {
  const Vector4 q = lie::quaternion_of_rotation(goal);
  return 2.0 * left_product(conjugate(q)).bottomRows<3>();
}

}  // namespace lamprey::maneuver
