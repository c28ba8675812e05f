// Second derivatives of the costs beside effort and time along the chain of the second-order test (chapter 13).
#pragma once

#include "evidence/cost_check.hpp"
#include "optimality/second_order.hpp"

namespace lamprey::optimality {

/// Why a power must not leave 0: the moment must not, or the rate, or neither vanishes by itself. What holds is their product.
enum class Held { no, moment, rate, both };

/// Where powers vanish under a weight of work.
struct Kinks {
  Eigen::Array<Held, Eigen::Dynamic, Eigen::Dynamic> held;   // [drives][N + 1] multipliers are inside of their bounds
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> turns;  // likewise, a power changes its sign over the node
  bool weak = false;                                         // somewhere multipliers are at their bounds as well
  bool known = true;                                         // powers vanish wherever multipliers are inside
};

Kinks kinks_of(const StoredMotion& motion, const evidence::Powers& powers);

/// Whether the moments at a gait's two ends are one number, and a motion of free duration begins at rest, where costs
/// beside effort depend on it.
bool ends_fit_costs(const StoredMotion& motion);

/// Adds the costs' second derivatives (equations 13.14 to 13.16) to a chain whose stages from effort.first on are the nodes'.
/// More states come after those of the chain; `duration` is the one that holds the logarithm of a free time step. Powers
/// that are held are kept by a penalty.
void add_costs(const StoredMotion& motion, const EffortChain& effort, const Kinks& kinks,
               std::optional<Eigen::Index> duration, Chain& chain);

}  // namespace lamprey::optimality
