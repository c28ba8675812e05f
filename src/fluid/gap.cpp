#include "fluid/gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "fluid/overlap.hpp"
#include "lie/so3.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

constexpr double round_off = std::numeric_limits<double>::epsilon();

// One body as seen along n: its half width h = |SRᵀn|.
struct Support {
  Matrix3d axes;   // RS
  double width;    // h
  Vector3d unit;   // SRᵀn/h
  Vector3d point;  // RS²Rᵀn/h, where the plane with normal n touches

  Support(const Matrix3d& scaled_axes, const Vector3d& n) : axes(scaled_axes) {
    const Vector3d y = axes.transpose() * n;
    width = y.norm();
    unit = y / width;
    point = axes * unit;
  }

  // u × SRᵀT: its product with itself, divided by h, is the second derivative of h along the tangents T.
  Matrix32 bent(const Matrix32& tangents) const { return lie::hat(unit) * (axes.transpose() * tangents); }
};

// φ(n) = n·c − h_1 − h_2 about one direction of the sphere.
struct Separation {
  Vector3d n;
  Support first;
  Support second;
  Matrix32 tangents;
  double value;
  Vector2d slope;
  Matrix2d curvature;
};

struct Search {
  Matrix3d axes_1;
  Matrix3d axes_2;
  Vector3d offset;
  double size;  // of the terms of φ: what round-off is measured by

  explicit Search(const EllipsoidPair& pair)
      : axes_1(pair.rotation_1 * pair.semi_axes_1.asDiagonal()),
        axes_2(pair.rotation_2 * pair.semi_axes_2.asDiagonal()),
        offset(pair.offset),
        size(pair.offset.norm() + pair.semi_axes_1.maxCoeff() + pair.semi_axes_2.maxCoeff()) {}

  Separation at(const Vector3d& n) const {
    Separation s{n, Support(axes_1, n), Support(axes_2, n), {}, 0.0, {}, {}};
    s.tangents.col(0) = n.unitOrthogonal();
    s.tangents.col(1) = n.cross(s.tangents.col(0));
    s.value = n.dot(offset) - s.first.width - s.second.width;
    s.slope = s.tangents.transpose() * (offset - s.first.point - s.second.point);
    const Matrix32 bent_1 = s.first.bent(s.tangents);
    const Matrix32 bent_2 = s.second.bent(s.tangents);
    s.curvature = -bent_1.transpose() * bent_1 / s.first.width - bent_2.transpose() * bent_2 / s.second.width -
                  s.value * Matrix2d::Identity();
    return s;
  }
};

struct Step {
  Vector2d tangent;
  double gain;   // of the quadratic model
  bool bounded;  // by the radius
};

// Largest growth of slope·t + ½ t·curvature t, in the eigenvectors' axes with no coordinate beyond the radius.
Step model_step(const Separation& here, double radius) {
  Eigen::SelfAdjointEigenSolver<Matrix2d> eigen;
  eigen.computeDirect(here.curvature);
  Step step{Vector2d::Zero(), 0.0, false};
  for (int i = 0; i < 2; ++i) {
    const double lambda = eigen.eigenvalues()[i];
    const double g = eigen.eigenvectors().col(i).dot(here.slope);
    const bool inside = lambda < 0.0 && std::abs(g) <= -lambda * radius;
    const double t = inside ? -g / lambda : std::copysign(radius, g);
    step.tangent += t * eigen.eigenvectors().col(i);
    step.gain += t * (g + 0.5 * lambda * t);
    step.bounded = step.bounded || !inside;
  }
  return step;
}

Vector3d moved(const Separation& here, const Vector2d& tangent) {
  return (here.n + here.tangents * tangent).normalized();
}

struct Climb {
  Separation top;
  bool converged;
};

// At the top to round-off of φ the direction is not yet: the slope goes on to fall until it is round-off too.
Separation polished(const Search& search, Separation here, double noise) {
  for (int n = 0; n < 10; ++n) {
    const Separation there = search.at(moved(here, model_step(here, 1.0).tangent));
    if (!(there.slope.norm() < 0.5 * here.slope.norm()) || there.value < here.value - noise) break;
    here = there;
  }
  return here;
}

// Newton's method on the sphere, kept within a radius that trusts the quadratic model.
Climb climb(const Search& search, const Vector3d& start) {
  const double noise = 8.0 * round_off * search.size;
  Separation here = search.at(start);
  double radius = 0.5;
  for (int n = 0; n < 200; ++n) {
    const Step step = model_step(here, radius);
    if (step.gain <= noise) return {polished(search, here, noise), true};
    const Separation there = search.at(moved(here, step.tangent));
    const double quality = (there.value - here.value) / step.gain;
    if (quality > 0.1) here = there;
    if (quality < 0.25) {
      radius = 0.25 * std::min(radius, step.tangent.norm());
    } else if (quality > 0.75 && step.bounded) {
      radius = std::min(1.0, 2.0 * radius);
    }
  }
  return {here, false};
}

