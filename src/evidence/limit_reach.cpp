#include "evidence/limit_reach.hpp"

#include <algorithm>
#include <limits>

namespace lamprey::evidence {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// Of keep-outs which of them; others are told by their key alone.
int which_of(const Bound& bound) {
  return bound.kind == Bound::Kind::sphere || bound.kind == Bound::Kind::half_space ? bound.component : -1;
}

}  // namespace

void LimitReaches::add(const StoredMotion& motion, const Bound& bound, int node, double margin) {
  const int which = which_of(bound);
  const auto [place, is_new] = place_.try_emplace({bound.key, which}, gathered_.size());
  if (is_new) gathered_.push_back({{bound.key, bound.kind, which}, {}});
  auto& [reach, nodes] = gathered_[place->second];
  const double violation = -margin / unit_of(bound);
  if (is_new || violation > reach.violation) {
    reach.violation = violation, reach.margin = margin;
    reach.bound = bound.value, reach.time = node * motion.time_step;
  }
  if (margin <= at_the_limit * scale_of(motion, bound)) nodes.insert(node);
}

double LimitReaches::tightest(const Bound& bound) const {
  const auto place = place_.find({bound.key, which_of(bound)});
  return place == place_.end() ? infinite : gathered_[place->second].reach.margin;
}

std::vector<LimitReach> LimitReaches::finished(int steps) const {
  std::vector<LimitReach> reaches;
  for (const Gathered& one : gathered_) {
    reaches.push_back(one.reach);
    reaches.back().share = static_cast<double>(one.nodes.size()) / (steps + 1);
  }
  return reaches;
}

BallMargins::BallMargins(const StoredMotion& motion, const std::vector<Bound>& bounds) : motion_(motion) {
  const bool any = std::any_of(bounds.begin(), bounds.end(),
                               [](const Bound& bound) { return bound.kind == Bound::Kind::clearance; });
  for (int k = 0; any && k <= motion.steps; ++k)
    centre_.push_back(
        motion.system.mass_centres(motion.solution.rotation[model::at(k)], motion.solution.position[model::at(k)]));
}

double BallMargins::least(const Bound& bound, int node) const {
  if (bound.kind != Bound::Kind::clearance) return -infinite;
  const auto radius = [&](int body) { return motion_.system.body(body).semi_axes.maxCoeff(); };
  const std::vector<Vector3d>& centre = centre_[model::at(node)];
  return (centre[model::at(bound.other_body)] - centre[model::at(bound.body)]).norm() - radius(bound.body) -
         radius(bound.other_body) - bound.value;
}

}  // namespace lamprey::evidence
