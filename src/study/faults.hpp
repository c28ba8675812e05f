// What keeps a motion from being the answer to a problem, as clauses and sentences made of its numbers.
#pragma once

#include <string>

#include "certificate/certificate.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::study {

/// What shows that files do not tell of the problem's own motion; empty where nothing does.
std::string foreign(const certificate::Certificate& certificate);

/// What keeps the answer from being feasible; empty where nothing does.
std::string unmet(const maneuver::Problem& problem, const certificate::Certificate& certificate);

/// How far it is from that: the largest of what the goal and the limits (rad, m, or of a bound) and the rest (of the momentum's
/// scale) are missed by; 0 where nothing is, infinite where there is no motion to tell.
double missed_by(const maneuver::Problem& problem, const certificate::Certificate& certificate);

/// What keeps a feasible answer from being optimal.
std::string unsettled(const maneuver::Problem& problem, const certificate::Certificate& certificate);

/// The first of the three that there is, as a clause without advice; empty where the motion is an optimal answer.
std::string fault(const maneuver::Problem& problem, const certificate::Certificate& certificate);

/// Whether stages of a scheme above order 2 do not follow from the moments.
bool too_long_for_stages(const maneuver::Problem& problem, const certificate::Certificate& certificate);

/// Where a body turns by nearly a quarter turn or more in a step, as a sentence after a blank: beyond it momentum falls as the
/// turn grows, and half a turn carries none. Empty where none does.
std::string far_turn(const maneuver::Problem& problem, const maneuver::Solution& solution);

/// Where the root keeps to one axis and arrives turned by whole turns more or less than asked, as a sentence after a blank; else empty.
std::string way_round(const maneuver::Problem& problem, const maneuver::Solution& solution);

/// Where joints end whole turns beside the angles that the goal asks for, a sentence for each of these after a blank; else empty. A goal
/// counts no whole turns. Of ball joints nothing is said.
std::string ways_of_joints(const maneuver::Problem& problem, const maneuver::Solution& solution);

/// Where a search for the least work per distance faded towards rest, as a sentence after a blank: small gaits move by the square
/// of their size and work by it too, so that it may, whether the smallest gaits are the cheapest or not. Empty where it did not.
std::string fading(const maneuver::Problem& problem, const maneuver::Solution& solution);

/// Where a sprung joint stands at half a turn, as a sentence after a blank: a spring's moment is along the joint's turn and jumps
/// there, and a search can end there, stationary on neither side. Empty where none does.
std::string spring_at_its_jump(const maneuver::Problem& problem, const maneuver::Solution& solution);

/// What shows that the steps are too coarse for the motion: far turns, or an independent integrator that does not stay with
/// it between restarts. Empty where neither does.
std::string unresolved(const maneuver::Problem& problem, const maneuver::Solution& solution,
                       const certificate::Certificate& certificate);

}  // namespace lamprey::study
