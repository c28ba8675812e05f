#include "maneuver/control_path.hpp"

#include <algorithm>

#include "algebra/row_space.hpp"

namespace lamprey::maneuver {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Solves lower[k] x[k−1] + diagonal[k] x[k] + upper[k] x[k+1] = rhs[k], rows of rhs being components; diagonally dominant.
MatrixXd solve_tridiagonal(const VectorXd& lower, VectorXd diagonal, const VectorXd& upper, MatrixXd rhs) {
  const Eigen::Index count = diagonal.size();
  for (Eigen::Index k = 1; k < count; ++k) {
    const double factor = lower[k] / diagonal[k - 1];
    diagonal[k] -= factor * upper[k - 1];
    rhs.col(k) -= factor * rhs.col(k - 1);
  }
  rhs.col(count - 1) /= diagonal[count - 1];
  for (Eigen::Index k = count - 1; k-- > 0;) rhs.col(k) = (rhs.col(k) - upper[k] * rhs.col(k + 1)) / diagonal[k];
  return rhs;
}

// Second derivatives at the samples, from the continuity of slope at the inner ones.
MatrixXd second_derivatives(Interpolation interpolation, const VectorXd& times, const MatrixXd& samples) {
  const Eigen::Index count = times.size();
  MatrixXd second = MatrixXd::Zero(samples.rows(), count);
  if (interpolation == Interpolation::linear || count < 3) return second;
  const VectorXd step = times.tail(count - 1) - times.head(count - 1);
  const Eigen::Index inner = count - 2;
  VectorXd lower(inner), diagonal(inner), upper(inner);
  MatrixXd bend(samples.rows(), inner);
  for (Eigen::Index k = 0; k < inner; ++k) {
    lower[k] = step[k] / 6.0;
    upper[k] = step[k + 1] / 6.0;
    diagonal[k] = 2.0 * (lower[k] + upper[k]);
    bend.col(k) =
        (samples.col(k + 2) - samples.col(k + 1)) / step[k + 1] - (samples.col(k + 1) - samples.col(k)) / step[k];
  }
  const bool free_ends = interpolation == Interpolation::natural_cubic;
  if (!free_ends && count == 3) {  // the parabola through three samples
    second.colwise() = 2.0 * bend.col(0) / (step[0] + step[1]);
    return second;
  }
  // not-a-knot: the third derivative does not jump at the second and the last but one sample, which ties the end values
  const double first = step[0] / step[1];
  const double last = step[inner] / step[inner - 1];
  if (!free_ends) {
    diagonal[0] += lower[0] * (1.0 + first);
    upper[0] -= lower[0] * first;
    diagonal[inner - 1] += upper[inner - 1] * (1.0 + last);
    lower[inner - 1] -= upper[inner - 1] * last;
  }
  second.middleCols(1, inner) = solve_tridiagonal(lower, diagonal, upper, bend);
  if (free_ends) return second;
  second.col(0) = (1.0 + first) * second.col(1) - first * second.col(2);
  second.col(count - 1) = (1.0 + last) * second.col(count - 2) - last * second.col(count - 3);
  return second;
}

}  // namespace

ControlPath::ControlPath(Interpolation interpolation, const VectorXd& times, const MatrixXd& samples)
    : times_(times), samples_(samples), second_(second_derivatives(interpolation, times, samples)) {}

ControlPath::Piece ControlPath::piece_at(double t) const {
  const double* begin = times_.data();
  const double* after = std::upper_bound(begin + 1, begin + times_.size() - 1, t);
  const Eigen::Index k = after - begin - 1;
  const double step = times_[k + 1] - times_[k];
  const double b = (t - times_[k]) / step;
  return {k, step, 1.0 - b, b};
}

VectorXd ControlPath::value(double t) const {
  if (times_.size() == 1) return samples_.col(0);
  const auto [k, step, a, b] = piece_at(t);
  const double bend = step * step / 6.0;
  VectorXd value = a * samples_.col(k);
  algebra::add_multiple(b, samples_.col(k + 1), value);
  algebra::add_multiple(bend * (a * a * a - a), second_.col(k), value);
  algebra::add_multiple(bend * (b * b * b - b), second_.col(k + 1), value);
  return value;
}

VectorXd ControlPath::slope(double t) const {
  if (times_.size() == 1) return VectorXd::Zero(samples_.rows());
  const auto [k, step, a, b] = piece_at(t);
  const double bend = step / 6.0;
  VectorXd slope = (samples_.col(k + 1) - samples_.col(k)) / step;
  algebra::add_multiple(-bend * (3.0 * a * a - 1.0), second_.col(k), slope);
  algebra::add_multiple(bend * (3.0 * b * b - 1.0), second_.col(k + 1), slope);
  return slope;
}

MatrixXd natural_spline_basis(int points, double duration, const VectorXd& times) {
  const ControlPath unit(Interpolation::natural_cubic, VectorXd::LinSpaced(points, 0.0, duration),
                         MatrixXd::Identity(points, points));
  MatrixXd basis(times.size(), points);
  for (Eigen::Index k = 0; k < times.size(); ++k) basis.row(k) = unit.value(times[k]).transpose();
  return basis;
}

MatrixXd spline_points(const MatrixXd& basis, const MatrixXd& samples) {
  return algebra::least_squares(basis, samples);
}

ControlPath natural_spline_through_nodes(int points, const VectorXd& times, const MatrixXd& samples) {
  const double duration = times[times.size() - 1];
  const MatrixXd basis = natural_spline_basis(points, duration, times);
  const MatrixXd values = spline_points(basis, samples.transpose()).transpose();
  return ControlPath(Interpolation::natural_cubic, VectorXd::LinSpaced(points, 0.0, duration), values);
}

}  // namespace lamprey::maneuver
