// The stored moments along what joints and drives can exert, and the free numbers behind them.
#pragma once

#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// Columns of its joint's actuation that are a drive's.
model::Axes axes_of(const model::System& system, const model::Drive& drive);

/// Moment of a drive at a node, as its joint's is stored.
Vector3d moment_of(const StoredMotion& motion, const model::Drive& drive, int node);

/// Moments along the actuation of all joints at a node, [controls] N m.
VectorXd moments_at(const StoredMotion& motion, int node);

/// Stored moments along the actuation axes, [N+1][controls] N m.
MatrixXd actuated_moments(const StoredMotion& motion);

/// The free numbers behind the stored moments: along each joint's actuation at each node, or at each spline point.
struct ControlSpace {
  VectorXd value;  // [nodes or points × controls] N m, node after node or point after point
  MatrixXd basis;  // [N+1][points] moments at the nodes by the points; empty for one value at each node
  double outside;  // largest part of a moment that this space cannot make / largest moment
};

ControlSpace control_space(const StoredMotion& motion);

/// Largest part of a stored moment outside the actuation axes / largest moment.
double beyond_actuation(const StoredMotion& motion);

}  // namespace lamprey::evidence
