// What the same minimum costs on finer and coarser grids, and what that says about its cost (equation 6.8).
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "certificate/certificate.hpp"
#include "maneuver/problem.hpp"

namespace lamprey::study {

/// Cost of a minimum carried over to a number of steps; nothing where it is not found there.
using CostOnGrid = std::function<std::optional<double>(int steps)>;

/// Order at which costs of the problem should settle: that of its scheme and of its cost rule.
int expected_order(const maneuver::Problem& problem);

/// Asks for the cost on half and on twice the steps; where these cannot be halved, on twice and four times as many.
certificate::Refinement refine_cost(const maneuver::Problem& problem, double cost, const CostOnGrid& cost_on_grid);

/// The numbers from costs on three grids, each twice as fine as the one before. Where the observed order is not
/// from half the expected one, p, to the larger of 3p/2 and p + 3/2, order, limit and error stay NaN.
certificate::Refinement refinement_of(const std::vector<certificate::GridCost>& grids, int steps, int expected_order);

/// A sentence where there is no error bar on the cost; empty else.
std::string refinement_words(const certificate::Refinement& refinement);

}  // namespace lamprey::study
