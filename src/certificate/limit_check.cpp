#include "certificate/limit_check.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "certificate/certificate.hpp"
#include "certificate/cost_check.hpp"
#include "fluid/gap.hpp"
#include "integrator/step_derivatives.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::certificate {

namespace {

using model::at;
using model::System;
using Kind = Bound::Kind;

constexpr double difference_step = 2e-4;        // rad, of a length or relative; differences of order four
constexpr double share_of_turn = 5e-3;          // the same of a joint's turn over a step, for its rate
constexpr double least_difference_step = 1e-7;  // rad

// (N m)²: what is spent over the duration, the cost of one that is free included, though a bound holds it; 0 where nothing pulls, as
// in pictures of motions without moments.
double spent_rate(const StoredMotion& motion) {
  if (motion.solution.limit_multipliers.empty()) return 0.0;
  const double duration = motion.time_step * motion.steps;
  const double of_time = duration_holds(motion) ? motion.problem.time_weight * duration : 0.0;
  return std::abs(spent(motion, check_cost(motion).cost) + of_time) / duration;
}

// What a margin looks at.
struct Place {
  mechanics::Rotations rotation, rotation_before;  // [bodies]
  Vector3d position;
  VectorXd moment;   // [controls] along Joint::actuation
  double time_step;  // s
};

Place place_of(const StoredMotion& motion, int node) {
  const maneuver::Solution& stored = motion.solution;
  return {stored.rotation[at(node)], stored.rotation[at(std::max(node - 1, 0))], stored.position[at(node)],
          stored.control.empty() ? VectorXd() : mechanics::along_actuation(motion.system, motion.control[at(node)]),
          motion.time_step};
}

// Angle between two directions, rad, accurate everywhere.
double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Turn of a joint about its child's arm, rad in (−π, π]: what is left when the arm is swung back by the shortest way.
double twist_of(const model::Joint& joint, const Matrix3d& child_to_parent) {
  const Vector3d arm = (joint.reference_rotation * -joint.child_offset).normalized();
  const Matrix3d turned = child_to_parent * joint.reference_rotation.transpose();
  const Vector3d seen = turned * arm;
  const Vector3d axis = arm.cross(seen);
  const double swing = angle_between(arm, seen);
  const Matrix3d back = axis.norm() > 0.0 ? lie::exp(-swing * axis.normalized()) : Matrix3d(Matrix3d::Identity());
  return arm.dot(lie::log(back * turned));
}

Vector3d centre_of(const System& system, const Place& place, int body) {
  Vector3d x = place.position;
  for (const model::PathPoint& point : system.body(body).path) x += place.rotation[at(point.body)] * point.offset;
  return x;
}

double torque_of(const System& system, const Place& place, int joint) {
  const auto& actuation = system.joint(joint).actuation;
  return (actuation * place.moment.segment(system.joint(joint).first_control, actuation.cols())).norm();
}

double component_of(const System& system, const Place& place, const Bound& bound) {
  return place.moment[system.joint(bound.joint).first_control + bound.component];
}

double gap_of(const System& system, const Place& place, int body, const Vector3d& other_axes,
              const Matrix3d& other_rotation, const Vector3d& other_centre) {
  return fluid::gap({system.body(body).gap_axes(), other_axes, place.rotation[at(body)], other_rotation,
                     other_centre - centre_of(system, place, body)})
      .value;
}

// The joint's turn over the step that ends here, rad.
double turn_of(const System& system, const Place& place, int joint) {
  return lie::rotation_angle(mechanics::child_to_parent(place.rotation_before, system.joint(joint)).transpose() *
                             mechanics::child_to_parent(place.rotation, system.joint(joint)));
}

// The change of one of the joint's angles over that step, rad, the shorter way round.
double angle_change_of(const System& system, const Place& place, const Bound& bound) {
  const model::Joint& joint = system.joint(bound.joint);
  const auto angle = [&](const mechanics::Rotations& R) {
    return mechanics::joint_angles(joint, mechanics::child_to_parent(R, joint))[std::max(bound.component, 0)];
  };
  return std::remainder(angle(place.rotation) - angle(place.rotation_before), 2.0 * std::numbers::pi);
}

// A joint's rate bends over the turn that the joint takes in a step, which may be small: by how much it is changed for differences, rad,
// where others are changed by `step`.
double beside_turn(const System& system, const Bound& bound, const Place& here, double share, double step) {
  if (bound.kind != Kind::angular_velocity) return step;
  return std::clamp(share * turn_of(system, here, bound.joint), least_difference_step, step);
}

// Beside which a displacement is small where a margin bends with it, m: how sharply the two surfaces curve.
double length_of(const StoredMotion& motion, const Bound& bound) {
  if (bound.body < 0) return motion.system.size();
  const double own = motion.system.body(bound.body).semi_axes.minCoeff();
  return bound.kind == Kind::sphere ? std::min(own, motion.problem.limits.spheres[at(bound.component)].radius) : own;
}

// How far a bound is from being broken, in its own unit; of a waypoint how far it is missed.
double margin(const StoredMotion& motion, const Bound& bound, const Place& place) {
  const System& system = motion.system;
  const maneuver::Problem& problem = motion.problem;
  const auto child_to_parent = [&](const mechanics::Rotations& R) {
    return mechanics::child_to_parent(R, system.joint(bound.joint));
  };
  switch (bound.kind) {
    case Kind::torque:
      return bound.value - torque_of(system, place, bound.joint);
    case Kind::torque_component:
      return bound.value - std::abs(component_of(system, place, bound));
    case Kind::swing: {
      const model::Joint& joint = system.joint(bound.joint);
      return bound.value - angle_between(joint.parent_offset, child_to_parent(place.rotation) * -joint.child_offset);
    }
    case Kind::twist:
      return bound.value - std::abs(twist_of(system.joint(bound.joint), child_to_parent(place.rotation)));
    case Kind::angle: {
      const double angle = mechanics::joint_angles(system.joint(bound.joint),
                                                   child_to_parent(place.rotation))[std::max(bound.component, 0)];
      return bound.upper ? bound.value - angle : angle - bound.value;
    }
    case Kind::angular_velocity:
      return bound.value - turn_of(system, place, bound.joint) / place.time_step;
    case Kind::angle_rate: {
      const double rate = angle_change_of(system, place, bound) / place.time_step;
      return bound.value + (bound.upper ? -rate : rate);
    }
    case Kind::clearance:
      return gap_of(system, place, bound.body, system.body(bound.other_body).gap_axes(),
                    place.rotation[at(bound.other_body)], centre_of(system, place, bound.other_body)) -
             bound.value;
    case Kind::sphere: {
      const maneuver::KeepOutSphere& sphere = problem.limits.spheres[at(bound.component)];
      return gap_of(system, place, bound.body, Vector3d::Constant(sphere.radius), Matrix3d::Identity(), sphere.centre);
    }
    case Kind::half_space: {
      const maneuver::KeepOutHalfSpace& half = problem.limits.half_spaces[at(bound.component)];
      const Vector3d normal = half.normal.stableNormalized();
      const Vector3d extent =
          system.body(bound.body).semi_axes.asDiagonal() * (place.rotation[at(bound.body)].transpose() * normal);
      return normal.dot(centre_of(system, place, bound.body) - half.point) - extent.norm();
    }
    case Kind::pass_position:
      return place.position[bound.component] - bound.value;
    case Kind::pass_turn: {
      const maneuver::Waypoint& waypoint = problem.waypoints[at(bound.waypoint)];
      const auto own = waypoint.rotation.find(system.body(bound.body).name);
      const Matrix3d asked =
          own != waypoint.rotation.end()
              ? lie::exp(own->second)
              : Matrix3d(lie::exp(*waypoint.turn) * lie::exp(problem.start.rotation[at(bound.body)]));
      return lie::log(asked.transpose() * place.rotation[at(bound.body)])[bound.component];
    }
    case Kind::duration: {
      const double duration = place.time_step * motion.steps;
      return bound.upper ? bound.value - duration : duration - bound.value;
    }
  }
  return unset;
}

// Central difference of order four.
double slope(const std::function<double(double)>& f, double step) {
  return (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step);
}

// Adds factor × the margin's gradient.
void add_gradient(const StoredMotion& motion, const Bound& bound, int node, double factor, LimitPulls& pulls) {
  const System& system = motion.system;
  const integrator::StateLayout layout{system};
  const Place here = place_of(motion, node);
  const auto by = [&](const auto& change, double step) {
    return factor * slope(
                        [&](double e) {
                          Place place = here;
                          change(place, e);
                          return margin(motion, bound, place);
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
          by([&](Place& place, double e) { place.rotation = with_turn(system, here.rotation, i, f, e); }, change);
      if (bound.of_rate())
        pulls.by_state[at(node - 1)][layout.freedom(i) + f] += by(
            [&](Place& place, double e) { place.rotation_before = with_turn(system, here.rotation_before, i, f, e); },
            change);
    }
  const double displacement = difference_step * length_of(motion, bound);
  for (int c = 0; c < 3; ++c)
    pulls.by_state[at(node)][layout.position() + c] +=
        by([c](Place& place, double e) { place.position[c] += e; }, displacement);
}

// Nodes of a gait whose first shape is free too: what keeps its shape keeps that at the end, not where it is.
bool seen_at_start(const StoredMotion& motion, const Bound& bound) {
  return motion.problem.start.free_shape && (bound.kind == Kind::sphere || bound.kind == Kind::half_space);
}

// A multiplier as a density in time: waypoints and bounds of the duration have one for all of it.
double density(const StoredMotion& motion, const Bound& bound, double multiplier) {
  return bound.node >= 0 ? multiplier / (motion.time_step * motion.steps) : multiplier;
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

LimitPulls limit_pulls(const StoredMotion& motion) {
  const integrator::StateLayout layout{motion.system};
  LimitPulls pulls;
  pulls.by_state.assign(at(motion.steps + 1), VectorXd::Zero(layout.size()));
  pulls.by_control.assign(at(motion.steps + 1), VectorXd::Zero(motion.system.control_count()));
  for (const Bound& bound : bounds_of(motion)) {
    const std::vector<double>* multipliers = multipliers_of(motion, bound);
    if (!multipliers) continue;
    for (int k = 0; k <= motion.steps; ++k) {
      const double multiplier = (*multipliers)[at(k)];
      if (!applies(motion, bound, k) || multiplier == 0.0) continue;
      if (multiplier < 0.0 && !bound.equality()) continue;  // the wrong way: whoever needs it is not stationary
      pulls.any = true;
      add_gradient(motion, bound, k, multiplier * node_time(motion, bound, k), pulls);
    }
  }
  return pulls;
}

namespace {

constexpr double second_difference_step = 5e-3;  // rad, of a length or relative; differences of order four
constexpr double second_share_of_turn = 2e-2;    // the same of a joint's turn over a step, for its rate
constexpr double least_pull = 1e-9;              // of the largest; times its unit, of the cost over the duration
constexpr double at_the_bound = 1e-6;            // of what a bound is large or small beside
constexpr double least_worth = 1e-5;  // of the cost, of all the duration at what its bound's multiplier makes a second

// Margin where the place is moved by z along exponentials.
double margin_beside(const StoredMotion& motion, const Bound& bound, const Place& here, bool of_moments,
                     const VectorXd& z) {
  Place place = here;
  if (of_moments) {
    place.moment += z;
    return margin(motion, bound, place);
  }
  const Eigen::Index turns = motion.system.velocity_count() - 3;
  place.rotation = turned_along(motion.system, here.rotation, z.head(turns));
  place.position += z.segment<3>(turns);
  if (z.size() > turns + 3)
    place.rotation_before = turned_along(motion.system, here.rotation_before, z.segment(turns + 3, turns));
  return margin(motion, bound, place);
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
  const Place here = place_of(motion, node);
  const double step = of_moments ? second_difference_step * bound.value
                                 : beside_turn(system, bound, here, second_share_of_turn, second_difference_step);
  const double own = margin(motion, bound, here);
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
  const double scale = scale_of(motion, bound);
  result.pull *= scale;
  result.gradient /= scale;
  result.curvature /= scale;
  result.by_time /= scale;
  result.by_time_twice /= scale;
  result.by_time_mixed /= scale;
  return result;
}

// Whether a bound leaves no room at a node: strictly, so that what hardly pulls counts as free.
bool holds(const StoredMotion& motion, const Bound& bound, int k, double multiplier, double cost_rate) {
  if (bound.equality()) return true;
  const double unit = scale_of(motion, bound);
  return multiplier * unit > least_pull * cost_rate &&
         std::abs(margin(motion, bound, place_of(motion, k))) <= at_the_bound * unit;
}

}  // namespace

std::vector<PullingBound> pulling_bounds(const StoredMotion& motion) {
  std::vector<PullingBound> result;
  const std::vector<Bound> bounds = bounds_of(motion);
  const double cost_rate = spent_rate(motion);
  const auto pull_of = [&](const Bound& bound, double multiplier) {  // by what its margin is large or small beside
    return std::abs(density(motion, bound, multiplier)) * scale_of(motion, bound);
  };
  double largest = 0.0;
  for (const Bound& bound : bounds)
    if (const std::vector<double>* multipliers = multipliers_of(motion, bound))
      for (int k = 0; k <= motion.steps; ++k)
        if (applies(motion, bound, k)) largest = std::max(largest, pull_of(bound, (*multipliers)[at(k)]));
  for (const Bound& bound : bounds) {
    const std::vector<double>* multipliers = multipliers_of(motion, bound);
    if ((!multipliers && !bound.equality()) || bound.kind == Kind::duration) continue;
    for (int k = 0; k <= motion.steps; ++k) {
      if (!applies(motion, bound, k)) continue;
      const double multiplier =
          multipliers ? (*multipliers)[at(k)] : 0.0;  // a waypoint that pulls nothing is kept, too
      if (!bound.equality() && !(multiplier > 0.0 && pull_of(bound, multiplier) > least_pull * largest)) continue;
      result.push_back(pulling_bound(motion, bound, k, multiplier * node_time(motion, bound, k)));
      result.back().holds = holds(motion, bound, k, multiplier, cost_rate);
      result.back().equality = bound.equality();
    }
  }
  return result;
}

bool duration_holds(const StoredMotion& motion) {
  for (const Bound& bound : bounds_of(motion)) {
    if (bound.kind != Kind::duration) continue;
    const std::vector<double>* multipliers = multipliers_of(motion, bound);
    if (!multipliers) continue;
    const double duration = motion.time_step * motion.steps;
    const bool there = std::abs(margin(motion, bound, place_of(motion, motion.steps))) <= at_the_bound * duration;
    if (there && multipliers->back() * duration > least_worth * std::abs(check_cost(motion).cost + won(motion)))
      return true;
  }
  return false;
}

}  // namespace lamprey::certificate
