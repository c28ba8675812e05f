// Where along itself a gait begins: a direction in which its cost does not change where nothing else tells one moment of it from
// another (chapter 6).
#pragma once

#include <optional>

#include "optimality/effort_chain.hpp"

namespace lamprey::optimality {

/// The start a little later along the gait, as inputs of the effort's chain (equation 6.29): differences of neighbouring nodes
/// over the seam. Nothing where the first shape is given, where the motion does not change along itself, or where the same gait begun
/// a step later is no answer at the same cost.
std::optional<Inputs> phase_direction(const StoredMotion& motion, const EffortChain& effort);

}  // namespace lamprey::optimality
