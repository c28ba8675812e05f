// Marching a problem's swimmer under given moments.
#pragma once

#include <functional>

#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "mechanics/continuous.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

using ControlFunction = std::function<mechanics::Moments(double)>;  // s → N m, [joints]

/// No moments at any time.
ControlFunction no_control(const model::System& system);

/// Marches from the problem's start by its scheme, duration and steps. Moments act within the joints' actuated directions only.
/// Where a step does not converge the march ends there: status stalled, the message names step, time and residual, and the
/// arrays hold the nodes before it. `interrupted` is asked at every step.
Solution simulate(const model::System& system, const Problem& problem, const ControlFunction& control,
                  const std::function<bool()>& interrupted);

}  // namespace lamprey::maneuver
