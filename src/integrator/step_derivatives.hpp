// Tangent and adjoint of one variational step, (g_k, μ_k, u_k, u_{k+1}) → (g_{k+1}, μ_{k+1}), by formula (equations
// 4.13, 4.14).
#pragma once

#include <functional>

#include "integrator/step.hpp"

namespace lamprey::integrator {

using Eigen::MatrixXd;

/// Perturbation of a state: η (3n, body side), δx (3, world), δμ (3n, body frames), δp_x (3, world).
struct StateLayout {
  int bodies;
  int rotation(int body) const { return 3 * body; }
  int position() const { return 3 * bodies; }
  int momentum(int body) const { return 3 * (bodies + 1 + body); }
  int linear() const { return 6 * bodies + 3; }
  int size() const { return 6 * bodies + 6; }
};

/// Change of the next state by the state and by the moments at both ends of the step; moments count along
/// Joint::actuation.
struct StepTangent {
  MatrixXd A;       // [6n+6][6n+6] by the state at k
  MatrixXd B;       // [6n+6][controls] by u_k, 1/(N m)
  MatrixXd B_next;  // [6n+6][controls] by u_{k+1}, 1/(N m)
  explicit StepTangent(const model::System& system);
};

/// Buffers of linearize_step; one for each thread.
struct TangentWorkspace {
  mechanics::DerivativeWorkspace derivatives;
  mechanics::StepQuadratic quadratic;
  mechanics::MomentumJacobian jacobian;
  MatrixXd given;             // [3n+3][6n+6 + controls] right-hand sides of (4.13)
  MatrixXd next;              // [3n+3][6n+6 + controls] (η', δΔx) by state and u_k
  MatrixXd moment;            // [3n+3][6n+6 + controls] (δμ', δp_x') by the same
  MatrixXd force_derivative;  // [3n][3n] derivative of U by turns
  MatrixXd force_map;         // [3n][controls] U of unit controls
  explicit TangentWorkspace(const model::System& system);
};

/// Linearises the step about `interval` as it stands (updated, not marched again), under moments u_k and u_{k+1} at its
/// ends.
void linearize_step(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                    const mechanics::Interval& interval, const Moments& control, const Moments& control_next,
                    TangentWorkspace& work, StepTangent& tangent);

/// Gradients, one a row, carried from the end of a step to its beginning.
struct PulledBack {
  MatrixXd by_state;         // [rows][6n+6]
  MatrixXd by_control;       // [rows][controls] share of u_k
  MatrixXd by_next_control;  // [rows][controls] share of u_{k+1}
};

/// Chain rule backwards through one step: rows are gradients by the state at k + 1.
PulledBack pull_back(const StepTangent& tangent, const MatrixXd& rows);

/// Fills interval k of a trajectory, updated.
using IntervalSource = std::function<void(int step, mechanics::Interval& interval)>;

/// Steps first … last − 1 of a trajectory, nodes first … last.
struct StepRange {
  int first;
  int last;
  int nodes() const { return last - first + 1; }
};

/// Gradients of functionals of a range's last state by its first state and by the moments at its nodes, node after
/// node.
struct SweptGradients {
  MatrixXd by_start;    // [rows][6n+6]
  MatrixXd by_control;  // [rows][nodes · controls]
};

/// One backward sweep. `end_rows` [rows][6n+6] are the gradients by the last state, `control` [N+1] the moments at all
/// nodes.
SweptGradients gradient_sweep(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                              const IntervalSource& source, const std::vector<Moments>& control, StepRange range,
                              const MatrixXd& end_rows);

}  // namespace lamprey::integrator
