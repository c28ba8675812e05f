// First guesses of motions that begin with momentum.
#pragma once

#include <optional>

#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"

namespace lamprey::guess {

using maneuver::NodePath;
using maneuver::Problem;

/// The motion whose joints leave their straight way by a share of what the guess has, those that nothing drives following, of a whole that
/// goes where its momentum takes it; its moments, too. Where no motion leads through by a half of the share, a quarter or an eighth; nothing
/// where these lead nowhere either, or steps of the scheme follow no angles.
std::optional<NodePath> coasting(const model::System& system, const Problem& problem, const NodePath& guess,
                                 double share);

}  // namespace lamprey::guess
