// The schemes a problem may name.
#pragma once

#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::integrator {

enum class Scheme { paper, trapezoid, midpoint, order4, order6 };

/// Whether this version can march with the scheme.
inline bool supported(Scheme scheme) { return scheme == Scheme::paper || scheme == Scheme::trapezoid; }

/// The discrete Lagrangian behind a supported scheme.
inline mechanics::DiscreteLagrangian lagrangian_of(Scheme scheme) {
  return scheme == Scheme::paper ? mechanics::DiscreteLagrangian::paper : mechanics::DiscreteLagrangian::trapezoid;
}

}  // namespace lamprey::integrator
