// One step of a variational integrator in momentum form (chapter 4).
#pragma once

#include <vector>

#include "integrator/scheme.hpp"
#include "integrator/tree_newton.hpp"

namespace lamprey::integrator {

using Eigen::VectorXd;
using mechanics::DiscreteLagrangian;
using mechanics::Moments;
using mechanics::Rotations;

/// Configuration and momentum at a node: μ_k = p⁻_k − (h/2) U_k = p⁺_k + (h/2) U_k.
struct State {
  Rotations rotation;  // [bodies] body → world
  Vector3d position;   // m, root's mass centre, world
  VectorXd momentum;   // [3n+3] μ: body frames, then p_x in the world
};

/// The state with velocity ξ = (Ω_0, …, Ω_{n−1}, ẋ).
State state_of_velocity(const model::System& system, const Rotations& rotation, const Vector3d& position,
                        const VectorXd& velocity);

/// ξ = 𝕀(R)⁻¹ μ.
VectorXd velocity_of_state(const model::System& system, const State& state);

struct StepReport {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;  // largest entry of target − p⁻, relative to the largest momentum in the step
};

/// Buffers of a march: no allocation after construction. Holds the latest step and predicts the next from the last two.
struct StepWorkspace {
  explicit StepWorkspace(const model::System& system);
  mechanics::Interval interval;
  mechanics::DiscreteMomenta momenta;
  std::vector<Vector3d> target;           // [bodies] p⁻ to reach
  std::vector<Vector3d> missing;          // [bodies] target − p⁻
  std::vector<Vector3d> turns;            // [bodies] Newton's η'
  std::vector<Vector3d> cayley_base;      // [bodies] where a damped step starts
  std::vector<Vector3d> force;            // [bodies] generalised joint moments
  std::vector<Vector3d> latest_cayley;    // [bodies] ζ of the latest step
  std::vector<Vector3d> previous_cayley;  // [bodies] ζ of the step before it
  Vector3d latest_displacement;           // m
  Vector3d previous_displacement;         // m
  int history = 0;                        // 0: nothing known, 1: one step, 2: two steps
  TreeNewtonWorkspace newton;
};

/// Joint moments as body-frame generalised moments, [bodies]; none act on the position.
void joint_forces(const model::System& system, const Rotations& rotation, const Moments& control,
                  std::vector<Vector3d>& force);

/// Finds the step with p⁻ = target and p_x = linear from interval.rotation, starting at interval.cayley, .displacement.
StepReport solve_step(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                      const Vector3d& linear, StepWorkspace& work);

/// Advances the state by one step under the moments at its two ends; on failure the state is left as it was.
StepReport advance(const model::System& system, DiscreteLagrangian lagrangian, double time_step, const Moments& control,
                   const Moments& control_next, State& state, StepWorkspace& work);

}  // namespace lamprey::integrator
