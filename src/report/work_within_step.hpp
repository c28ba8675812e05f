// The work of a joint within a step whose moments the files tell at its stages: those of schemes above order 2, whose steps are long.
#pragma once

#include <optional>

#include "result/results.hpp"

namespace lamprey::report {

/// Whether moments and the joint's rates are known on the way through the steps.
bool tells_stages(const result::Results& results);

/// J, ∫ |u·ω| dt over step k of what a joint's moment does, or, of a universal joint's, that along one of its axes: the moment as the
/// polynomial that the scheme has within a step, the rate as the parabola with the rates at both nodes that turns the joint as far.
double work_within_step(const result::Results& results, std::size_t k, std::size_t joint, std::optional<int> axis);

}  // namespace lamprey::report
