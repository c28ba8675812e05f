// Where a motion leads if its joints are led along its angles, whatever moments that takes.
#pragma once

#include "certificate/certificate.hpp"
#include "evidence/stored_motion.hpp"

namespace lamprey::certificate {

using evidence::StoredMotion;

/// The joints go through the stored nodes along cubic splines of their turns; the root goes as the total momentum at the start
/// demands, with no trace of the steps' own rule (equations 9.32 and 6.8). Fills the two `servo_…` errors, those at the end; they stay
/// NaN where a freedom of a joint moves that nothing drives, which servos could not lead, and where there are fewer than three steps.
void replay_with_servos(const StoredMotion& motion, Replay& result);

}  // namespace lamprey::certificate
