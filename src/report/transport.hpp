// What a motion's joints do along the way, and what that is for each metre.
#pragma once

#include <optional>

#include "result/results.hpp"

namespace lamprey::report {

struct Transport {
  double work;      // J, ∫ Σ |u·ω| dt over the joints: nothing is won back
  double distance;  // m, of the root's mass centre from start to end
};

/// Whether a distance is asked for, by the goal or by a cost.
bool distance_asked(const result::ResolvedProblem& problem);

/// Whether work per distance says something: a distance is asked for, by the goal or by a cost, or the way is at least
/// a tenth of the swimmer's size.
bool goes_a_way(const result::Results& results);

/// By joint_demands' work. Nothing where there is no motion.
std::optional<Transport> transport(const result::Results& results);

}  // namespace lamprey::report
