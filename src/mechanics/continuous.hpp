// The continuous laws: energy, generalised momentum, forces and the equations of motion 𝕀(R) ξ̇ + bias = U (chapter 2).
// Generalised vectors have one layout: three entries for each body's rotation (body frame), then three for the root's position (world).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/system.hpp"

namespace lamprey::mechanics {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Rotations = std::vector<Matrix3d>;  // [bodies] body → world
using Moments = std::vector<Vector3d>;    // [joints] N m, on the parent, parent's frame

/// Linear and angular momentum in the world frame, angular about the world origin.
struct SpatialMomentum {
  Vector3d linear = Vector3d::Zero();   // kg m/s
  Vector3d angular = Vector3d::Zero();  // kg m²/s
};

/// 𝕀(R), [3n+3][3n+3], symmetric positive definite (equation 2.4).
MatrixXd generalized_inertia(const model::System& system, const Rotations& rotation);

/// Kinetic energy of bodies and fluid, J; velocity ξ = (Ω_0, …, Ω_{n−1}, ẋ).
double kinetic_energy(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// 𝕀(R) ξ without forming 𝕀.
VectorXd generalized_momentum(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// Velocity-dependent part of the equations of motion: 𝕀 ξ̇ + bias = U.
VectorXd bias(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// Generalised force U of joint moments: u on the parent, −R_cᵀR_p u on the child, none on the position.
VectorXd generalized_force(const model::System& system, const Rotations& rotation, const Moments& control);

/// ξ̇ = 𝕀⁻¹ (U − bias).
VectorXd acceleration(const model::System& system, const Rotations& rotation, const VectorXd& velocity,
                      const Moments& control);

/// Momentum map of a generalised momentum μ: p_x and x × p_x + Σ R_i μ_i.
SpatialMomentum spatial_momentum(const Rotations& rotation, const Vector3d& position, const VectorXd& momentum);

/// Share of the bodies alone (mass and body_inertia, no fluid) in the momentum.
SpatialMomentum momentum_of_bodies(const model::System& system, const Rotations& rotation, const Vector3d& position,
                                   const VectorXd& velocity);

}  // namespace lamprey::mechanics
