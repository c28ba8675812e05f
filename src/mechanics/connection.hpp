// The local connection: how the root of a swimmer moves as its joints turn, where total momentum is zero.
#pragma once

#include <array>

#include "mechanics/continuous.hpp"

namespace lamprey::mechanics {

/// By the joints' rates (rad/s), joint after joint: of a hinge or universal joint those of its angles about its axes, of a ball joint
/// the components of its child's angular velocity against the parent's, in the parent's frame. f of them.
struct LocalConnection {
  MatrixXd turn;     // [3][f] 1, angular velocity of the root, its own frame
  MatrixXd shift;    // [3][f] m, velocity of its mass centre, its own frame
  MatrixXd inertia;  // [f][f] kg m², M of the kinetic energy ½ ṙᵀMṙ that is left
};

/// At a shape, whatever its attitude in the world (equation 9.28).
LocalConnection local_connection(const model::System& system, const Rotations& rotation);

/// What a small loop of shapes moves the root by: by the parallelogram of two motions of the joints (rates as above, times rad)
/// the components a·F_k b along the root's axes, to second order in its size. Antisymmetric.
struct ConnectionCurvature {
  std::array<MatrixXd, 3> turn;   // [3][f][f] 1
  std::array<MatrixXd, 3> shift;  // [3][f][f] m
};

/// At a shape, exact (equations 9.29, 9.30).
ConnectionCurvature connection_curvature(const model::System& system, const Rotations& rotation);

/// ξ of the same motion of the joints, the whole moving as its total momentum demands; root's mass centre at `position`.
VectorXd with_momentum(const model::System& system, const Rotations& rotation, const Vector3d& position,
                       const VectorXd& velocity, const SpatialMomentum& total);

/// ξ where the joints turn at `rate`, [joints][3] as above, rad/s, and the whole moves as its total momentum demands
/// (equation 9.32); root's mass centre at `position`.
VectorXd velocity_of_rates(const model::System& system, const Rotations& rotation, const Vector3d& position,
                           const Vectors& rate, const SpatialMomentum& total);

}  // namespace lamprey::mechanics
