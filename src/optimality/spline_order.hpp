// The second-order test for moments on splines: few numbers, each of which acts along the whole motion (chapter 6).
#pragma once

#include "optimality/curvature.hpp"
#include "optimality/effort_chain.hpp"

namespace lamprey::optimality {

/// For moments on natural splines from a given start, at a stationary motion that meets its goal. Nothing where it cannot
/// be told.
std::optional<SecondOrder> second_order_on_splines(const StoredMotion& motion, EffortChain effort);

}  // namespace lamprey::optimality
