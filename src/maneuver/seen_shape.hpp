// Shapes as they are seen: between the nodes of a motion, or measured, and brought back within the limits of the joints.
#pragma once

#include <vector>

#include "integrator/step.hpp"
#include "maneuver/limit_rows.hpp"

namespace lamprey::maneuver {

/// A shape in motion.
struct SeenShape {
  std::vector<Matrix3d> rotation;  // [joints] child → parent
  mechanics::Vectors rate;         // [joints] rad/s, as mechanics::velocity_of_rates has them
};

SeenShape shape_of(const model::System& system, const integrator::State& state);

/// rad/s, of one joint at Q (child → parent), as in SeenShape. `angular`: of all bodies, body frames, [bodies] rad/s; `velocity`: the
/// system's.
Vector3d joint_rate(const model::System& system, const model::Joint& joint, const Matrix3d& Q,
                    const mechanics::Vectors& angular, const VectorXd& velocity);

/// A share of the way from a node to the next, `time_step` s later, at the mean rate: within limits of angles where both nodes
/// are, and as fast as limits of rates count it.
SeenShape shape_between(const model::System& system, const mechanics::Rotations& from, const mechanics::Rotations& to,
                        double time_step, double share);

/// Where a joint is beyond a limit of angle, swing or twist.
struct BeyondLimit {
  double angle = 0.0;  // rad; 0: nowhere
  const LimitRow* limit = nullptr;
};
BeyondLimit beyond_limits(const model::System& system, const std::vector<LimitRow>& rows, const SeenShape& shape);

/// Joints beyond their limits stand still at these, on their way to a shape within, [bodies] body → world.
SeenShape held_within_limits(const model::System& system, const std::vector<LimitRow>& rows, SeenShape shape,
                             const mechanics::Rotations& inside);

/// The state of a shape where the root is, the whole moving as its total momentum demands.
integrator::State state_of(const model::System& system, const Matrix3d& root, const Vector3d& position,
                           const SeenShape& shape, const mechanics::SpatialMomentum& total);

}  // namespace lamprey::maneuver
