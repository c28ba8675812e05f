#include "maneuver/motor_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamprey::maneuver {

namespace {

double limit_of(const std::string& joint, const std::optional<double>& all,
                const std::map<std::string, double>& named) {
  const auto own = named.find(joint);
  return own != named.end() ? own->second : all.value_or(std::numeric_limits<double>::infinity());
}

}  // namespace

MotorLimits::MotorLimits(const model::System& system, const Limits& limits) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    motors_.push_back({joint.actuation, limit_of(joint.name, limits.torque, limits.joint_torque),
                       limit_of(joint.name, limits.torque_component, limits.joint_torque_component)});
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
