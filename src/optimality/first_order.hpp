// First-order optimality in the space of controls.
#pragma once

#include "evidence/control_space.hpp"
#include "evidence/stage_motion.hpp"

namespace lamprey::optimality {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using evidence::StageMotion;
using evidence::StoredMotion;

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
MatrixXd control_jacobian(const StoredMotion& motion, const evidence::ControlSpace& space, const MatrixXd& end_rows);

/// Rows that span the same space as those of control_jacobian, also where perturbations grow beyond any number:
/// costates at the ends of short segments as unknowns, tied by the segments' transition, the null space of the ties as
/// combinations.
MatrixXd spanning_rows(const StoredMotion& motion, const evidence::ControlSpace& space, const MatrixXd& end_rows);

/// ‖∇cost + Aᵀλ‖∞/‖∇cost‖∞ (equation 6.5) with λ by rank-revealing least squares; `momentum_scale` makes goal rows
/// comparable. ‖∇cost‖∞ is at least least_gradient.
/// Limits and waypoints count with the multipliers that the solution gives; a free duration and a periodic motion's free
/// start are columns beside the moments.
double kkt_residual(const StoredMotion& motion, const evidence::ControlSpace& space, double momentum_scale);

/// What round-off of the moments, a share of the largest, leaves of it: where smoothness costs their second differences do.
double round_off_of_kkt(const StoredMotion& motion, const evidence::ControlSpace& space, double moment_round_off);

/// Jacobian of functionals of the end state by the polynomials' coefficients, [rows][N · terms · controls], by one backward
/// sweep; rank is lost along motions where perturbations grow, as by control_jacobian.
MatrixXd coefficient_jacobian(const StoredMotion& motion, const StageMotion& stages, const MatrixXd& end_rows);

/// ‖∇cost + Aᵀλ‖∞/‖∇cost‖∞ (equation 6.5) in the space of the polynomials' coefficients.
double kkt_residual(const StoredMotion& motion, const StageMotion& stages, double momentum_scale);

}  // namespace lamprey::optimality
