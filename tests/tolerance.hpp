// Tolerances of tests: one environment variable, LAMPREY_TOLERANCE_SCALE, scales them all; at 0 every check prints its true residual and fails.
#pragma once

#include <cstdlib>

namespace lamprey::tests {

inline double tolerance(double value) {
  const char* scale = std::getenv("LAMPREY_TOLERANCE_SCALE");
  return scale ? value * std::atof(scale) : value;
}

}  // namespace lamprey::tests
