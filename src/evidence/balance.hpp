// Does the stored motion obey the discrete laws: balance of momentum at each node, conservation, rotations that are
// ones.
#pragma once

#include "evidence/findings.hpp"
#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// Momenta in units of `scale`, the largest |p⁻_i|, |p_x| or h|U_i| over all steps (equation 6.1), by Euclidean norm of
/// each body's freedoms, linear ones by the swimmer's unit of length. Where steps are not known (StoredMotion::steps_known) the momenta are those of the stored
/// velocities at the nodes, and what only the steps tell stays NaN.
struct Balance {
  double scale = 0.0;  // kg m²/s; where nothing moves that of what digits could tell
  double momentum_drift =
      0.0;  // largest |p − p_0|, linear or angular about where the problem starts; p_0 of the problem's start
  double equation_residual = unset;  // largest residual of (4.4), and of (4.5) at the start and, with rest, at the end
  double end_momentum = unset;       // largest |μ_N|
  double round_off = 0.0;            // what stored digits leave of a step's momenta (equation 6.22), of the scale
  double moment_round_off = 0.0;     // what they leave of the moments that the steps ask for, of the largest one stored
  double rotation_drift = 0.0;       // largest entry of |RᵀR − I|, |det R − 1|, no unit
};

/// Largest part of a generalised momentum: a body's freedoms or the position's by the unit of length, by Euclidean norm, kg m²/s.
double largest_part(const model::System& system, const VectorXd& v);

Balance check_balance(const StoredMotion& motion);

/// Largest difference of the stored velocities and momenta from those of the states at the nodes, [N + 1], each kind
/// relative to its largest; of momenta at least `momentum_scale`, since the whole's may be none. Infinite where nodes lack one.
double velocity_error(const StoredMotion& motion, const std::vector<integrator::State>& states, double momentum_scale);

}  // namespace lamprey::evidence
