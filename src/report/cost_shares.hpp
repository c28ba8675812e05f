// What each of a cost's terms comes to.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "result/results.hpp"

namespace lamprey::report {

/// Names and shares of the terms that have a weight, in the cost's unit; they add up to the cost. Empty where there is
/// but one.
std::vector<std::pair<std::string, double>> cost_shares(const result::Results& results);

}  // namespace lamprey::report
