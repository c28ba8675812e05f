#include "evidence/limit_check.hpp"

#include <algorithm>
#include <cmath>

#include "evidence/cost_check.hpp"
#include "evidence/findings.hpp"
#include "evidence/limit_margin.hpp"

namespace lamprey::evidence {

namespace {

using model::at;
using Kind = Bound::Kind;

// Nodes of a gait whose first shape is free too: what keeps its shape keeps that at the end, not where it is.
bool seen_at_start(const StoredMotion& motion, const Bound& bound) {
  return motion.problem.start.free_shape && (bound.kind == Kind::sphere || bound.kind == Kind::half_space);
}

}  // namespace

std::vector<double> margins(const StoredMotion& motion, const Bound& bound) {
  std::vector<double> values;
  for (int k = 0; k <= motion.steps; ++k)
    values.push_back(applies(motion, bound, k) ? margin(motion, bound, place_of(motion, k)) : unset);
  return values;
}

LimitCheck check_limits(const StoredMotion& motion) {
  LimitCheck check;
  LimitReaches reaches;
  double largest = 0.0;
  const double cost_rate = std::max(spent_rate(motion), 1e-300);
  const std::vector<Bound> bounds = bounds_of(motion);
  const BallMargins balls(motion, bounds);
  for (const Bound& bound : bounds) {
    const std::vector<double>* multipliers = multipliers_of(motion, bound);
    const double near = at_the_limit * scale_of(motion, bound);
    for (int k = 0; k <= motion.steps; ++k) {
      if (!applies(motion, bound, k) && !(k == 0 && seen_at_start(motion, bound))) continue;
      const bool pulls = multipliers && (*multipliers)[at(k)] != 0.0;
      if (!pulls && balls.least(bound, k) > std::max(near, reaches.tightest(bound))) continue;
      const double own = margin(motion, bound, place_of(motion, k));
      const double violation = (bound.equality() ? std::abs(own) : -own) / unit_of(bound);
      if (violation > check.violation || !std::isfinite(violation))
        check.violation = violation, check.key = bound.key, check.time = k * motion.time_step;
      if (bound.equality()) check.missed = std::max(check.missed, std::abs(own));
      if (bound.equality()) continue;
      reaches.add(motion, bound, k, own);
      if (!multipliers || !applies(motion, bound, k)) continue;
      const double pull = density(motion, bound, (*multipliers)[at(k)]);
      check.complementarity = std::max(check.complementarity, std::abs(pull * own) / cost_rate);
      check.negative = std::max(check.negative, -pull * scale_of(motion, bound));
      largest = std::max(largest, std::abs(pull) * scale_of(motion, bound));
    }
  }
  if (largest > 0.0) check.negative /= largest;
  check.reaches = reaches.finished(motion.steps);
  return check;
}

double violation_at(const StoredMotion& motion, const std::string& key, double time) {
  constexpr double near = 1e-6;  // steps
  const double place = time / motion.time_step;
  const double node = std::round(place);
  if (!(std::abs(place - node) <= near && node >= 0.0 && node <= motion.steps)) return unset;
  double largest = unset;
  for (const Bound& bound : bounds_of(motion)) {
    if (bound.key != key) continue;
    const int k = static_cast<int>(node);
    if (!applies(motion, bound, k) && !(k == 0 && seen_at_start(motion, bound))) continue;
    const double own = margin(motion, bound, place_of(motion, k));
    const double violation = (bound.equality() ? std::abs(own) : -own) / unit_of(bound);
    if (!(violation <= largest)) largest = violation;
  }
  return largest;
}

}  // namespace lamprey::evidence
