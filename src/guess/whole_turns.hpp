// First guesses whose joints turn all the way round: a swimmer at rest turns against them, the further the more turns they make.
#pragma once

#include <optional>

#include "guess/guess.hpp"
#include "maneuver/end_rows.hpp"
#include "maneuver/random.hpp"

namespace lamprey::guess {

using maneuver::EndRow;
using maneuver::Random;
using maneuver::ShapeCoordinates;

/// Joints that moments turn and that `may_turn_round`.
std::vector<int> joints_that_turn_round(const model::System& system, const Problem& problem);

/// Turns of these joints, drawn at random among those that turn the swimmer by about this share of the turn that the goal asks for, as
/// what each joint does by itself foretells, at most `most` of any joint; towards goals without a turn some by one to either side.
/// Nothing where those drawn lead too far astray.
std::optional<WholeTurns> whole_turns_to_goal(const model::System& system, const Maneuver& maneuver,
                                              const ShapeCoordinates& coordinates, const std::vector<EndRow>& rows,
                                              const std::vector<int>& joints, double share_of_way, int most,
                                              Random& random);

}  // namespace lamprey::guess
