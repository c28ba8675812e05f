// What a maneuver may not do, and where it must pass: rows g ≥ 0 (limits) and g = 0 (waypoints) at its nodes, with first
// and second derivatives (chapter 10, equations 10.1 to 10.4).
//
// Derivatives of what depends on the swimmer's attitude are taken by the "body coordinates" of a node: turns of all
// bodies in their own frames along exponentials, [3 bodies], the root's position, [3], the turns of all bodies at the node
// before, [3 bodies], for rates of joints, and the logarithm of the time step.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "maneuver/maneuver.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

/// One row at each node, or at one node alone.
struct LimitRow {
  enum class Kind {
    torque,            // |u_j| ≤ bound, as 1 − |u_j|/bound
    torque_component,  // each |u_jc| ≤ bound, likewise
    swing,             // cosine of the angle between the joint's two arms ≥ cos(bound)
    twist,             // |turn about the child's arm| ≤ bound, rad
    angle_above,       // angle of a hinge, or of a universal joint about one of its axes, ≥ bound, rad
    angle_below,       // the same ≤ bound, rad
    speed,             // a joint's mean rate over the step ≤ bound rad/s, as its cosine against bound, see there
    rate_above,        // an angle's mean rate over the step ≥ −bound rad/s, as 1 + rate/bound
    rate_below,        // the same ≤ bound, as 1 − rate/bound
    clearance,         // gap of two bodies ≥ bound, m
    sphere,            // gap of a body and a sphere ≥ 0, m
    half_space,        // gap of a body and a half-space ≥ 0, m
    pass_position,     // component of the root's position − bound = 0, m
    pass_turn,         // component of log(askedᵀ R) = 0, rad
    not_shorter,       // duration ≥ bound, as duration/bound − 1; at the end
    not_longer         // duration ≤ bound, likewise
  } kind;
  std::string key;  // of the problem file
  int joint = -1;
  int body = -1, other_body = -1;
  int component = -1;  // of a moment, a position, a turn; axis of a universal joint; number of a sphere or half-space
  double bound = 0.0;
  double unit = 1.0;                      // what the value is divided by to become a number of order one
  Vector3d centre = Vector3d::Zero();     // m, of a sphere; point on a half-space's face
  Vector3d normal = Vector3d::Zero();     // out of the forbidden half-space, unit
  Matrix3d asked = Matrix3d::Identity();  // body → world at a waypoint
  double time = -1.0;                     // s of a waypoint; negative: at each node
  double time_before = -1.0;              // s of the waypoint before it; negative: there is none
  bool equality() const { return kind == Kind::pass_position || kind == Kind::pass_turn; }
  bool upper() const { return kind == Kind::angle_below || kind == Kind::rate_below || kind == Kind::not_longer; }
  /// As the problem file has it: of keep-outs with their number.
  std::string listed_key() const;
  /// " at joint NAME", " of BODY" or " of BODY and BODY"; nothing where it is of the whole.
  std::string bearer(const model::System& system) const;
  /// What the bound is counted in, and by how much of it a limit is exceeded where its value is −`missing`; rates as means over a
  /// step of `time_step` s.
  const char* unit_name() const;
  double excess(double missing, double time_step) const;
  /// Which of the freedoms of its child an angle's row is about.
  int freedom() const { return std::max(component, 0); }
  bool of_duration() const { return kind == Kind::not_shorter || kind == Kind::not_longer; }
  /// Whether the value is no multiple of what is left to the bound. Joints' rotations alone tell the value then.
  bool bends() const { return kind == Kind::swing || kind == Kind::speed; }
  bool of_rate() const { return kind == Kind::speed || kind == Kind::rate_above || kind == Kind::rate_below; }
  bool of_gap() const { return kind == Kind::clearance || kind == Kind::sphere || kind == Kind::half_space; }
  bool of_moments() const { return kind == Kind::torque || kind == Kind::torque_component; }
};

/// All limits and waypoints of a problem and bounds of its duration, joint by joint, then those of all bodies.
std::vector<LimitRow> limit_rows(const model::System& system, const Problem& problem);

/// Whether a row counts at a node of a motion of so many steps and this duration, s: shapes at the start are given, moments are not.
/// Steps coarser than the problem's own may bring a waypoint to the node of the one before it, or to the motion's ends: there it
/// does not count.
bool applies(const LimitRow& row, int node, int steps, double duration);

/// Time that a row counts for at a node, s: 1 of waypoints and durations.
double counted_time(const LimitRow& row, int node, int steps, double duration);

/// A node as limits see it.
struct LimitedNode {
  const mechanics::Rotations& rotation;         // [bodies] body → world
  const mechanics::Rotations& rotation_before;  // [bodies] at the node before; the same at node 0
  const Vector3d& position;                     // m, root's mass centre
  const VectorXd& moment;                       // [≥ controls] N m along the joints' actuation
  double time_step;                             // s
  double duration;                              // s
};

/// Number of body coordinates.
inline int body_coordinates(const model::System& system) { return 6 * system.body_count() + 4; }

/// Value of a row divided by its unit; where two bodies are far apart, a lower bound that is larger than `enough`. Of gaps `across` is a
/// direction from one body to the other, world frame: that of the gap at a node nearby, which is found sooner from there, or zero; then
/// that of this one.
double limit_value(const model::System& system, const LimitRow& row, const LimitedNode& node, double enough,
                   Eigen::Vector3d& across);
double limit_value(const model::System& system, const LimitRow& row, const LimitedNode& node, double enough);

/// Gradient and Hessian of limit_value by the body coordinates, not of torque rows: [body_coordinates], squared.
void limit_derivatives(const model::System& system, const LimitRow& row, const LimitedNode& node,
                       Eigen::Vector3d& across, VectorXd& gradient, MatrixXd& hessian);
void limit_derivatives(const model::System& system, const LimitRow& row, const LimitedNode& node, VectorXd& gradient,
                       MatrixXd& hessian);

/// The same of a torque row by the moments along the actuation: [controls], squared.
void torque_derivatives(const model::System& system, const LimitRow& row, const VectorXd& moment, VectorXd& gradient,
                        MatrixXd& hessian);

/// Change of a row's value, where it is `value`, for each N m, rad, rad/s, m or s by which its limit gives way.
double price_of_bound(const LimitRow& row, double time_step, double value);

}  // namespace lamprey::maneuver
