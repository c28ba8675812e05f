// The gap between two ellipsoids of a motion, found from a direction that lay between them nearby, or no more of it than is asked
// for.
#pragma once

#include "fluid/gap.hpp"

namespace lamprey::fluid {

/// The gap, m, or a lower bound of it that is more than `enough`. `across` is a direction from the first body to the second: that of a
/// gap nearby, or zero; then the one that this was found along.
double gap_or_enough(const EllipsoidPair& pair, double enough, Eigen::Vector3d& across);

/// The gap itself; `across` likewise.
Gap gap_across(const EllipsoidPair& pair, Eigen::Vector3d& across);

}  // namespace lamprey::fluid
