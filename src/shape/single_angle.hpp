// A swimmer of a single joint angle that cannot turn right round: without momentum where it is follows from that angle alone
// (scallop theorem), so that what it can reach is a curve.
#pragma once

#include <string>

#include "maneuver/maneuver.hpp"

namespace lamprey::shape {

/// Why no motion meets the goal, in words: the curve, within the angle's limits or half a turn either way, comes near it no
/// further than by a thousandth of what is asked for. Empty where it does, and of swimmers with other joints than one hinge, with
/// momentum, of periodic goals, and where the hinge may turn right round.
std::string beyond_single_angle(const model::System& system, const maneuver::Maneuver& maneuver,
                                const maneuver::Limits& limits);

}  // namespace lamprey::shape
