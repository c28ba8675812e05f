// Problem: the numbers of a problem file, one field for each key. Angles in rad, SI units, body order as in `swimmer.bodies`.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "integrator/scheme.hpp"
#include "model/description.hpp"

namespace lamprey::maneuver {

using integrator::Scheme;
enum class CostRule { trapezoid, rectangle };
enum class ControlKind { steps, spline };
enum class SearchMethod { simultaneous, shooting };

struct Start {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();         // m, root's mass centre, world
  std::vector<Eigen::Vector3d> rotation;                      // [bodies] rad, rotation vector body → world
  std::vector<Eigen::Vector3d> angular_velocity;              // [bodies] rad/s, body frame
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();  // m/s, of the root's mass centre, world
  bool free_shape = false;
};

/// Numbers about a joint's axes, zeros behind.
inline Eigen::Vector3d about_axes(const std::vector<double>& numbers) {
  Eigen::Vector3d three = Eigen::Vector3d::Zero();
  for (std::size_t axis = 0; axis < numbers.size(); ++axis) three[static_cast<Eigen::Index>(axis)] = numbers[axis];
  return three;
}

struct Goal {
  std::array<std::optional<double>, 3> move;                       // m, world; nothing: free
  std::optional<Eigen::Vector3d> turn;                             // rad, world-frame rotation vector
  std::map<std::string, std::optional<Eigen::Vector3d>> rotation;  // rad by body, absolute; nothing: "free"
  std::map<std::string, std::vector<double>> angle;  // rad by joint, as mechanics::turn_from_zero has them
  bool shape_of_start = false;                       // joints end as they begin, but those of `angle`
  bool rest = true;                                  // nothing moves at the end,
  bool joints_rest = false;                          // or no joint does, and the whole drifts on as one
  bool periodic = false;
  /// Whether no joint moves at the end.
  bool stills_joints() const { return rest || joints_rest; }
  /// rad, how far from its zero angle a joint is to end; nothing: `angle` has none of it.
  std::optional<Eigen::Vector3d> turn_of_joint(const std::string& name) const {
    const auto own = angle.find(name);
    return own == angle.end() ? std::nullopt : std::optional(about_axes(own->second));
  }
  /// Whether joints are told how to end.
  bool of_joints() const { return shape_of_start || !angle.empty(); }
  /// m, where all of move is given.
  std::optional<double> distance() const {
    if (!move[0] || !move[1] || !move[2]) return std::nullopt;
    return std::hypot(*move[0], *move[1], *move[2]);
  }
};

struct Duration {
  bool free = false;
  double value = 1.0;                                     // s
  double min = std::numeric_limits<double>::quiet_NaN();  // s, with free
  double max = std::numeric_limits<double>::quiet_NaN();  // s, with free
};

struct KeepOutSphere {
  Eigen::Vector3d centre;  // m, world
  double radius;           // m
};

struct KeepOutHalfSpace {
  Eigen::Vector3d point;   // m, on its face, world
  Eigen::Vector3d normal;  // out of it, any length
};

/// Least and largest angle about each axis of a joint, rad.
using AngleBounds = std::vector<std::array<double, 2>>;

struct Limits {
  std::optional<double> torque;                          // N m, every joint
  std::map<std::string, double> joint_torque;            // N m by joint
  std::optional<double> torque_component;                // N m, each component of every joint
  std::map<std::string, double> joint_torque_component;  // N m by joint
  std::optional<double> angular_velocity;                // rad/s, every joint
  std::map<std::string, double> joint_angular_velocity;  // rad/s by joint
  std::optional<double> angular_velocity_component;      // rad/s, each angle of every hinge or universal joint
  std::map<std::string, double> joint_angular_velocity_component;  // rad/s by hinge or universal joint
  std::map<std::string, double> swing;                             // rad by joint
  std::map<std::string, double> twist;                             // rad by joint
  std::map<std::string, AngleBounds> angle;                        // rad by hinge or universal joint
  std::optional<double> clearance;                                 // m
  std::vector<KeepOutSphere> spheres;
  std::vector<KeepOutHalfSpace> half_spaces;
  bool of_moments() const {
    return torque || torque_component || !joint_torque.empty() || !joint_torque_component.empty();
  }
  bool of_rates() const {
    return angular_velocity || angular_velocity_component || !joint_angular_velocity.empty() ||
           !joint_angular_velocity_component.empty();
  }
  bool any() const {
    return of_moments() || of_rates() || clearance || !swing.empty() || !twist.empty() || !angle.empty() ||
           !spheres.empty() || !half_spaces.empty();
  }
};

/// What the swimmer passes on its way.
struct Waypoint {
  double time;                                      // s
  std::array<std::optional<double>, 3> move;        // m, as in Goal
  std::optional<Eigen::Vector3d> turn;              // rad, as in Goal; where the first shape is free of the root alone
  std::map<std::string, Eigen::Vector3d> rotation;  // rad by body, absolute

