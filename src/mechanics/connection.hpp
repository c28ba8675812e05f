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

/// A turn and a shift of the root along its own axes: (rad, m), or what a unit of something else makes of them.
using Twist = Eigen::Matrix<double, 6, 1>;

/// What the joints move the root by at `rate`, [joints][3] as above: A ṙ, in time linear in the bodies.
Twist moved_root(const model::System& system, const Rotations& rotation, const Vectors& rate);

/// What a small loop of two motions of the joints moves it by: to second order in its size the parallelogram's (equations 9.29,
/// 9.30). Exact, in time linear in the bodies.
Twist moved_by_loop(const model::System& system, const Rotations& rotation, const Vectors& first,
                    const Vectors& second);

/// The same of all pairs of rates: by a and b the components a·F_k b. Antisymmetric.
struct ConnectionCurvature {
  std::array<MatrixXd, 3> turn;   // [3][f][f] 1
  std::array<MatrixXd, 3> shift;  // [3][f][f] m
};
ConnectionCurvature connection_curvature(const model::System& system, const Rotations& rotation);

/// ξ of the same motion of the joints, the whole moving as its total momentum demands; root's mass centre at `position`.
VectorXd with_momentum(const model::System& system, const Rotations& rotation, const Vector3d& position,
                       const VectorXd& velocity, const SpatialMomentum& total);

/// ξ where the joints turn at `rate`, [joints][3] as above, rad/s, and the whole moves as its total momentum demands
/// (equation 9.32); root's mass centre at `position`.
VectorXd velocity_of_rates(const model::System& system, const Rotations& rotation, const Vector3d& position,
                           const Vectors& rate, const SpatialMomentum& total);

}  // namespace lamprey::mechanics
