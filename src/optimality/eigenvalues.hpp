// What the eigenvalues of a chain's form say of second order (chapter 6).
#pragma once

#include <optional>

#include "optimality/chain.hpp"
#include "optimality/curvature.hpp"

namespace lamprey::optimality {

inline constexpr double penalty_per_cost = 1e4;  // of a chain's end rows

/// Of a chain whose effort is `cost`, (N m)² s. `phase`: of a gait that may begin anywhere along itself, the direction of that, which is
/// set aside where it is flat. Nothing where they cannot be told.
std::optional<SecondOrder> eigenvalues_of(const Chain& chain, double cost, const std::optional<Inputs>& phase);

}  // namespace lamprey::optimality
