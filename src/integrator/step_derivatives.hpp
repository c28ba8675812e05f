// Tangent and adjoint of one variational step, (g_k, μ_k, u_k, u_{k+1}) → (g_{k+1}, μ_{k+1}), by formula (equations
// 8.33, 8.34).
#pragma once

#include <functional>

#include "integrator/step.hpp"
#include "mechanics/step_jacobian.hpp"

namespace lamprey::integrator {

using Eigen::MatrixXd;

/// Perturbation of a state: along the freedoms (body side), δx (3, world), δμ along the freedoms, δp_x (3, world).
struct StateLayout {
  const model::System& system;
  int freedom(int body) const { return system.body(body).velocity_offset; }
  int position() const { return system.velocity_count() - 3; }
  int momentum(int body) const { return system.velocity_count() + freedom(body); }
  int linear() const { return 2 * system.velocity_count() - 3; }
  int size() const { return 2 * system.velocity_count(); }
};

/// Change of the next state by the state and by the moments at both ends of the step; moments count along
/// Joint::actuation. What a shift of the whole and the conserved p_x make is there from the beginning.
struct StepTangent {
  MatrixXd A;       // [2 velocity_count][2 velocity_count] by the state at k
  MatrixXd B;       // [2 velocity_count][controls] by u_k, 1/(N m)
  MatrixXd B_next;  // [2 velocity_count][controls] by u_{k+1}, 1/(N m)
  explicit StepTangent(const model::System& system);
};

/// Buffers of linearize_step; one for each thread.
struct TangentWorkspace {
  explicit TangentWorkspace(const model::System& system);
  mechanics::StepBalance balance;
  std::vector<mechanics::BodyRates> rates;
  std::vector<mechanics::BodyBlock> blocks;
  std::vector<Eigen::Matrix3d> damping;
  mechanics::TreeElimination elimination;
  Eigen::Index left_rows;                // where those of the right end begin
  mechanics::StepDirections directions;  // turns at k, then turns at k + 1 and the root's displacement, one at a time
  mechanics::StepJacobian jacobian;
  mechanics::FreedomRows right;   // [bodies] turns at k + 1 by the momentum at k
  mechanics::Rows3 displacement;  // and the root's displacement
  MatrixXd by_turns;              // [velocity_count][freedoms] E⁻ and p_x by turns at k
  MatrixXd next_by_right;         // [freedoms][velocity_count] E⁺ by turns at k + 1 and the displacement
  bool dense;                     // how E⁻ is inverted: whole, or through the tree
  MatrixXd equations;             // [velocity_count, up to a multiple of four][3 velocity_count − 3]
  MatrixXd by_controls;           // [freedoms][controls] impulse by moments at k, N m s/(N m)
};

/// Factors the derivative of E⁻ by the next node. Returns false where it is singular.
bool factor_step(const mechanics::ForcedStep& step, const mechanics::DiscreteMomenta& momenta,
                 std::vector<mechanics::BodyBlock>& blocks, std::vector<Eigen::Matrix3d>& damping,
                 mechanics::TreeElimination& elimination);

/// Linearises the step about `interval` as it stands (updated, not marched again), under moments u_k and u_{k+1} at its
/// ends. Where the step is singular the result is NaN.
void linearize_step(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                    const mechanics::Interval& interval, const Moments& control, const Moments& control_next,
                    TangentWorkspace& work, StepTangent& tangent);

/// Gradients, one a row, carried from the end of a step to its beginning.
struct PulledBack {
  MatrixXd by_state;         // [rows][2 velocity_count]
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
  MatrixXd by_start;    // [rows][2 velocity_count]
  MatrixXd by_control;  // [rows][nodes · controls]
};

/// One backward sweep. `end_rows` [rows][2 velocity_count] are the gradients by the last state, `control` [N+1] the moments at all
/// nodes.
SweptGradients gradient_sweep(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                              const IntervalSource& source, const std::vector<Moments>& control, StepRange range,
                              const MatrixXd& end_rows);

}  // namespace lamprey::integrator
