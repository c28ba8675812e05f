#include "evidence/limit_margin.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "evidence/findings.hpp"
#include "fluid/gap.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::evidence {

namespace {

using model::at;
using model::System;
using Kind = Bound::Kind;

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

// The change of one of the joint's angles over that step, rad, the shorter way round.
double angle_change_of(const System& system, const Place& place, const Bound& bound) {
  const model::Joint& joint = system.joint(bound.joint);
  const auto angle = [&](const mechanics::Rotations& R) {
    return mechanics::joint_angles(joint, mechanics::child_to_parent(R, joint))[std::max(bound.component, 0)];
  };
  return std::remainder(angle(place.rotation) - angle(place.rotation_before), 2.0 * std::numbers::pi);
}

}  // namespace

Place place_of(const StoredMotion& motion, int node) {
  const maneuver::Solution& stored = motion.solution;
  return {stored.rotation[at(node)], stored.rotation[at(std::max(node - 1, 0))], stored.position[at(node)],
          stored.control.empty() ? VectorXd() : mechanics::along_actuation(motion.system, motion.control[at(node)]),
          motion.time_step};
}

double turn_of(const System& system, const Place& place, int joint) {
  return lie::rotation_angle(mechanics::child_to_parent(place.rotation_before, system.joint(joint)).transpose() *
                             mechanics::child_to_parent(place.rotation, system.joint(joint)));
}

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

}  // namespace lamprey::evidence
