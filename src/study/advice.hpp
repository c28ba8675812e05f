// What to try where a motion is not the optimal answer, or where its steps are too coarse for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "certificate/certificate.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::study {

/// What to try, as clauses.
using Remedies = std::vector<std::string>;

/// What bears on this motion first.
Remedies advice(const maneuver::Problem& problem, const certificate::Certificate& certificate,
                const maneuver::Solution& solution);

/// What of an optimal answer more steps or smoother moments would mend, as a sentence after a blank. Empty where its replays keep to
/// their marks. `resolving`: the search goes on to more steps by itself.
std::string advice_on_steps(const maneuver::Problem& problem, const certificate::Certificate& certificate,
                            const maneuver::Solution& solution, bool resolving);

/// Where joints could turn all the way round and no first guess has them do so, as a sentence after a blank; empty where it is too
/// few guesses for that, or where what is asked leaves no joint free to.
std::string untried_turns(const model::System& system, const maneuver::Problem& problem);

/// Where the joints do other work within steps than the nodes show, as sentences after a blank. Empty where both agree.
std::string unseen_work(const maneuver::Problem& problem, const certificate::Certificate& certificate,
                        const maneuver::Solution& solution);

/// Which tolerance accepts an answer that is nearly stationary; empty where it is so to the one asked for, or not nearly.
std::string words_on_tolerance(const maneuver::Problem& problem, const certificate::Certificate& proof);

/// On how many steps an optimal answer may be resolved; nothing where it is, or where finer steps do not mend it.
std::optional<int> steps_to_resolve(const maneuver::Problem& problem, const certificate::Certificate& proof,
                                    const maneuver::Solution& solution);

}  // namespace lamprey::study
