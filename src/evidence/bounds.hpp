// Which limits, waypoints and bounds of the duration a problem has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// One bound of the problem, or one condition of a waypoint.
struct Bound {
  enum class Kind {
    torque,
    torque_component,
    swing,
    twist,
    angle,
    angular_velocity,
    angle_rate,
    clearance,
    sphere,
    half_space,
    pass_position,
    pass_turn,
    duration
  } kind;
  std::string key;  // of the problem file
  int joint = -1, body = -1, other_body = -1;
  int component = -1;
  bool upper = false;
  double value = 0.0;
  int node = -1;      // of a waypoint or of the end; −1: each node
  int waypoint = -1;  // which
  bool of_rate() const { return kind == Kind::angular_velocity || kind == Kind::angle_rate; }
  bool equality() const { return kind == Kind::pass_position || kind == Kind::pass_turn; }
};

/// All of a problem's, in the order of the file's keys.
std::vector<Bound> bounds_of(const StoredMotion& motion);

/// Whether it asks for anything at a node: of states none where the motion begins.
bool applies(const StoredMotion& motion, const Bound& bound, int node);

/// Time for which a node counts, s; waypoints and the duration count once.
double node_time(const StoredMotion& motion, const Bound& bound, int node);

/// Multipliers of a bound at all nodes, or nothing.
const std::vector<double>* multipliers_of(const StoredMotion& motion, const Bound& bound);

/// A multiplier as a density in time: waypoints and bounds of the duration have one for all of it.
double density(const StoredMotion& motion, const Bound& bound, double multiplier);

/// A stored multiplier at a node where no bound of its name asks for anything.
struct IdlePull {
  std::size_t record;  // of limit_multipliers
  std::size_t node;
  double multiplier;
};

std::optional<IdlePull> idle_pull(const StoredMotion& motion);

/// What violations are counted in: moments, rates and durations against their bound.
double unit_of(const Bound& bound);

/// What its margin is large or small beside: lengths beside the swimmer.
double scale_of(const StoredMotion& motion, const Bound& bound);

}  // namespace lamprey::evidence
