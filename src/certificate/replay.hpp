// The stored controls through an independent integrator of the continuous equations.
#pragma once

#include "certificate/certificate.hpp"
#include "certificate/stored_motion.hpp"

namespace lamprey::certificate {

/// Replays in windows of about `window` s (a whole number of steps, at least one), restarted from the stored state, and once
/// without restart. Moments run linearly between nodes, or as the spline through its points. What fails stays NaN.
Replay replay(const StoredMotion& motion, double window, double tolerance);

/// Growth of small perturbations, 1/s. With G(t) the largest factor by which a perturbation of the start has grown by t under
/// the linearised step maps, the steepest mean slope of ln G over any 0.1 s (over all if shorter). A perturbation is measured
/// as √(|η|² + |T 𝕀⁻¹δμ|²), all bodies' turns and the turns and shift that its velocity makes over the duration T; the shift of
/// the whole is left out, as it has no effect. Growth in proportion to time, as of any free motion, counts at most 1/(2T).
double growth_rate(const StoredMotion& motion);

}  // namespace lamprey::certificate
