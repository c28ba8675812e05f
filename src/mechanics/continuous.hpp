// The continuous laws: energy, generalised momentum and forces (chapter 2).
// Generalised vectors have one layout: each body's freedoms (three for a body that turns on its own, body frame; else its
// joint's axes), body after body, then three for the root's position (world).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "mechanics/tree_motion.hpp"

namespace lamprey::mechanics {

/// [joints] N m: of a ball joint the moment on the parent, parent's frame; of a hinge or a universal joint the moments
/// about its axes, positive on the parent; entries beyond its freedoms are zero.
using Moments = std::vector<Vector3d>;

/// Linear and angular momentum in the world frame, angular about the world origin.
struct SpatialMomentum {
  Vector3d linear = Vector3d::Zero();   // kg m/s
  Vector3d angular = Vector3d::Zero();  // kg m²/s
};

/// 𝕀(R), [velocity_count][velocity_count], symmetric positive definite (equation 2.4).
MatrixXd generalized_inertia(const model::System& system, const Rotations& rotation);

/// 𝕀(R)⁻¹ μ in time linear in the bodies, without forming 𝕀.
VectorXd velocity_of_momentum(const model::System& system, const Rotations& rotation, const VectorXd& momentum);

/// ξ of bodies' angular velocities [bodies] (rad/s, body frames) and the root's velocity (m/s, world); what joints that
/// lead their child cannot follow is left out.
VectorXd velocity_of_bodies(const model::System& system, const Rotations& rotation, const Vectors& angular_velocity,
                            const Vector3d& linear_velocity);

/// Joint moments as vectors on the parents, parents' frames, [joints] N m: how files show them.
Vectors applied_moments(const model::System& system, const Rotations& rotation, const Moments& moments);

/// Inverse of applied_moments; what a joint's free directions cannot exert is left out.
Moments moments_of_applied(const model::System& system, const Rotations& rotation, const Vectors& applied);

/// Angular velocity of each body, [bodies] rad/s, body frames, from ξ.
Vectors angular_velocities(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// Kinetic energy of bodies and fluid, J; velocity ξ = (rates along the freedoms, ẋ).
double kinetic_energy(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// Kinetic energy and the energy of the joints' springs, J.
double energy(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// 𝕀(R) ξ without forming 𝕀.
VectorXd generalized_momentum(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// Change of 𝕀(R) ξ when the bodies turn along freedoms and ξ keeps its numbers (equation 11.3).
VectorXd generalized_momentum_rate(const model::System& system, const Rotations& rotation, const VectorXd& velocity,
                                   const Freedoms& turn);

/// How fast 1 N m along each column of Joint::actuation makes its joint's rate along it grow, all else free, [control_count] 1/(kg m²).
VectorXd answers_to_moments(const model::System& system, const Rotations& rotation);

/// Generalised force U of the controls and of the joints' springs: u on the parent, −R_cᵀR_p u on the child, none on
/// the position.
VectorXd generalized_force(const model::System& system, const Rotations& rotation, const Moments& control);

/// Momentum map of a generalised momentum μ: p_x and x × p_x + Σ R_i μ_i over the bodies that turn on their own.
SpatialMomentum spatial_momentum(const model::System& system, const Rotations& rotation, const Vector3d& position,
                                 const VectorXd& momentum);

/// Share of the bodies alone (mass and body_inertia, no fluid) in the momentum.
SpatialMomentum momentum_of_bodies(const model::System& system, const Rotations& rotation, const Vector3d& position,
                                   const VectorXd& velocity);

}  // namespace lamprey::mechanics
