// Limits and waypoints of an answer, measured on the stored motion: margins in the units of the problem file, and how their
// multipliers fit them.
#pragma once

#include <string>
#include <vector>

#include "evidence/bounds.hpp"
#include "evidence/limit_reach.hpp"

namespace lamprey::evidence {

/// The tightest place of all limits.
struct LimitCheck {
  double violation =
      0.0;            // largest: rad or m, of moments, rates and durations against the bound; of waypoints the miss
  std::string key;    // where: of the problem file
  double time = 0.0;  // s
  double complementarity =
      0.0;                // largest |multiplier · margin| over the nodes, against what is spent over the duration
  double negative = 0.0;  // most negative multiplier of a limit, against the largest
  std::vector<LimitReach> reaches = {};  // all limits, in the order of the file's keys
  double missed = 0.0;                   // rad or m, of waypoints at most
};

LimitCheck check_limits(const StoredMotion& motion);

/// Largest violation of the limits of that key at the node of that time, s; below 0 where they are kept, NaN where there is no such
/// limit or node.
double violation_at(const StoredMotion& motion, const std::string& key, double time);

/// [N + 1] how far a bound is from being broken at the nodes, in its own unit; NaN where it asks for nothing.
std::vector<double> margins(const StoredMotion& motion, const Bound& bound);

}  // namespace lamprey::evidence
