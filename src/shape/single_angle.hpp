// A swimmer of a single joint angle: without momentum where it is follows from that angle alone, whole turns counted
// (scallop theorem), so that what it can reach is a curve.
#pragma once

#include <string>

#include "maneuver/maneuver.hpp"

namespace lamprey::shape {

/// Why no motion meets the goal, in words: the curve, within limits.angle, comes no nearer to it than by a thousandth of what is
/// asked for; nor, without limits and where it ends in its first shape, by whole turns of the hinge, of which so many `steps` show
/// half as many; from any first shape of a gait that has a free one. Empty where it does, and of swimmers with other joints than one
/// hinge, with momentum, and of periodic goals within limits.
std::string beyond_single_angle(const model::System& system, const maneuver::Maneuver& maneuver,
                                const maneuver::Limits& limits, int steps);

/// model::InputError (cost.displacement, cost.transport) where none of these whole turns meets the goal and wins any displacement.
void refuse_price_of_no_whole_turn(const model::System& system, const maneuver::Maneuver& maneuver,
                                   const maneuver::Limits& limits, int steps);

}  // namespace lamprey::shape
