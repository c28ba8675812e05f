// Costs beside effort and time of an answer, measured on the stored motion, and what they add to the conditions of optimality.
// Turns of the joints and their derivatives by a road of their own: differences of the stored rotations.
#pragma once

#include "certificate/limit_check.hpp"
#include "certificate/stored_motion.hpp"

namespace lamprey::certificate {

/// What the costs are, and how well the stored multipliers fit the powers' signs.
struct CostCheck {
  maneuver::CostParts parts;
  double cost = 0.0;  // of all parts by the problem's weights
  double signs =
      0.0;  // largest weight · (|p| − multiplier · p) against the cost over the duration, or |multiplier| − 1
};

CostCheck check_cost(const StoredMotion& motion);

/// Derivatives of the costs beside effort and time, powers' signs as the stored multipliers have them.
struct CostGradient {
  std::vector<VectorXd> by_state;    // [N + 1][n] as integrator::StateLayout
  std::vector<VectorXd> by_control;  // [N + 1][controls]
  double by_log_time_step = 0.0;     // states and moments held
};

CostGradient cost_gradient_beside_effort(const StoredMotion& motion);

}  // namespace lamprey::certificate
