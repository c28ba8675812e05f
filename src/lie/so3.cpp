#include "lie/so3.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace lamprey::lie {

namespace {

// sin(t)/t, and (t − sin t)/t³, both without cancellation.
double sinc(double t) { return std::abs(t) < 1e-4 ? 1.0 - t * t / 6.0 : std::sin(t) / t; }

double cubic_remainder(double t) {
  if (std::abs(t) > 0.5) return (t - std::sin(t)) / (t * t * t);
  double term = 1.0 / 6.0;
  double sum = term;
  for (int n = 1; n < 9; ++n) {
    term *= -t * t / ((2.0 * n + 2.0) * (2.0 * n + 3.0));
    sum += term;
  }
  return sum;
}

// k(t) = (1 − (t/2) cot(t/2))/t² and k'(t)/t, by series where they cancel.
struct LogCurvature {
  double value;
  double slope_over_t;
};

LogCurvature log_curvature(double t) {
  if (std::abs(t) > 1.0) {
    const double half = 0.5 * t;
    const double s = std::sin(half);
    const double cotangent = std::cos(half) / s;
    const double value = (1.0 - half * cotangent) / (t * t);
    return {value, ((half / (s * s) - cotangent) / (2.0 * t) - 2.0 * value) / (t * t)};
  }
  // Σ |B_2n|/(2n)! t^(2n−2), n ≥ 1; the ratio of neighbours tends to 1/(4π²)
  constexpr double coefficients[] = {1.0 / 12.0,
                                     1.0 / 720.0,
                                     1.0 / 30240.0,
                                     1.0 / 1209600.0,
                                     1.0 / 47900160.0,
                                     691.0 / 1307674368000.0,
                                     1.0 / 74724249600.0,
                                     3617.0 / 10670622842880000.0,
                                     43867.0 / 5109094217170944000.0,
                                     174611.0 / 802857662698291200000.0};
  LogCurvature sum{0.0, 0.0};
  for (int n = 9; n >= 0; --n) sum.value = sum.value * t * t + coefficients[n];
  for (int n = 9; n >= 1; --n) sum.slope_over_t = sum.slope_over_t * t * t + 2.0 * n * coefficients[n];
  return sum;
}

}  // namespace

Matrix3 exp(const Vector3& v) {
  const double t = v.norm();
  const double half = sinc(0.5 * t);
  const Matrix3 V = hat(v);
  return Matrix3::Identity() + sinc(t) * V + 0.5 * half * half * V * V;
}

Vector3 log(const Matrix3& R) {
  const Vector4 q = quaternion_of_rotation(R);
  const Vector3 v = q.tail<3>();
  const double s = v.norm();
  if (s < 1e-12) return 2.0 * v / q[0];
  return 2.0 * std::atan2(s, q[0]) / s * v;
}

Matrix3 cayley_minus_identity(const Vector3& zeta) {
  // 2/(1 + |ζ|²) (ζ̂ + ζζᵀ − |ζ|² I)
  const double square = zeta.squaredNorm();
  const double factor = 2.0 / (1.0 + square);
  const Vector3 z = factor * zeta;
  Matrix3 m = z * zeta.transpose();
  m.diagonal().array() -= factor * square;
  m(0, 1) -= z.z();
  m(0, 2) += z.y();
  m(1, 0) += z.z();
  m(1, 2) -= z.x();
  m(2, 0) -= z.y();
  m(2, 1) += z.x();
  return m;
}

Matrix3 cayley(const Vector3& zeta) { return Matrix3::Identity() + cayley_minus_identity(zeta); }

Vector3 inverse_cayley(const Matrix3& R) {
  const double trace = R.trace();
  if (trace > 0.0) return 2.0 / (1.0 + trace) * vee(R);
  const Vector4 q = quaternion_of_rotation(R);
  return q.tail<3>() / q[0];
}

Matrix3 cayley_tangent(const Vector3& zeta) {
  return 2.0 / (1.0 + zeta.squaredNorm()) * (Matrix3::Identity() - hat(zeta));
}

Matrix3 exp_tangent(const Vector3& v) {
  const double t = v.norm();
  const double half = sinc(0.5 * t);
  const Matrix3 V = hat(v);
  return Matrix3::Identity() - 0.5 * half * half * V + cubic_remainder(t) * V * V;
}

Matrix3 log_tangent(const Vector3& v) {
  const Matrix3 V = hat(v);
  return Matrix3::Identity() + 0.5 * V + log_curvature(v.norm()).value * V * V;
}

Matrix3 log_tangent_rate(const Vector3& v, const Vector3& rate) {
  const LogCurvature k = log_curvature(v.norm());
  const Matrix3 V = hat(v);
  const Matrix3 W = hat(rate);
  return 0.5 * W + k.value * (V * W + W * V) + k.slope_over_t * v.dot(rate) * V * V;
}

Matrix3 rotation_of_quaternion(const Vector4& q) {
  const double s = 2.0 / q.squaredNorm();
  const Matrix3 V = hat(q.tail<3>());
  return Matrix3::Identity() + s * (q[0] * V + V * V);
}

Vector4 quaternion_of_rotation(const Matrix3& R) {
  const Eigen::Quaterniond q(R);
  const Vector4 wxyz(q.w(), q.x(), q.y(), q.z());
  return (q.w() < 0.0 ? -1.0 : 1.0) * wxyz / wxyz.norm();
}

Vector4 quaternion_product(const Vector4& a, const Vector4& b) {
  const Vector3 u = a.tail<3>();
  const Vector3 v = b.tail<3>();
  Vector4 c;
  c[0] = a[0] * b[0] - u.dot(v);
  c.tail<3>() = a[0] * v + b[0] * u + u.cross(v);
  return c;
}

Eigen::Matrix<double, 3, 4> quaternion_tangent(const Vector4& q) {
  // η = 2 vec(q* ∘ δq)/|q|²
  const Vector3 u = q.tail<3>();
  Eigen::Matrix<double, 3, 4> T;
  T.col(0) = -u;
  T.rightCols<3>() = q[0] * Matrix3::Identity() - hat(u);
  return 2.0 / q.squaredNorm() * T;
}

double rotation_angle(const Matrix3& R) {
  const Vector4 q = quaternion_of_rotation(R);
  return 2.0 * std::atan2(q.tail<3>().norm(), q[0]);
}

// A Newton step towards the polar decomposition's rotation: what was left is squared.
Matrix3 renormalized(const Matrix3& R) {
  const Matrix3 left = Matrix3(R.transpose().lazyProduct(R)) - Matrix3::Identity();
  return R - 0.5 * R.lazyProduct(left);
}

}  // namespace lamprey::lie
