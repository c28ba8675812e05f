// First derivatives of the cost along the stored motion: of the effort by the free numbers of the moments, of the other costs by
// states and moments.
#pragma once

#include "evidence/control_space.hpp"
#include "evidence/cost_check.hpp"

namespace lamprey::optimality {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using evidence::StoredMotion;

/// Weight of each node's ½|u|² in the cost, [N+1] s.
VectorXd node_weights(const StoredMotion& motion);

/// Gradient of the cost by the free numbers of the space.
VectorXd cost_gradient(const StoredMotion& motion, const evidence::ControlSpace& space);

/// Derivatives of the costs beside effort and time, powers' signs as the stored multipliers have them.
struct CostGradient {
  std::vector<VectorXd> by_state;    // [N + 1][n] as integrator::StateLayout
  std::vector<VectorXd> by_control;  // [N + 1][controls]
  double by_log_time_step = 0.0;     // states and moments held
};

CostGradient cost_gradient_beside_effort(const StoredMotion& motion);

/// Its part by the last state that is a worth of displacement, or of work per a free distance, [n] as integrator::StateLayout.
VectorXd gradient_of_displacement(const StoredMotion& motion);

/// Gradient of the costs of power, work and angular velocity by the turns over the steps, [N][joints].
std::vector<mechanics::Vectors> pulls_on_turns(const StoredMotion& motion, const evidence::Powers& powers);

}  // namespace lamprey::optimality
