// How far limits, waypoints and bounds of the duration are from being broken where a motion stands.
#pragma once

#include "evidence/bounds.hpp"

namespace lamprey::evidence {

inline constexpr double at_the_bound = 1e-6;  // of what a bound is large or small beside: no room is left

/// What a margin looks at.
struct Place {
  mechanics::Rotations rotation, rotation_before;  // [bodies]
  Vector3d position;
  VectorXd moment;   // [controls] along Joint::actuation
  double time_step;  // s
};

Place place_of(const StoredMotion& motion, int node);

/// The joint's turn over the step that ends here, rad.
double turn_of(const model::System& system, const Place& place, int joint);

/// How far a bound is from being broken, in its own unit; of a waypoint how far it is missed.
double margin(const StoredMotion& motion, const Bound& bound, const Place& place);

}  // namespace lamprey::evidence
