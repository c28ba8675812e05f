// First-order optimality in the space of controls, and whether the controls are what the problem allows.
#pragma once

#include "certificate/stored_motion.hpp"

namespace lamprey::certificate {

/// The free numbers behind the stored moments: along each joint's actuation at each node, or at each spline point.
struct ControlSpace {
  VectorXd value;  // [nodes or points × controls] N m, node after node or point after point
  MatrixXd basis;  // [N+1][points] moments at the nodes by the points; empty for one value at each node
  double outside;  // largest part of a moment that this space cannot make / largest moment
};

ControlSpace control_space(const StoredMotion& motion);

/// Largest part of a stored moment outside the actuation axes / largest moment.
double beyond_actuation(const StoredMotion& motion);

/// Stored moments along the actuation axes, [N+1][controls] N m.
MatrixXd actuated_moments(const StoredMotion& motion);

/// Weight of each node's ½|u|² in the cost, [N+1] s.
VectorXd node_weights(const StoredMotion& motion);

/// Gradient of the cost by the free numbers of the space.
VectorXd cost_gradient(const StoredMotion& motion, const ControlSpace& space);

/// What a free duration makes ∇cost worth at least by a moment, (N m) s: the time's cost over Σ|u|, but, where nothing limits the moments,
/// no more than what ∇cost is of moments that cost as much as the time; 0 where it is given.
double worth_by_duration(const StoredMotion& motion);

/// What ∇cost is at least, (N m) s, for a motion may go on by itself at no cost: in a gait that of moments a thousandth of what would bring
/// it to rest in its time; in a maneuver that begins in motion that of moments whose own round-off is as large as what counts as none
/// beside them, but, unless the moments are round-off themselves, no more than keeps what the tolerance allows within proof_mark of theirs;
/// 0 of others.
double gradient_of_coasting(const StoredMotion& motion);

/// About what turns of the joints add to ∇cost where they cost, (N m) s: a moment at one node turns its joint ever after, as if nothing
/// else acted and inertia stayed that of the start; 0 without a weight of angular velocity.
double gradient_by_later_turns(const StoredMotion& motion);

/// About what a worth of displacement adds to ∇cost, (N m) s, without limits and other costs; 0 without one.
double gradient_by_displacement(const StoredMotion& motion);

/// The largest of these four, which ∇cost counts as at least.
double least_gradient(const StoredMotion& motion);

/// Typical size of each entry of a state's perturbation when turns and shifts, by the unit of length, are of size 1 over `duration` s.
VectorXd state_scale(const StoredMotion& motion, double duration);

/// Jacobian of functionals of the end state by the free numbers, by one backward sweep along the stored steps. Along a
/// motion where perturbations grow by a factor G its rows agree with each other but for 1/G, so rank is lost from G =
/// 1e10 or so.
MatrixXd control_jacobian(const StoredMotion& motion, const ControlSpace& space, const MatrixXd& end_rows);

/// Rows that span the same space as those of control_jacobian, also where perturbations grow beyond any number:
/// costates at the ends of short segments as unknowns, tied by the segments' transition, the null space of the ties as
/// combinations.
MatrixXd spanning_rows(const StoredMotion& motion, const ControlSpace& space, const MatrixXd& end_rows);

/// ‖∇cost + Aᵀλ‖∞/‖∇cost‖∞ (equation 6.5) with λ by rank-revealing least squares; `momentum_scale` makes goal rows
/// comparable. ‖∇cost‖∞ is at least least_gradient.
/// Limits and waypoints count with the multipliers that the solution gives; a free duration and a periodic motion's free
/// start are columns beside the moments.
double kkt_residual(const StoredMotion& motion, const ControlSpace& space, double momentum_scale);

/// What round-off of the moments, a share of the largest, leaves of it: where smoothness costs their second differences do.
double round_off_of_kkt(const StoredMotion& motion, const ControlSpace& space, double moment_round_off);

}  // namespace lamprey::certificate
