#include "maneuver/motor_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "maneuver/limit_rows.hpp"

namespace lamprey::maneuver {

MotorLimits::MotorLimits(const model::System& system, const Problem& problem) {
  constexpr double none = std::numeric_limits<double>::infinity();
  for (int j = 0; j < system.joint_count(); ++j) motors_.push_back({system.joint(j).actuation, none, none});
  for (const LimitRow& row : limit_rows(system, problem)) {
    if (!row.of_moments()) continue;
    Motor& motor = motors_[static_cast<std::size_t>(row.joint)];
    (row.kind == LimitRow::Kind::torque ? motor.whole : motor.component) = row.bound;
  }
}

bool MotorLimits::any() const {
  return std::any_of(motors_.begin(), motors_.end(),
                     [](const Motor& motor) { return std::isfinite(motor.whole) || std::isfinite(motor.component); });
}

mechanics::Moments MotorLimits::within(mechanics::Moments asked) const {
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    const Motor& motor = motors_[j];
    Eigen::Vector3d& u = asked[j];
    for (Eigen::Index c = 0; c < motor.actuation.cols(); ++c) {
      const double along = motor.actuation.col(c).dot(u);
      u += (std::clamp(along, -motor.component, motor.component) - along) * motor.actuation.col(c);
    }
    if (const double whole = u.norm(); whole > motor.whole) u *= motor.whole / whole;
  }
  return asked;
}

}  // namespace lamprey::maneuver