  /// Whether it says how a body is turned, where the first shape is free or not.
  bool turns(const std::string& body, bool root, bool free_shape) const {
    return rotation.contains(body) || (turn && (root || !free_shape));
  }
};

struct Search {
  int starts = 1;
  int whole_turns =
      0;  // of the starts the last so many, but not the first: they begin with joints that turn all the way round
  int hops = 0;  // further solves from perturbed copies of the best minimum so far
  int keep = 1;  // minima that become answers, by rising cost
  std::uint64_t seed = 1;
  SearchMethod method = SearchMethod::simultaneous;
  double tolerance = 1e-8;           // on certificate.kkt, where digits hold so much
  std::optional<double> time_limit;  // s, wall clock
};

/// Weights of the costs beside effort and time.
struct CostWeights {
  double work = 0.0;              // (N m)² s/J, of ∫ Σ_j |u_j·ω_j| dt
  double power = 0.0;             // (N m)²/W², of ∫ Σ_j (u_j·ω_j)² dt
  double smoothness = 0.0;        // s², of ∫ ½ Σ_j |du_j/dt|² dt
  double angular_velocity = 0.0;  // (N m)² s²/rad², of ∫ ½ Σ_j |ω_j|² dt
  double transport = 0.0;  // (N m)² s m/J, of work per distance that the root's mass centre ends from where it began
  /// (N m)² s/m, what each metre wins that the root's mass centre ends further along each world axis.
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  /// Whether any but displacement, which counts at the end alone.
  bool any() const {
    return work > 0.0 || power > 0.0 || smoothness > 0.0 || angular_velocity > 0.0 || transport > 0.0;
  }
  bool of_displacement() const { return !displacement.isZero(0.0); }
};

/// What problem files say and solutions repeat as it is.
struct ProblemStatement {
  Scheme scheme = Scheme::trapezoid;
  int steps = 1000;
  std::optional<Goal> goal;
  ControlKind control = ControlKind::steps;
  int points = 0;            // with spline control
  double effort = 1.0;       // weight of ∫ ½ Σ_j |u_j|² dt
  double time_weight = 0.0;  // (N m)², weight of the duration
  CostWeights cost_weights;  // of the other costs
  Limits limits;
  std::vector<Waypoint> waypoints;
};

struct Problem : ProblemStatement {
  std::string name;
  std::string source;
  model::SwimmerDescription swimmer;
  Start start;
  Duration duration;
  std::optional<CostRule> rule;  // absent: trapezoid
  Search search;

  CostRule cost_rule() const { return rule.value_or(CostRule::trapezoid); }
  double time_step() const { return duration.value / steps; }
  /// (N m)² s, the same whatever the motion.
  double cost_of_given_duration() const { return duration.free ? 0.0 : time_weight * duration.value; }
};

}  // namespace lamprey::maneuver
