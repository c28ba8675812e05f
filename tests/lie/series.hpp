// Power series of the rotation group's functions in extended precision: a slow road that shares no formula with lie/so3.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Core>

namespace lamprey::tests {

using LongMatrix3 = Eigen::Matrix<long double, 3, 3>;

inline LongMatrix3 long_hat(const Eigen::Vector3d& v) {
  LongMatrix3 m = LongMatrix3::Zero();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    m(k, j) = v[i];
    m(j, k) = -v[i];
  }
  return m;
}

/// Σ_{n ≥ first} Aⁿ/n! for matrices of norm up to about 7.
inline LongMatrix3 exponential_series(const LongMatrix3& A, int first = 0) {
  LongMatrix3 term = LongMatrix3::Identity();
  LongMatrix3 sum = LongMatrix3::Zero();
  for (int n = 0; n < 60; ++n) {
    if (n >= first) sum += term;
    term = (term * A / static_cast<long double>(n + 1)).eval();
  }
  return sum;
}

/// Σ (−v̂)ⁿ/(n+1)!, the body-side derivative of the exponential.
inline LongMatrix3 tangent_series(const Eigen::Vector3d& v) {
  const LongMatrix3 A = -long_hat(v);
  LongMatrix3 term = LongMatrix3::Identity();
  LongMatrix3 sum = LongMatrix3::Zero();
  for (int n = 0; n < 60; ++n) {
    sum += term;
    term = (term * A / static_cast<long double>(n + 2)).eval();
  }
  return sum;
}

/// Rotation vectors of each given length: along the axes, along the diagonal, and at random.
inline std::vector<Eigen::Vector3d> vectors_of_length(const std::vector<double>& lengths) {
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> directions = {{1, 0, 0},  {0, 1, 0},   {0, 0, 1},   {1, 1, 1},
                                             {-1, 1, 0}, {0, -1, -1}, {1e-9, 1, 1}};
  for (int n = 0; n < 20; ++n) directions.emplace_back(normal(generator), normal(generator), normal(generator));
  std::vector<Eigen::Vector3d> vectors;
  for (const double length : lengths) {
    for (const Eigen::Vector3d& direction : directions) vectors.emplace_back(length * direction.normalized());
  }
  return vectors;
}

}  // namespace lamprey::tests
