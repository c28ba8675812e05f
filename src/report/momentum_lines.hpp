// What the paper says of its figures, checked on a solution and said in sentences.
#pragma once

#include <string>
#include <vector>

#include "result/results.hpp"

namespace lamprey::report {

/// Lines with ✓, ✗ or ·: total momentum zero throughout (for a start at rest); the bodies' mean linear momentum along e₁, by where
/// their mass centres went, against the asked displacement; their mean angular momentum about e₁ against the asked turn.
std::vector<std::string> momentum_lines(const result::Results& results);

/// How the root has turned, rotation vector and angle, where the goal asks for a turn of it; else, or where it has not, "".
std::string asked_turn(const result::Results& results);

/// Whether the swimmer carries total momentum, which moves and turns it without its joints.
bool drifts(const result::Results& results);

}  // namespace lamprey::report
