#include "report/outline.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace lamprey::report {

View top_view() { return (View() << 1.0, 0.0, 0.0, 0.0, 1.0, 0.0).finished(); }
View side_view() { return (View() << 1.0, 0.0, 0.0, 0.0, 0.0, 1.0).finished(); }
View back_view() { return (View() << 0.0, -1.0, 0.0, 0.0, 0.0, 1.0).finished(); }

Eigen::Vector2d Ellipse::half_extent() const {
  const double c = std::cos(angle), s = std::sin(angle);
  return {std::hypot(major * c, minor * s), std::hypot(major * s, minor * c)};
}

Ellipse projected_outline(const Eigen::Vector3d& semi_axes, const Eigen::Matrix3d& R, const Eigen::Vector3d& centre,
                          const View& view) {
  const Eigen::Matrix<double, 2, 3> B = view * R * semi_axes.asDiagonal();
  const Eigen::Matrix2d S = B * B.transpose();
  const double mean = 0.5 * (S(0, 0) + S(1, 1)), difference = 0.5 * (S(0, 0) - S(1, 1));
  const double largest = mean + std::hypot(difference, S(0, 1));
  // det S = |b_1 × b_2|² does not cancel for flat outlines, mean − hypot does
  const double determinant = Eigen::Vector3d(B.row(0)).cross(Eigen::Vector3d(B.row(1))).squaredNorm();
  Ellipse ellipse;
  ellipse.centre = view * centre;
  ellipse.major = std::sqrt(largest);
  ellipse.minor = largest > 0.0 ? std::sqrt(determinant / largest) : 0.0;
  ellipse.angle = 0.5 * std::atan2(2.0 * S(0, 1), 2.0 * difference);
  return ellipse;
}

}  // namespace lamprey::report
