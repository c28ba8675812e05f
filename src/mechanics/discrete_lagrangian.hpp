// Discrete Lagrangians L_d(g_k, g_{k+1}) and their momenta, evaluated leaves to root in time linear in the bodies (chapters 3, 4).
#pragma once

#include <vector>

#include "lie/so3.hpp"
#include "mechanics/continuous.hpp"

namespace lamprey::mechanics {

/// paper: left-rectangle with the paper's trace form, order 1. trapezoid: symmetric, order 2.
enum class DiscreteLagrangian { paper, trapezoid };

/// What a discrete Lagrangian weighs: the orientation of M at the left and the right node, and the paper's trace form.
struct Quadrature {
  double left;      // κ at k
  double right;     // κ at k + 1
  bool trace_form;  // the d_ip–d_ip part by a trace with J' = J − d̂ M d̂ (paper, equations 12 and 14)
};

Quadrature quadrature(DiscreteLagrangian lagrangian);

/// Motion over one step, from node k to node k + 1.
struct Interval {
  // set by the caller
  Rotations rotation;            // [bodies] R_i at k
  std::vector<Vector3d> cayley;  // [bodies] ζ_i: F_i = cayley(ζ_i)
  Vector3d displacement;         // m, of the root's mass centre, world
  // computed by update_interval
  Rotations relative_rotation;                             // [bodies] F_i = R_{i,k}ᵀ R_{i,k+1}
  std::vector<Matrix3d> relative_rotation_minus_identity;  // [bodies] F_i − I, without cancellation
  Rotations next_rotation;                                 // [bodies] R_i at k + 1
  std::vector<Vector3d> centre_displacement;               // [bodies] m, of each mass centre, world

  explicit Interval(int bodies);
};

/// Fills the computed fields from the caller's.
void update_interval(const model::System& system, Interval& interval);

/// p⁻ = −D_1 L_d, p⁺ = D_2 L_d: body-side for rotations, world for the position, whose two are equal.
struct DiscreteMomenta {
  std::vector<Vector3d> minus;           // [bodies] kg m²/s, body frames at k
  std::vector<Vector3d> plus;            // [bodies] kg m²/s, body frames at k + 1
  Vector3d linear;                       // kg m/s, p_x, world
  std::vector<Vector3d> subtree_linear;  // [bodies] kg m/s, linear momentum of the subtree of each body, world

  explicit DiscreteMomenta(int bodies);
};

/// L_d over a step, J s.
double discrete_lagrangian(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                           const Interval& interval);

/// p⁻ and p⁺ (equation 4.3), linear in the number of bodies, no allocation.
void discrete_momenta(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                      const Interval& interval, DiscreteMomenta& momenta);

/// J_d = ½ tr(J) I − J: what the rotational trace term tr[(I − F) J_d] weighs.
inline Matrix3d trace_weight(const Matrix3d& J) { return 0.5 * J.trace() * Matrix3d::Identity() - J; }

/// The inertia matrix in the rotational trace term: J, or J' = J − d̂ M d̂ of a non-root body with the paper's trace form.
Matrix3d trace_inertia(const model::System& system, const Quadrature& weights, int body);

}  // namespace lamprey::mechanics
