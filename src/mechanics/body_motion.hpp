// How all bodies move at a velocity ξ, and their momenta (chapter 2).
#pragma once

#include "mechanics/tree_elimination.hpp"

namespace lamprey::mechanics {

/// Motion of all bodies at a velocity ξ.
struct BodyMotion {
  Freedoms freedoms;  // [bodies] rates along them, rad/s
  Vectors turn;       // [bodies] Ω_i, rad/s, body frames
  Vectors velocity;   // [bodies] of the mass centres, m/s, world
};

BodyMotion body_motion(const model::System& system, const Rotations& rotation, const VectorXd& velocity);
/// The same into a motion of that many bodies.
void find_motion(const model::System& system, const Rotations& rotation, const VectorXd& velocity, BodyMotion& motion);

/// Momentum of a body with its fluid, body frame.
struct BodyMomentum {
  Vector3d linear;   // N s
  Vector3d angular;  // N m s, about the mass centre
};

/// At the velocity V of the mass centre and Ω, body frame.
BodyMomentum body_momentum(const model::Body& body, const Vector3d& V, const Vector3d& Omega);

/// Blocks of 𝕀, [bodies].
void find_inertia_blocks(const model::System& system, const Rotations& rotation, std::vector<BodyBlock>& blocks);

/// World vector of each mass centre from one for the root and terms R_i f_i(d) that a joint's offsets add.
template <typename Term>
void spread(const model::System& system, const Rotations& R, const Vector3d& root, const Term& term, Vectors& result) {
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent < 0) {
      result[model::at(i)] = root;
      continue;
    }
    const model::Joint& up = system.joint(body.joint);
    result[model::at(i)] = result[model::at(up.parent)] + R[model::at(up.parent)] * term(up.parent, up.parent_offset) -
                           R[model::at(i)] * term(i, up.child_offset);
  }
}

}  // namespace lamprey::mechanics
