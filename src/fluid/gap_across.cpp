#include "fluid/gap_across.hpp"

#include <limits>

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int bounds_looked_at = 3;  // before a gap is found exactly

// A look at two bodies: a lower bound of their gap, and the direction that it was found along.
struct Look {
  double apart;
  Vector3d direction;
};

// Where a plane across a body touches it, from its centre.
Vector3d touched(const Vector3d& semi_axes, const Matrix3d& R, const Vector3d& n) {
  const Vector3d y = semi_axes.cwiseProduct(R.transpose() * n);
  return R * semi_axes.cwiseProduct(y) / y.norm();
}

// Along the centres, then along what is between the points that planes across them touch, until they are more than `enough` apart.
Look look_at(const EllipsoidPair& pair, double enough) {
  const double distance = pair.offset.norm();
  if (!(distance > 0.0)) return {0.0, Vector3d::Zero()};
  Look best{-std::numeric_limits<double>::infinity(), Vector3d::Zero()};
  Vector3d n = pair.offset / distance;
  for (int look = 0; look < bounds_looked_at; ++look) {
    const double apart = separation_along(pair, n);
    if (apart > best.apart) best = {apart, n};
    if (apart > enough) break;
    const Vector3d between =
        pair.offset - touched(pair.semi_axes_1, pair.rotation_1, n) - touched(pair.semi_axes_2, pair.rotation_2, n);
    const double length = between.norm();
    if (!(length > 0.0) || n.dot(between) < 0.0) break;
    n = between / length;
  }
  return best;
}

// Along a direction that lay between them nearby, where it still does.
Look look_across(const EllipsoidPair& pair, double enough, const Vector3d& across) {
  if (across.isZero(0.0)) return look_at(pair, enough);
  const double apart = separation_along(pair, across);
  return apart > 0.0 ? Look{apart, across} : look_at(pair, enough);
}

// Bodies apart have one gap from wherever it is searched.
Gap gap_after(const Look& look, const EllipsoidPair& pair) {
  return look.apart > 0.0 ? gap(pair, look.direction) : gap(pair);
}

}  // namespace

double gap_or_enough(const EllipsoidPair& pair, double enough, Vector3d& across) {
  const Look look = look_across(pair, enough, across);
  across = look.direction;
  if (look.apart > enough) return look.apart;
  const Gap found = gap_after(look, pair);
  across = found.direction;
  return found.value;
}

Gap gap_across(const EllipsoidPair& pair, Vector3d& across) {
  const Gap found = gap_after(look_across(pair, std::numeric_limits<double>::infinity(), across), pair);
  across = found.direction;
  return found;
}

}  // namespace lamprey::fluid
