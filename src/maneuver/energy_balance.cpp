#include "maneuver/energy_balance.hpp"

#include <algorithm>
#include <cmath>

#include "mechanics/continuous.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::maneuver {

namespace {

using Eigen::Vector3d;
using model::at;
using model::System;

double energy_at(const System& system, const Solution& solution, std::size_t node) {
  const mechanics::Rotations& R = solution.rotation[node];
  return mechanics::energy(
      system, R,
      mechanics::velocity_of_bodies(system, R, solution.angular_velocity[node], R[0] * solution.linear_velocity[node]));
}

// W, of all joints: moments act on the parent, their opposites on the child.
double power_at(const System& system, const Solution& solution, std::size_t node) {
  double power = 0.0;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const Vectors& rate = solution.angular_velocity[node];
    const Vector3d turning =
        mechanics::child_to_parent(solution.rotation[node], joint) * rate[at(joint.child)] - rate[at(joint.parent)];
    power -= solution.control[node][at(j)].dot(turning);
  }
  return power;
}

}  // namespace

std::optional<EnergyBalance> energy_balance(const System& system, const Solution& solution) {
  const std::size_t nodes = solution.time.size();
  if (nodes == 0 || solution.angular_velocity.size() != nodes || solution.linear_velocity.size() != nodes ||
      solution.control.size() != nodes)
    return std::nullopt;
  const double first = energy_at(system, solution, 0);
  EnergyBalance balance{first, first, first, first, 0.0};
  double worked = 0.0, power = power_at(system, solution, 0);
  for (std::size_t k = 1; k < nodes; ++k) {
    balance.last = energy_at(system, solution, k);
    balance.least = std::min(balance.least, balance.last);
    balance.most = std::max(balance.most, balance.last);
    const double next = power_at(system, solution, k);
    worked += 0.5 * (solution.time[k] - solution.time[k - 1]) * (power + next);
    power = next;
    balance.unworked = std::max(balance.unworked, std::abs(balance.last - first - worked));
  }
  return balance;
}

}  // namespace lamprey::maneuver
