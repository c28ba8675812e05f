// Limits and waypoints of an answer, measured on the stored motion: margins in the units of the problem file, and what
// their multipliers add to the conditions of optimality. Derivatives by central differences of the margins.
#pragma once

#include <string>
#include <vector>

#include "certificate/bounds.hpp"
#include "certificate/limit_reach.hpp"

namespace lamprey::certificate {

/// The tightest place of all limits.
struct LimitCheck {
  double violation =
      0.0;            // largest: rad or m, of moments, rates and durations against the bound; of waypoints the miss
  std::string key;    // where: of the problem file
  double time = 0.0;  // s
  double complementarity =
      0.0;                // largest |multiplier · margin| over the nodes, against what is spent over the duration
  double negative = 0.0;  // most negative multiplier of a limit, against the largest
  std::vector<LimitReach> reaches = {};  // all limits, in the order of the file's keys
  double missed = 0.0;                   // rad or m, of waypoints at most
};

LimitCheck check_limits(const StoredMotion& motion);

/// Largest violation of the limits of that key at the node of that time, s; below 0 where they are kept, NaN where there is no such
/// limit or node.
double violation_at(const StoredMotion& motion, const std::string& key, double time);

/// [N + 1] how far a bound is from being broken at the nodes, in its own unit; NaN where it asks for nothing.
std::vector<double> margins(const StoredMotion& motion, const Bound& bound);

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

/// Whether a bound of the duration leaves it no room.
bool duration_holds(const StoredMotion& motion);

}  // namespace lamprey::certificate
