#include "fluid/overlap.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d shape_matrix(const PlacedEllipsoid& body) {
  return body.rotation * body.semi_axes.cwiseAbs2().asDiagonal() * body.rotation.transpose();
}

// v = G⁻¹r with G = (1−λ)A + λB; the concave function F = λ(1−λ) r·v has the slope (1−λ)² v·Av − λ² v·Bv and the
// curvature −2 Av·G⁻¹Bv.
struct Maximisation {
  Matrix3d A;
  Matrix3d B;
  Vector3d r;
  Vector3d v = Vector3d::Zero();
  double slope = 0.0;
  double curvature = 0.0;

  void evaluate(double lambda) {
    const double rest = 1.0 - lambda;
    const Eigen::LLT<Matrix3d> G(rest * A + lambda * B);
    v = G.solve(r);
    const Vector3d Av = A * v;
    const Vector3d Bv = B * v;
    slope = rest * rest * v.dot(Av) - lambda * lambda * v.dot(Bv);
    curvature = -2.0 * Av.dot(G.solve(Bv));
  }
};

// Newton's method on the slope inside a shrinking bracket; the value is flat there, so that 1e-10 in λ is enough.
double maximising_fraction(Maximisation& problem) {
  double lower = 0.0;
  double upper = 1.0;
  double lambda = 0.5;
  for (int n = 0; n < 100; ++n) {
    problem.evaluate(lambda);
    (problem.slope > 0.0 ? lower : upper) = lambda;
    const double newton = lambda - problem.slope / problem.curvature;
    const double next = newton > lower && newton < upper ? newton : 0.5 * (lower + upper);
    const bool settled = std::abs(next - lambda) < 1e-10 * std::min(lambda, 1.0 - lambda);
    lambda = next;
    if (settled) break;
  }
  problem.evaluate(lambda);
  return lambda;
}

}  // namespace

Contact contact(const PlacedEllipsoid& a, const PlacedEllipsoid& b) {
  Maximisation problem{shape_matrix(a), shape_matrix(b), b.centre - a.centre};
  const double distance = problem.r.norm();
  if (distance == 0.0) return {0.0, 0.5, Vector3d::Zero(), a.centre, -a.semi_axes.minCoeff() - b.semi_axes.minCoeff()};
  const double lambda = maximising_fraction(problem);
  const double value = lambda * (1.0 - lambda) * problem.r.dot(problem.v);
  const Vector3d point = a.centre + (1.0 - lambda) * (problem.A * problem.v);
  return {value, lambda, problem.v, point, distance * (1.0 - 1.0 / std::sqrt(value))};
}

}  // namespace lamprey::fluid
