// A swimmer of a single joint angle within limits: without momentum where it is follows from that angle alone
// (scallop theorem), so that what it can reach is a curve.
#pragma once

#include <string>

#include "maneuver/maneuver.hpp"

namespace lamprey::shape {

/// Why no motion meets the goal, in words: the curve, within limits.angle, comes no nearer to it than by a thousandth of what is
/// asked for. Empty where it does, and of swimmers with other joints than one hinge, with momentum, of periodic goals, and where
/// no limit holds the hinge: beyond half a turn it gets elsewhere.
std::string beyond_single_angle(const model::System& system, const maneuver::Maneuver& maneuver,
                                const maneuver::Limits& limits);

}  // namespace lamprey::shape
