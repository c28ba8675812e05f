#include "optimality/limit_pulls.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "evidence/cost_check.hpp"
#include "evidence/limit_margin.hpp"
#include "integrator/step_derivatives.hpp"

namespace lamprey::optimality {

namespace {

using evidence::Bound;
using evidence::Place;
using model::at;
using model::System;
using Kind = Bound::Kind;

constexpr double difference_step = 2e-4;        // rad, of a length or relative; differences of order four
constexpr double share_of_turn = 5e-3;          // the same of a joint's turn over a step, for its rate
constexpr double least_difference_step = 1e-7;  // rad

// A joint's rate bends over the turn that the joint takes in a step, which may be small: by how much it is changed for differences, rad,
// where others are changed by `step`.
double beside_turn(const System& system, const Bound& bound, const Place& here, double share, double step) {
  if (bound.kind != Kind::angular_velocity) return step;
  return std::clamp(share * evidence::turn_of(system, here, bound.joint), least_difference_step, step);
}

// Beside which a displacement is small where a margin bends with it, m: how sharply the two surfaces curve.
double length_of(const StoredMotion& motion, const Bound& bound) {
  if (bound.body < 0) return motion.system.size();
  const double own = motion.system.body(bound.body).semi_axes.minCoeff();
  return bound.kind == Kind::sphere ? std::min(own, motion.problem.limits.spheres[at(bound.component)].radius) : own;
}

// Central difference of order four.
double slope(const std::function<double(double)>& f, double step) {
  return (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step);
}

// Adds factor × the margin's gradient.
void add_gradient(const StoredMotion& motion, const Bound& bound, int node, double factor, LimitPulls& pulls) {
  const System& system = motion.system;
  const integrator::StateLayout layout{system};
  const Place here = evidence::place_of(motion, node);
  const auto by = [&](const auto& change, double step) {
    return factor * slope(
                        [&](double e) {
                          Place place = here;
                          change(place, e);
                          return evidence::margin(motion, bound, place);
                        },
                        step);
  };
  const bool of_moments = bound.kind == Kind::torque || bound.kind == Kind::torque_component;
  if (of_moments) {
    for (Eigen::Index c = 0; c < here.moment.size(); ++c)
      pulls.by_control[at(node)][c] +=
          by([c](Place& place, double e) { place.moment[c] += e; }, difference_step * bound.value);
    return;
  }
  if (bound.kind == Kind::duration || bound.of_rate())
    pulls.by_log_time_step += by([](Place& place, double e) { place.time_step *= std::exp(e); }, difference_step);
  if (bound.kind == Kind::duration) return;
  const double change = beside_turn(system, bound, here, share_of_turn, difference_step);
  for (int i = 0; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) {
      pulls.by_state[at(node)][layout.freedom(i) + f] +=
          by([&](Place& place, double e) { place.rotation = evidence::with_turn(system, here.rotation, i, f, e); },
             change);
      if (bound.of_rate())
        pulls.by_state[at(node - 1)][layout.freedom(i) + f] +=
            by([&](Place& place,
                   double e) { place.rotation_before = evidence::with_turn(system, here.rotation_before, i, f, e); },
               change);
    }
  const double displacement = difference_step * length_of(motion, bound);
  for (int c = 0; c < 3; ++c)
    pulls.by_state[at(node)][layout.position() + c] +=
        by([c](Place& place, double e) { place.position[c] += e; }, displacement);
}

}  // namespace

LimitPulls limit_pulls(const StoredMotion& motion) {
  const integrator::StateLayout layout{motion.system};
  LimitPulls pulls;
  pulls.by_state.assign(at(motion.steps + 1), VectorXd::Zero(layout.size()));
  pulls.by_control.assign(at(motion.steps + 1), VectorXd::Zero(motion.system.control_count()));
  for (const Bound& bound : evidence::bounds_of(motion)) {
    const std::vector<double>* multipliers = evidence::multipliers_of(motion, bound);
    if (!multipliers) continue;
    for (int k = 0; k <= motion.steps; ++k) {
      const double multiplier = (*multipliers)[at(k)];
      if (!evidence::applies(motion, bound, k) || multiplier == 0.0) continue;
      if (multiplier < 0.0 && !bound.equality()) continue;  // the wrong way: whoever needs it is not stationary
      pulls.any = true;
      add_gradient(motion, bound, k, multiplier * evidence::node_time(motion, bound, k), pulls);
    }
  }
  return pulls;
}

namespace {

constexpr double second_difference_step = 5e-3;  // rad, of a length or relative; differences of order four
constexpr double second_share_of_turn = 2e-2;    // the same of a joint's turn over a step, for its rate
constexpr double least_pull = 1e-9;              // of the largest; times its unit, of the cost over the duration
constexpr double little_room = 1e-3;             // in the bound's unit

// Margin where the place is moved by z along exponentials.
double margin_beside(const StoredMotion& motion, const Bound& bound, const Place& here, bool of_moments,
                     const VectorXd& z) {
  Place place = here;
  if (of_moments) {
    place.moment += z;
    return evidence::margin(motion, bound, place);
  }
  const Eigen::Index turns = motion.system.velocity_count() - 3;
  place.rotation = evidence::turned_along(motion.system, here.rotation, z.head(turns));
  place.position += z.segment<3>(turns);
  if (z.size() > turns + 3)
    place.rotation_before = evidence::turned_along(motion.system, here.rotation_before, z.segment(turns + 3, turns));
  return evidence::margin(motion, bound, place);
}

// Whether a margin can depend on body i's freedoms.
bool looks_at(const System& system, const Bound& bound, int i) {
  const auto below = [&](int body) {
    if (body < 0) return false;
    for (const model::PathPoint& point : system.body(body).path)
      if (point.body == i) return true;
    return false;
  };
  const int child = bound.joint >= 0 ? system.joint(bound.joint).child : -1;
  return below(bound.body) || below(bound.other_body) || below(child);
}

std::vector<Eigen::Index> coordinates_of(const System& system, const Bound& bound) {
  const Eigen::Index turns = system.velocity_count() - 3;
  std::vector<Eigen::Index> result;
  if (bound.kind == Kind::torque || bound.kind == Kind::torque_component) {
    const model::Joint& joint = system.joint(bound.joint);
    for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c) result.push_back(joint.first_control + c);
    return result;
  }
  for (const bool before : {false, true}) {
    if (before && !bound.of_rate()) break;
    for (int i = 0; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms && looks_at(system, bound, i); ++f)
        result.push_back((before ? turns + 3 : 0) + system.body(i).velocity_offset + f);
  }
  if (bound.kind == Kind::sphere || bound.kind == Kind::half_space || bound.kind == Kind::pass_position)
    for (int c = 0; c < 3; ++c) result.push_back(turns + c);
  return result;
}

PullingBound pulling_bound(const StoredMotion& motion, const Bound& bound, int node, double pull) {
  const System& system = motion.system;
  const Eigen::Index turns = system.velocity_count() - 3;
  const bool of_moments = bound.kind == Kind::torque || bound.kind == Kind::torque_component;
  const Eigen::Index size = of_moments ? system.control_count() : bound.of_rate() ? 2 * turns + 3 : turns + 3;
  PullingBound result{node, of_moments, pull, VectorXd::Zero(size), MatrixXd::Zero(size, size), 0.0, 0.0, {}};
  const Place here = evidence::place_of(motion, node);
  const double step = of_moments ? second_difference_step * bound.value
                                 : beside_turn(system, bound, here, second_share_of_turn, second_difference_step);
  const double own = evidence::margin(motion, bound, here);
  const auto second = [&](const VectorXd& direction) {  // and the first, by the way
    const auto f = [&](double e) { return margin_beside(motion, bound, here, of_moments, e * direction); };
    const double near = f(step), near_back = f(-step), far = f(2.0 * step), far_back = f(-2.0 * step);
    return std::pair((8.0 * (near - near_back) - (far - far_back)) / (12.0 * step),
                     (16.0 * (near + near_back) - (far + far_back) - 30.0 * own) / (12.0 * step * step));
  };
  const std::vector<Eigen::Index> coordinates = coordinates_of(system, bound);
  VectorXd unit = VectorXd::Ones(size);  // in which coordinates are moved, then divided by
  if (!of_moments) unit.segment<3>(turns).setConstant(length_of(motion, bound));
  const auto moved = [&](Eigen::Index a) { return VectorXd(unit[a] * VectorXd::Unit(size, a)); };
  for (Eigen::Index a : coordinates) std::tie(result.gradient[a], result.curvature(a, a)) = second(moved(a));
  for (Eigen::Index a : coordinates)
    for (Eigen::Index b : coordinates) {
      if (b >= a) continue;
      const double both = second(moved(a) + moved(b)).second;
      result.curvature(a, b) = 0.5 * (both - result.curvature(a, a) - result.curvature(b, b));
      result.curvature(b, a) = result.curvature(a, b);
    }
  result.gradient = result.gradient.cwiseQuotient(unit);
  result.curvature = unit.cwiseInverse().asDiagonal() * result.curvature * unit.cwiseInverse().asDiagonal();
  result.by_time_mixed = VectorXd::Zero(size);
  if (of_moments) {  // moments fall with the square of the time step
    const VectorXd& u = here.moment;
    const double along = result.gradient.dot(u);
    result.by_time = -2.0 * along;
    result.by_time_twice = 4.0 * (along + u.dot(result.curvature * u));
    result.by_time_mixed = -2.0 * (result.gradient + result.curvature * u);
  } else if (bound.of_rate()) {  // rates with the time step
    result.by_time = bound.value - own;
    result.by_time_twice = -result.by_time;
    result.by_time_mixed = -result.gradient;
  }
  const double scale = evidence::scale_of(motion, bound);
  result.pull *= scale;
  result.gradient /= scale;
  result.curvature /= scale;
  result.by_time /= scale;
  result.by_time_twice /= scale;
  result.by_time_mixed /= scale;
  return result;
}

// Whether a bound leaves no room at a node: strictly, so that what hardly pulls counts as free. What a barrier has left of room does
// not tell where it is less than the pull, both without units.
bool holds(const StoredMotion& motion, const Bound& bound, int k, double multiplier, double cost_rate) {
  if (bound.equality()) return true;
  const double unit = evidence::scale_of(motion, bound);
  const double room = std::abs(evidence::margin(motion, bound, evidence::place_of(motion, k))) / unit;
  const double pull = multiplier * unit / cost_rate;
  return pull > least_pull && (room <= evidence::at_the_bound || (room <= little_room && room < pull));
}

}  // namespace

