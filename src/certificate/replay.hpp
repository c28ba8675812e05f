// The stored controls through an independent integrator of the continuous equations.
#pragma once

#include <functional>

#include "certificate/certificate.hpp"
#include "evidence/stage_motion.hpp"
#include "evidence/stored_motion.hpp"

namespace lamprey::certificate {

using evidence::StageMotion;
using evidence::StoredMotion;

struct ReplayOptions {
  double tolerance;                 // of a step of the reference integrator
  std::function<bool()> stopped{};  // ends it between two nodes; empty: nothing does
};

/// Replays in windows, restarted from the stored state, and once without restart. A window is a twentieth of the duration or, if
/// that is shorter, what small perturbations take to grow by e² (a whole number of steps, at least one). Moments run linearly
/// between nodes, or as the spline through its points. What fails stays NaN. Last its joints are led along its angles.
Replay replay(const StoredMotion& motion, const ReplayOptions& options);

/// The whole of it once more with the stored gains: moments answer how far the replay is off the stored motion. Fills the
/// two `feedback_…` errors; they stay NaN where no gains are stored.
void replay_with_feedback(const StoredMotion& motion, const ReplayOptions& options, Replay& result);

/// The same of a motion above order 2: the moments are the polynomials of its steps.
void replay_with_feedback(const StoredMotion& motion, const StageMotion& stages, const ReplayOptions& options,
                          Replay& result);
Replay replay(const StoredMotion& motion, const StageMotion& stages, const ReplayOptions& options);

/// Growth of small perturbations, 1/s. With G(t) the largest factor by which turns η of the bodies at the start have
/// grown by t under the linearised step maps (largest singular value of dη(t)/dη(0) at given μ, body side, moments as
/// stored): the steepest mean slope of ln G over any quarter of the duration. Shorter transients count less; growth in
/// proportion to time dies out.
double growth_rate(const StoredMotion& motion);

/// The same over the stages of a motion above order 2.
double growth_rate(const StoredMotion& motion, const StageMotion& stages);

}  // namespace lamprey::certificate
