// An end whose joints rest while the whole drifts on: what they carry there follows from total momentum and the end's
// configuration alone (equation 6.26).
#pragma once

#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// Along the freedoms of all bodies but the root, f of them.
struct CarriedAtRest {
  VectorXd momentum;          // [f] kg m²/s
  MatrixXd by_configuration;  // [f][turns + 3] by all freedoms and the root's position
};

/// With the total momentum of the problem's start.
CarriedAtRest carried_at_rest(const model::System& system, const maneuver::Problem& problem,
                              const mechanics::Rotations& rotation, const Vector3d& position);

/// Second derivative of multiplier · momentum by the configuration, [turns + 3] squared.
MatrixXd curvature_at_rest(const model::System& system, const maneuver::Problem& problem,
                           const mechanics::Rotations& rotation, const Vector3d& position, const VectorXd& multiplier);

/// The same momenta of all freedoms and the root, from the velocities of a whole that moves as one.
VectorXd momentum_at_rest(const StoredMotion& motion);

}  // namespace lamprey::evidence