std::vector<PullingBound> pulling_bounds(const StoredMotion& motion) {
  std::vector<PullingBound> result;
  const std::vector<Bound> bounds = evidence::bounds_of(motion);
  const double cost_rate = evidence::spent_rate(motion);
  const auto pull_of = [&](const Bound& bound, double multiplier) {  // by what its margin is large or small beside
    return std::abs(evidence::density(motion, bound, multiplier)) * evidence::scale_of(motion, bound);
  };
  double largest = 0.0;
  for (const Bound& bound : bounds)
    if (const std::vector<double>* multipliers = evidence::multipliers_of(motion, bound))
      for (int k = 0; k <= motion.steps; ++k)
        if (evidence::applies(motion, bound, k)) largest = std::max(largest, pull_of(bound, (*multipliers)[at(k)]));
  for (const Bound& bound : bounds) {
    const std::vector<double>* multipliers = evidence::multipliers_of(motion, bound);
    if ((!multipliers && !bound.equality()) || bound.kind == Kind::duration) continue;
    for (int k = 0; k <= motion.steps; ++k) {
      if (!evidence::applies(motion, bound, k)) continue;
      const double multiplier =
          multipliers ? (*multipliers)[at(k)] : 0.0;  // a waypoint that pulls nothing is kept, too
      if (!bound.equality() && !(multiplier > 0.0 && pull_of(bound, multiplier) > least_pull * largest)) continue;
      result.push_back(pulling_bound(motion, bound, k, multiplier * evidence::node_time(motion, bound, k)));
      result.back().holds = holds(motion, bound, k, multiplier, cost_rate);
      result.back().equality = bound.equality();
    }
  }
  return result;
}

}  // namespace lamprey::optimality