Climb higher(const Climb& a, const std::optional<Climb>& b) { return b && b->top.value > a.top.value ? *b : a; }

// A maximum at or above zero is the only one: φ is concave, and at the top of the ball |n| ≤ 1 its slope is φn, a
// multiplier of the right sign. Below zero others may be higher, even above zero. Bodies apart have a plane between
// them, that of the contact function: φ > 0 there and on all that is climbed from it.
std::optional<Climb> climb_from_separating_plane(const Search& search, const EllipsoidPair& pair) {
  const Vector3d normal =
      contact({pair.semi_axes_1, pair.rotation_1, Vector3d::Zero()}, {pair.semi_axes_2, pair.rotation_2, pair.offset})
          .normal.stableNormalized();
  if (!(normal.norm() > 0.0)) return std::nullopt;
  const Vector3d n = normal.normalized();
  if (!(search.at(n).value > 0.0)) return std::nullopt;
  return climb(search, n);
}

Gap gap_at(const Climb& climb) {
  const Separation& top = climb.top;
  return {top.value, top.n, top.first.point, -top.second.point, climb.converged};
}

}  // namespace

Gap gap(const EllipsoidPair& pair, const Vector3d& near) {
  const Search search(pair);
  Climb best = climb(search, near.stableNormalized().normalized());
  if (best.top.value < 0.0) best = higher(best, climb_from_separating_plane(search, pair));
  return gap_at(best);
}

Gap gap(const EllipsoidPair& pair) {
  const Search search(pair);
  const bool common_centre = pair.offset.isZero(0.0);
  Climb best =
      climb(search, common_centre ? Vector3d(pair.rotation_1.col(0)) : pair.offset.stableNormalized().normalized());
  if (best.top.value < 0.0) best = higher(best, climb_from_separating_plane(search, pair));
  if (best.top.value >= 0.0) return gap_at(best);
  for (const Matrix3d* rotation : {&pair.rotation_1, &pair.rotation_2})
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) best = higher(best, climb(search, sign * rotation->col(axis)));
  return gap_at(best);
}

namespace {

// A body's half width with its derivatives by n (along the tangents) and by its turn η: Rᵀn = m becomes exp(−η̂)m.
struct TurnedSupport {
  Vector3d by_turn;                     // s × m
  Matrix3d by_turn_twice;               // along exponentials
  Eigen::Matrix<double, 2, 3> by_both;  // tangents, turn
};

TurnedSupport turned(const Vector3d& semi_axes, const Matrix3d& R, const Support& seen, const Separation& at) {
  const Vector3d m = R.transpose() * at.n;
  const Vector3d s = R.transpose() * seen.point;
  const Matrix3d bent = lie::hat(seen.unit) * semi_axes.asDiagonal() * lie::hat(m);
  const Matrix32 tangents = R.transpose() * at.tangents;
  return {s.cross(m), bent.transpose() * bent / seen.width + lie::double_cross(s, m),
          seen.bent(at.tangents).transpose() * bent / seen.width - tangents.transpose() * lie::hat(s)};
}

// −K⁻¹ on the directions in which the maximum is sharp.
Matrix2d compliance(const Matrix2d& curvature, double flat) {
  Eigen::SelfAdjointEigenSolver<Matrix2d> eigen;
  eigen.computeDirect(curvature);
  Matrix2d result = Matrix2d::Zero();
  for (int i = 0; i < 2; ++i) {
    const double lambda = eigen.eigenvalues()[i];
    const Vector2d v = eigen.eigenvectors().col(i);
    if (lambda < -flat) result -= v * v.transpose() / lambda;
  }
  return result;
}

}  // namespace

void gap_derivatives(const EllipsoidPair& pair, const Gap& result, Vector9d& gradient, Matrix9d& hessian) {
  const Search search(pair);
  const Separation at = search.at(result.direction);
  const TurnedSupport first = turned(pair.semi_axes_1, pair.rotation_1, at.first, at);
  const TurnedSupport second = turned(pair.semi_axes_2, pair.rotation_2, at.second, at);
  gradient << -first.by_turn, -second.by_turn, at.n;
  Eigen::Matrix<double, 2, 9> mixed;
  mixed << -first.by_both, -second.by_both, at.tangents.transpose();
  hessian = mixed.transpose() * compliance(at.curvature, 16.0 * round_off * search.size) * mixed;
  hessian.block<3, 3>(0, 0) -= first.by_turn_twice;
  hessian.block<3, 3>(3, 3) -= second.by_turn_twice;
}

}  // namespace lamprey::fluid
