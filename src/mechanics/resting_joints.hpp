// What a swimmer whose joints rest carries along its joints, while the whole moves as one with its total momentum: the end that a
// drifting swimmer can come to, with first and second derivatives by its shape (chapter 9, equations 9.37 to 9.39).
#pragma once

#include <memory>

#include "mechanics/tree_motion.hpp"

namespace lamprey::mechanics {

/// One shape at a time. Coordinates are the freedoms of all bodies but the root, f of them; total momentum is angular about the
/// root's mass centre, then linear, both seen from the root, kg m²/s and kg m/s. After construction it asks for no memory.
class RestingJoints {
 public:
  using Momentum = Eigen::Matrix<double, 6, 1>;

  explicit RestingJoints(const model::System& system);
  ~RestingJoints();
  RestingJoints(RestingJoints&&) noexcept;
  RestingJoints& operator=(RestingJoints&&) noexcept;

  /// Takes a shape, the bodies' rotations as the root sees them; all else is said of it.
  void take(const Rotations& shape);

  /// Momenta along the coordinates, N m s, by the total: [f][6] (equation 9.37).
  const MatrixXd& by_total() const;

  /// How these momenta change along the coordinates where the whole carries `total`: [f][f], a column for each direction.
  void rates(const Momentum& total, MatrixXd& rates);

  /// Second derivative of multiplier · momenta along the coordinates, [f][f] symmetric, directions being constant freedoms, and
  /// the rate along them of its derivative by the total, [f][6].
  void curvature(const VectorXd& multiplier, const Momentum& total, MatrixXd& form, MatrixXd& by_total);

 private:
  struct Space;
  std::unique_ptr<Space> space_;
};

}  // namespace lamprey::mechanics
