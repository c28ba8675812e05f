// An answer is a solution with its certificate; the certificate has the last word on the status.
#pragma once

#include "certificate/certificate.hpp"
#include "study/solve.hpp"

namespace lamprey::study {

struct Answer {
  maneuver::Solution solution;
  certificate::Certificate certificate;
};

/// Solves and certifies every candidate; status and message say what the certificate shows. Of the proven candidates the cheapest
/// one that its steps resolve is the answer: coarse grids hold motions that cost little only because they are wrong.
/// An optimal answer comes with what second derivatives say, its cost on other grids where these are asked for, and gains about it.
/// Time limit and interruption hold for these too: what has not begun by then is left out, and the message says so; an answer
/// that was interrupted before it had all of them has status interrupted. One candidate at least is always certified.
Answer answer(const model::System& system, const maneuver::Problem& problem, const SolveOptions& options);

/// Sets status and message from the numbers of the certificate: "optimal" needs the discrete equations, the goal, rest and the
/// KKT residual to hold, whatever the optimiser thought.
void judge(const maneuver::Problem& problem, const certificate::Certificate& certificate, maneuver::Solution& solution);

/// What keeps a motion from being an optimal answer to the problem, as a clause without advice; empty where nothing does.
std::string fault(const maneuver::Problem& problem, const certificate::Certificate& certificate);

/// The same of a simulated motion, which seeks no goal: status simulated where its numbers fit each other and the mechanics as
/// far as the certificate can tell, else stalled with the reason as message.
void judge_march(const certificate::Certificate& certificate, maneuver::Solution& solution);

}  // namespace lamprey::study
