// Outcomes as plain numbers, for the way from worker to parent.
#pragma once

#include <vector>

#include "optimizer/outcome.hpp"

namespace lamprey::search {

/// All of an outcome.
std::vector<double> numbers_of(const optimizer::Outcome& outcome);
optimizer::Outcome outcome_of(const std::vector<double>& numbers);

}  // namespace lamprey::search
