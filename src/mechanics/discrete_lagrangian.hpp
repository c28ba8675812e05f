// Discrete Lagrangians L_d(g_k, g_{k+1}) and their momenta, evaluated leaves to root in time linear in the bodies (chapters 3, 4).
#pragma once

#include <vector>

#include "mechanics/body_lagrangian.hpp"
#include "mechanics/continuous.hpp"
#include "mechanics/four_bodies.hpp"

namespace lamprey::mechanics {

/// Motion over one step, from node k to node k + 1.
struct Interval {
  // set by the caller
  Rotations rotation;     // [bodies] R_i at k
  Vectors cayley;         // [bodies] ζ_i: F_i = cayley(ζ_i); of a body that its joint leads: computed
  Freedoms joint_turn;    // [bodies] rad, change of the joint's angles, for bodies that their joints lead
  Vector3d displacement;  // m, of the root's mass centre, world
  // computed by update_interval
  Rotations relative_rotation;                 // [bodies] F_i = R_{i,k}ᵀ R_{i,k+1}
  Rotations relative_rotation_minus_identity;  // [bodies] F_i − I, without cancellation
  Rotations next_rotation;                     // [bodies] R_i at k + 1
  Vectors centre_displacement;                 // [bodies] m, of each mass centre, world

  explicit Interval(int bodies);
};

/// Fills the computed fields from the caller's (equation 4.1).
void update_interval(const model::System& system, Interval& interval);

/// Fills all fields from the rotations at both nodes and the root's displacement.
void interval_between(const model::System& system, const Rotations& rotation, const Rotations& next_rotation,
                      const Vector3d& displacement, Interval& interval);

/// p⁻ = −D_1 L_d, p⁺ = D_2 L_d: along the freedoms for rotations, world for the position, whose two are equal.
struct DiscreteMomenta {
  Freedoms minus;          // [bodies] kg m²/s, along the freedoms at k
  Freedoms plus;           // [bodies] kg m²/s, along the freedoms at k + 1
  Vector3d linear;         // kg m/s, p_x, world
  Vectors subtree_linear;  // [bodies] kg m/s, linear momentum of the subtree of each body, world
  // on the way there
  Vectors shift;        // [bodies] m, w_i: displacement of the mass centre, body frame at k
  Vectors turn;         // [bodies] kg m²/s, γ_i = π⁺_i, body frame at k + 1
  Vectors impulse;      // [bodies] kg m/s, β_i = R_iᵀ P_i, body frame at k
  Vectors own_minus;    // [bodies] kg m²/s, π⁻_i = F_i γ_i + w_i × β_i, body frame at k
  Vectors joint_minus;  // [bodies] kg m²/s, angular momentum through the joint at k, body frame
  Vectors joint_plus;   // [bodies] kg m²/s, the same at k + 1

  explicit DiscreteMomenta(int bodies);
};

/// L_d over a step, J s.
double discrete_lagrangian(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                           const Interval& interval);

/// p⁻ and p⁺ (equations 4.3, 8.13), linear in the number of bodies, no allocation.
void discrete_momenta(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                      const Interval& interval, DiscreteMomenta& momenta);

/// The bodies' own shares and their sums over subtrees: shift, turn, impulse, own_minus, subtree_linear and linear.
void body_momenta(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                  const Interval& interval, DiscreteMomenta& momenta);

/// The part of discrete_momenta that p⁻ needs.
void momenta_at_beginning(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                          const Interval& interval, DiscreteMomenta& momenta);

/// The rest of it: p⁺, after momenta_at_beginning.
void momenta_at_end(const model::System& system, const Interval& interval, DiscreteMomenta& momenta);

/// Whether the shares of all bodies are plain: formulas of four bodies at once serve then.
bool all_plain(const model::System& system, DiscreteLagrangian lagrangian);

/// What the shares of four bodies are made of.
struct FourShares {
  FourShares(const model::System& system, DiscreteLagrangian lagrangian, double time_step, const Interval& interval,
             const FourBodies& bodies);
  PlainShare<Four33, Four3> with_shift(const Four3& w) const {
    return {mass, trace_weight, weights.left, weights.right, rate, F, w};
  }
  Four33 mass, trace_weight, R, F;
  Quadrature weights;
  double rate;  // 1/h
};

/// What body i does in a step.
BodyStep body_step(const Interval& interval, const DiscreteMomenta& momenta, int body);

}  // namespace lamprey::mechanics
