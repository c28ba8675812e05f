// What the multipliers of limits and waypoints add to the conditions of optimality: derivatives by central differences of the
// margins.
#pragma once

#include "evidence/bounds.hpp"

namespace lamprey::optimality {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using evidence::StoredMotion;

/// Gradient of Σ multiplier · time · margin by what the margins look at.
struct LimitPulls {
  std::vector<VectorXd> by_state;    // [N + 1][n] as integrator::StateLayout
  std::vector<VectorXd> by_control;  // [N + 1][controls]
  double by_log_time_step = 0.0;     // states and moments held
  bool any = false;
};

LimitPulls limit_pulls(const StoredMotion& motion);

/// A bound that pulls at a node: the Lagrangian has −pull · margin there. Its margin's derivatives are by `place`, which
/// is the moments of the node, or the freedoms and the root's position at the node, and after them at the node before
/// where the margin looks there.
struct PullingBound {
  int node;
  bool of_moments;
  double pull;         // multiplier × time × unit; of waypoints of either sign
  VectorXd gradient;   // [place] of the margin in a unit: the bound's own value, the swimmer's unit of length, 1 rad
  MatrixXd curvature;  // [place][place] along exponentials
  // by the logarithm of the time step, shapes and impulses h²u held: first, second, mixed with the place
  double by_time, by_time_twice;
  VectorXd by_time_mixed;  // [place]
  bool holds = false;      // whether what moves has to keep it; a pull where nothing holds is a solver's remainder
  bool equality = false;   // a waypoint's
};

/// All but those of the duration.
std::vector<PullingBound> pulling_bounds(const StoredMotion& motion);

}  // namespace lamprey::optimality
