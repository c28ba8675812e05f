// First guesses of many strokes: joints that swing to and fro, each in its phase, so that zero momentum carries the swimmer to
// its goal. Goals beyond what one stroke within limits reaches are found from these.
#pragma once

#include <cstdint>

#include "guess/guess.hpp"
#include "maneuver/end_rows.hpp"

namespace lamprey::guess {

using maneuver::EndRow;
using maneuver::ShapeCoordinates;

struct Strokes {
  NodePath path;        // empty: no motion was found
  double missed = 0.0;  // units of the end rows: sum of what they miss
};

/// rad, what strokes keep to in each joint.
struct StrokeLimits {
  std::vector<double> swing;      // [joints] largest turn to either side
  std::vector<double> amplitude;  // [joints] largest amplitude of a sine
};

/// None.
StrokeLimits no_stroke_limits(const model::System& system);

/// What a problem's limits on angles and angular velocities of joints leave to so many strokes in a duration, s; at most nearly a quarter turn,
/// beyond which they win no more.
StrokeLimits stroke_limits(const model::System& system, const Problem& problem, const integrator::State& start,
                           double duration, int strokes);

/// So many equal strokes, the smallest near random ones that arrive, beside whole turns of joints if any: by Gauss and Newton on
/// amplitudes and phases of the joints. The same for the same seed on every machine. For starts without total momentum that do not ask
/// for a period.
Strokes strokes_to_goal(const model::System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
                        const std::vector<EndRow>& rows, const StrokeLimits& limits, int strokes, std::uint64_t seed,
                        const WholeTurns& turns = {});

}  // namespace lamprey::guess
