// First guesses: random smooth shape motions, and the finer grid of a coarser answer.
#pragma once

#include <cstdint>

#include "maneuver/transcription.hpp"

namespace lamprey::maneuver {

struct GuessOptions {
  double amplitude = 0.8;      // rad, of the random shape motion
  bool root_floats = true;     // the root moves as total momentum asks; otherwise straight to its goal
};

/// A motion whose joints swing at random between start and end shape; the same for the same seed on every machine.
NodePath random_guess(const model::System& system, const Maneuver& maneuver, std::uint64_t seed,
                      const GuessOptions& options);

/// The motion at `steps` times the resolution: turns split along their geodesics, controls linear in between.
NodePath refined(const model::System& system, const NodePath& coarse, int steps);

}  // namespace lamprey::maneuver
