// From the nodes of a motion to the arrays of a Solution.
#pragma once

#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::maneuver {

/// Fills time, position, rotation, control, joint angles, velocity and momentum of a solution from a motion's nodes.
/// μ_k = p⁻_k − (h/2) U_k at all nodes but the last, μ_N = p⁺_N + (h/2) U_N; velocities are 𝕀⁻¹ μ.
void describe_motion(const model::System& system, mechanics::DiscreteLagrangian lagrangian, double time_step,
                     const NodePath& path, Solution& solution);

/// The same of a motion by a scheme above order 2, given at the nodes of all its stages, with the moments and times of these.
/// Where two steps meet, `control` is the mean of both.
void describe_composed_motion(const model::System& system, Scheme scheme, double time_step, const NodePath& path,
                              Solution& solution);

/// Appends one node of known state and moments (marching: simulate).
void append_node(const model::System& system, double time, const integrator::State& state,
                 const mechanics::Moments& control, Solution& solution);

/// ½ Σ_k weight_k Σ_j |u_jk|², in (N m)² s.
double cost_of(const VectorXd& node_weight, const std::vector<Vectors>& control);

/// ∫ ½ Σ_j |u_j|² dt of moments that are polynomials in each step, which the scheme's own quadrature takes exactly, times effort.
double cost_of_polynomials(double effort, double time_step, const std::vector<VectorXd>& polynomial);

}  // namespace lamprey::maneuver
