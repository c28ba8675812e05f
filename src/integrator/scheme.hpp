// The schemes a problem may name, each a row of steps of one discrete Lagrangian.
#pragma once

#include <vector>

#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::integrator {

enum class Scheme { paper, trapezoid, midpoint, order4, order6 };

/// A scheme as a symmetric composition: steps of a discrete Lagrangian whose lengths are fractions of the time step
/// (they add up to 1; some are negative above order 2). Sources and choice: docs/decisions/005.
struct Composition {
  mechanics::DiscreteLagrangian lagrangian;
  std::vector<double> fractions;  // [stages]
  int stages() const { return static_cast<int>(fractions.size()); }
};

const Composition& composition(Scheme scheme);

/// Order of the scheme's error in the time step.
int order(Scheme scheme);

/// Whether transcription and certificate know the scheme: those of order 1 and 2 by their discrete Lagrangian.
inline bool single_step(Scheme scheme) { return scheme != Scheme::order4 && scheme != Scheme::order6; }

/// The discrete Lagrangian behind a scheme.
inline mechanics::DiscreteLagrangian lagrangian_of(Scheme scheme) { return composition(scheme).lagrangian; }

}  // namespace lamprey::integrator
