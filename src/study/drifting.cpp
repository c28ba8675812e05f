#include "study/drifting.hpp"

#include "maneuver/coasting.hpp"

namespace lamprey::study {

namespace {

constexpr double calm_share = 0.5;  // of a guess's swings, beside a momentum that may do the most
constexpr int calm_guesses = 4;     // in all but one of so many

}  // namespace

maneuver::NodePath carried_by_momentum(const model::System& system, const maneuver::Problem& problem,
                                       maneuver::NodePath guess, int start) {
  if (!maneuver::has_momentum(system, problem.start)) return guess;
  const double share = start % calm_guesses < calm_guesses - 1 ? calm_share : 1.0;
  return maneuver::coasting(system, problem, guess, share).value_or(std::move(guess));
}

}  // namespace lamprey::study
