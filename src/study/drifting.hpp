// First guesses of swimmers that begin with momentum, for both methods.
#pragma once

#include "maneuver/node_path.hpp"
#include "maneuver/problem.hpp"
#include "model/system.hpp"

namespace lamprey::study {

/// Of a start's first guess the motion of calmer joints and a whole that goes where its momentum takes it; the guess itself where
/// the start carries none or nothing leads through.
maneuver::NodePath carried_by_momentum(const model::System& system, const maneuver::Problem& problem,
                                       maneuver::NodePath guess, int start);

}  // namespace lamprey::study
