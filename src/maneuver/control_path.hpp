// Controls as functions of time: samples at given times and how they run between them.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lamprey::maneuver {

enum class Interpolation { linear, natural_cubic, not_a_knot_cubic };

/// Piecewise cubic (or linear) path through samples; components are rows.
class ControlPath {
 public:
  /// times rise strictly, [S]; samples [components][S]. Not-a-knot needs four samples; with fewer, the polynomial through them.
  ControlPath(Interpolation interpolation, const Eigen::VectorXd& times, const Eigen::MatrixXd& samples);
  /// Value at time t; beyond the ends the end pieces go on.
  Eigen::VectorXd value(double t) const;
  /// Its rate of change, by s.
  Eigen::VectorXd slope(double t) const;

 private:
  struct Piece {
    Eigen::Index k;  // from sample k to the next
    double step;     // s, between the two
    double a, b;     // weights of the two at t
  };
  Piece piece_at(double t) const;

  Eigen::VectorXd times_;
  Eigen::MatrixXd samples_;
  Eigen::MatrixXd second_;  // second derivatives at the samples, [components][S]
};

/// Values at `times` of the natural cubic splines through unit samples at `points` uniform times over [0, duration]:
/// [times][points]. Column p is the path that is 1 at point p.
Eigen::MatrixXd natural_spline_basis(int points, double duration, const Eigen::VectorXd& times);

/// Values at the points whose spline comes nearest to samples at the nodes: [points][components] from the basis [nodes][points]
/// and samples [nodes][components].
Eigen::MatrixXd spline_points(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& samples);

/// The natural cubic spline through `points` uniform points whose values at the nodes' times come nearest to the samples
/// [components][nodes]; exact for samples of such a spline.
ControlPath natural_spline_through_nodes(int points, const Eigen::VectorXd& times, const Eigen::MatrixXd& samples);

}  // namespace lamprey::maneuver
