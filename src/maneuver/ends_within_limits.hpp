// Whether the start and the goal of a maneuver are within its limits, as far as they are known.
#pragma once

#include <optional>

#include "maneuver/limit_rows.hpp"
#include "maneuver/maneuver.hpp"

namespace lamprey::maneuver {

/// A limit that an end breaks.
struct BrokenLimit {
  const LimitRow* row;
  double excess;  // in the limit's unit, row->unit_name()
};

/// The first limit of shape or place that the start breaks beyond round-off.
std::optional<BrokenLimit> broken_by_start(const model::System& system, const Maneuver& maneuver,
                                           const std::vector<LimitRow>& rows);

/// The same of the goal; what depends on attitudes or coordinates that the goal leaves free counts as kept.
std::optional<BrokenLimit> broken_by_goal(const model::System& system, const Maneuver& maneuver,
                                          const std::vector<LimitRow>& rows);

}  // namespace lamprey::maneuver
