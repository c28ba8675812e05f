// What becomes of a motion's energy.
#pragma once

#include <optional>

#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

/// J, of a swimmer's bodies and the fluid along the nodes.
struct EnergyBalance {
  double first, last, least, most;
  double
      unworked;  // largest part at any node that the joints' moments have not worked since the start, by the trapezoid rule

  /// Whether that is too much for steps that resolve the motion: a tenth of the largest energy.
  bool off() const { return unworked > 0.1 * most; }
};

/// Nothing where a node has no velocities or moments.
std::optional<EnergyBalance> energy_balance(const model::System& system, const Solution& solution);

}  // namespace lamprey::maneuver
