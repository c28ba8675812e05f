// Moments and joint angles between the times at which files hold them.
#pragma once

#include "guess/angle_march.hpp"
#include "maneuver/simulate.hpp"
#include "model/system.hpp"
#include "result/angles_file.hpp"
#include "result/controls_file.hpp"

namespace lamprey::result {

/// Moments as ControlSource says they run.
maneuver::ControlFunction control_function(const ControlSamples& samples, const model::System& system);

/// Joint angles by a not-a-knot cubic, and their rates.
guess::JointAngles angle_function(const AngleSamples& samples);

}  // namespace lamprey::result
