// An answer is a solution with its certificate; the certificate has the last word on the status.
#pragma once

#include "certificate/certificate.hpp"
#include "maneuver/failure.hpp"
#include "search/solve.hpp"

namespace lamprey::study {

struct Answer {
  maneuver::Solution solution;
  certificate::Certificate certificate;
  std::vector<Answer> others = {};  // of other minima, where more than one is to be kept
  maneuver::Failure failure = {};   // what its message begins with, in parts, where it is not optimal
};

/// Solves and certifies every candidate; status and message say what the certificate shows. Of the proven candidates the cheapest
/// one that its steps resolve is the answer: coarse grids hold motions that cost little only because they are wrong.
/// An optimal answer comes with what second derivatives say, its cost on other grids where these are asked for, and gains about it.
/// Where more minima are to be kept (search.keep) the next ones by the same order are answers, too, all but their costs on other grids.
/// Time limit and interruption hold for these too: what has not begun by then is left out, and the message says so; an answer
/// that was interrupted before it had all of them has status interrupted. One candidate at least is always certified.
Answer answer(const model::System& system, const maneuver::Problem& problem, const search::SolveOptions& options);

/// That a cheaper answer may be found, as a sentence after a blank: where few first guesses arrived, where half of them ended where no
/// other did, or where the cheapest on the coarse grid became dear on all steps, unless a cheaper motion is known on these; else empty.
std::string on_cheaper_ones(const maneuver::Solution& solution, bool cheaper_known = false);

}  // namespace lamprey::study
