// Swimmers that begin in motion: first guesses for both methods, and goals that they get to by themselves.
#pragma once

#include <functional>
#include <optional>

#include "maneuver/node_path.hpp"
#include "maneuver/problem.hpp"
#include "model/system.hpp"
#include "search/found.hpp"

namespace lamprey::search {

/// Of a start's first guess the motion of calmer joints and a whole that goes where its momentum takes it; the guess itself where
/// the start carries none or nothing leads through.
maneuver::NodePath carried_by_momentum(const model::System& system, const maneuver::Problem& problem,
                                       maneuver::NodePath guess, int start);

/// The motion without any moments of a start in motion, by a scheme of one stage, in the maneuver's duration; of gaits nothing, nor
/// where it is `stopped`, which is asked at every step and may be empty.
std::optional<Found> coasting(const model::System& system, const maneuver::Problem& problem,
                              const maneuver::Maneuver& maneuver, const std::function<bool()>& stopped);

/// The same where it meets the goal of a maneuver of the problem within its limits and costs nothing but time, so that none costs less:
/// an outcome that has converged. In a free duration that is the least one or, where time costs nothing, any in which the goal is met.
/// Nothing elsewhere, and with waypoints, a worth of displacement and a weight of angular velocity.
std::optional<Found> coasting_to_goal(const model::System& system, const maneuver::Problem& problem,
                                      const maneuver::Maneuver& maneuver, const std::function<bool()>& stopped);

}  // namespace lamprey::search
