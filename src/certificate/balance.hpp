// Does the stored motion obey the discrete laws: balance of momentum at each node, conservation, rotations that are
// ones.
#pragma once

#include "certificate/stored_motion.hpp"

namespace lamprey::certificate {

/// Momenta in units of `scale`, the largest |p⁻_i|, |p_x| or h|U_i| over all steps (equation 6.1), 3-vectors by
/// Euclidean norm.
struct Balance {
  double scale = 0.0;           // kg m²/s
  double momentum_drift = 0.0;  // largest |p − p_0|, linear or angular about the origin; p_0 of the problem's start
  double equation_residual = 0.0;  // largest residual of (4.4), and of (4.5) at the start and, with rest, at the end
  double end_momentum = 0.0;       // largest |μ_N|
  double rotation_drift = 0.0;     // largest entry of |RᵀR − I|, no unit
};

Balance check_balance(const StoredMotion& motion);

}  // namespace lamprey::certificate
