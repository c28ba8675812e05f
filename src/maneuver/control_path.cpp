#include "maneuver/control_path.hpp"

#include <algorithm>

#include <Eigen/QR>
#include <Eigen/SparseLU>

namespace lamprey::maneuver {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of the spline's continuity of slope, and the end conditions, in the second derivatives at the samples.
Eigen::SparseMatrix<double> spline_matrix(Interpolation interpolation, const VectorXd& step) {
  const auto count = step.size() + 1;
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&entries](Eigen::Index r, Eigen::Index c, double v) {
    entries.emplace_back(static_cast<int>(r), static_cast<int>(c), v);
  };
  for (Eigen::Index k = 1; k + 1 < count; ++k) {
    add(k, k - 1, step[k - 1] / 6.0);
    add(k, k, (step[k - 1] + step[k]) / 3.0);
    add(k, k + 1, step[k] / 6.0);
  }
  const bool natural = interpolation != Interpolation::not_a_knot_cubic || count < 4;
  if (natural) {
    add(0, 0, 1.0);
    add(count - 1, count - 1, 1.0);
  } else {  // the third derivative does not jump at the second and the last but one sample
    const Eigen::Index n = count - 1;
    add(0, 0, step[1]);
    add(0, 1, -(step[0] + step[1]));
    add(0, 2, step[0]);
    add(n, n, step[n - 2]);
    add(n, n - 1, -(step[n - 1] + step[n - 2]));
    add(n, n - 2, step[n - 1]);
  }
  Eigen::SparseMatrix<double> matrix(static_cast<int>(count), static_cast<int>(count));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// Second derivatives at the samples.
MatrixXd second_derivatives(Interpolation interpolation, const VectorXd& times, const MatrixXd& samples) {
  const Eigen::Index count = times.size();
  MatrixXd second = MatrixXd::Zero(samples.rows(), count);
  if (interpolation == Interpolation::linear || count < 3) return second;
  const VectorXd step = times.tail(count - 1) - times.head(count - 1);
  if (interpolation == Interpolation::not_a_knot_cubic && count == 3) {  // the parabola through three samples
    const VectorXd slope_change =
        (samples.col(2) - samples.col(1)) / step[1] - (samples.col(1) - samples.col(0)) / step[0];
    second.colwise() = 2.0 * slope_change / (step[0] + step[1]);
    return second;
  }
  MatrixXd rhs = MatrixXd::Zero(count, samples.rows());
  for (Eigen::Index k = 1; k + 1 < count; ++k)
    rhs.row(k) = ((samples.col(k + 1) - samples.col(k)) / step[k] - (samples.col(k) - samples.col(k - 1)) / step[k - 1])
                     .transpose();
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(spline_matrix(interpolation, step));
  const MatrixXd solved = solver.solve(rhs);
  return solved.transpose();
}

}  // namespace

ControlPath::ControlPath(Interpolation interpolation, const VectorXd& times, const MatrixXd& samples)
    : times_(times), samples_(samples), second_(second_derivatives(interpolation, times, samples)) {}

VectorXd ControlPath::value(double t) const {
  if (times_.size() == 1) return samples_.col(0);
  const double* begin = times_.data();
  const double* after = std::upper_bound(begin + 1, begin + times_.size() - 1, t);
  const Eigen::Index k = after - begin - 1;
  const double step = times_[k + 1] - times_[k];
  const double b = (t - times_[k]) / step;
  const double a = 1.0 - b;
  return a * samples_.col(k) + b * samples_.col(k + 1) +
         step * step / 6.0 * ((a * a * a - a) * second_.col(k) + (b * b * b - b) * second_.col(k + 1));
}

MatrixXd natural_spline_basis(int points, double duration, const VectorXd& times) {
  const ControlPath unit(Interpolation::natural_cubic, VectorXd::LinSpaced(points, 0.0, duration),
                         MatrixXd::Identity(points, points));
  MatrixXd basis(times.size(), points);
  for (Eigen::Index k = 0; k < times.size(); ++k) basis.row(k) = unit.value(times[k]).transpose();
  return basis;
}

ControlPath natural_spline_through_nodes(int points, const VectorXd& times, const MatrixXd& samples) {
  const double duration = times[times.size() - 1];
  const MatrixXd basis = natural_spline_basis(points, duration, times);
  const MatrixXd values = basis.colPivHouseholderQr().solve(samples.transpose()).transpose();
  return ControlPath(Interpolation::natural_cubic, VectorXd::LinSpaced(points, 0.0, duration), values);
}

}  // namespace lamprey::maneuver
