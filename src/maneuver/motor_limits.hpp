// What motors give of the moments that a controller asks for: no more than a problem's limits of torque.
#pragma once

#include <vector>

#include "maneuver/problem.hpp"
#include "mechanics/continuous.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

class MotorLimits {
 public:
  MotorLimits(const model::System& system, const Problem& problem);

  /// Whether any joint has a limit of torque.
  bool any() const;
  /// Moments, [joints] N m on the parents: components along the joints' actuation cut at limits.torque_component, then the whole
  /// shortened to limits.torque.
  mechanics::Moments within(mechanics::Moments asked) const;

 private:
  struct Motor {
    Eigen::MatrixXd actuation;  // [3][controls]
    double whole, component;    // N m; infinite: no limit
  };
  std::vector<Motor> motors_;  // [joints]
};

}  // namespace lamprey::maneuver
