#include "mechanics/body_motion.hpp"

namespace lamprey::mechanics {

using model::at;
using model::Body;
using model::System;

void find_motion(const System& system, const Rotations& R, const VectorXd& velocity, BodyMotion& motion) {
  unpack(system, velocity, motion.freedoms);
  body_turns(system, R, motion.freedoms, motion.turn);
  spread(
      system, R, velocity.tail<3>(),
      [&](int i, const Vector3d& offset) { return Vector3d(motion.turn[at(i)].cross(offset)); }, motion.velocity);
}

BodyMotion body_motion(const System& system, const Rotations& R, const VectorXd& velocity) {
  const std::size_t bodies = at(system.body_count());
  BodyMotion motion{Freedoms(bodies), Vectors(bodies), Vectors(bodies)};
  find_motion(system, R, velocity, motion);
  return motion;
}

BodyMomentum body_momentum(const Body& body, const Vector3d& V, const Vector3d& Omega) {
  return {body.mass_matrix * V + body.coupling_matrix * Omega,
          body.inertia_matrix * Omega + body.coupling_matrix.transpose() * V};
}

void find_inertia_blocks(const System& system, const Rotations& R, std::vector<BodyBlock>& blocks) {
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Matrix3d by_turn = R[at(i)] * body.coupling_matrix;
    blocks[at(i)] = {body.inertia_matrix, by_turn.transpose(), by_turn,
                     R[at(i)] * body.mass_matrix * R[at(i)].transpose()};
  }
}

}  // namespace lamprey::mechanics
