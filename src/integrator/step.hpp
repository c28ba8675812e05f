// One step of a variational integrator in momentum form (chapters 4 and 8).
#pragma once

#include <vector>

#include "mechanics/joint_moments.hpp"
#include "mechanics/tree_elimination.hpp"

namespace lamprey::integrator {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mechanics::DiscreteLagrangian;
using mechanics::Freedoms;
using mechanics::Moments;
using mechanics::Rotations;
using mechanics::Vectors;

/// Configuration and momentum at a node: μ_k = p⁻_k − (h/2) U_k = p⁺_k + (h/2) U_k.
struct State {
  Rotations rotation;                    // [bodies] body → world
  Vector3d position = Vector3d::Zero();  // m, root's mass centre, world
  VectorXd momentum;                     // [velocity_count] μ: along the freedoms, then p_x in the world
};

/// The state with velocity ξ = (rates along the freedoms, ẋ).
State state_of_velocity(const model::System& system, const Rotations& rotation, const Vector3d& position,
                        const VectorXd& velocity);

/// ξ = 𝕀(R)⁻¹ μ.
VectorXd velocity_of_state(const model::System& system, const State& state);

struct StepReport {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;  // largest entry of target − p⁻, relative to the largest momentum in the step
};

/// Guesses the next step by extrapolating the last ones, of equal length; the degree is the one that would have done
/// best for the latest.
class Predictor {
 public:
  explicit Predictor(int bodies);
  void forget() { known_ = 0; }
  bool knows() const { return known_ > 0; }
  /// Takes up the unknowns of a solved step.
  void remember(const mechanics::Interval& interval);
  /// Writes a guess; times `scale` for a step whose length differs from the latest one's.
  void predict(mechanics::Interval& interval, double scale = 1.0);

 private:
  static constexpr int depth = 6;
  int known_ = 0;
  int degree_ = 1;               // how many differences the guess adds up
  std::vector<double> unknown_;  // ζ and the joints' turns of all bodies and the root's displacement, and spare zeros
  std::vector<double> difference_;  // [depth][unknowns] backward differences
};

/// Buffers of a march: no allocation after construction. Holds the latest step.
struct StepWorkspace {
  explicit StepWorkspace(const model::System& system);
  mechanics::Interval interval;
  mechanics::DiscreteMomenta momenta;
  Predictor predictor;
  double latest_time_step = 0.0;             // s, of the step that the predictor saw last
  bool begun = false;                        // the next step begins at the interval as it stands, not at a guess
  double sought_residual = 2e-14;            // where Newton stops; 0: only where another iteration no longer helps
  Freedoms target;                           // [bodies] p⁻ to reach
  Freedoms missing;                          // [bodies] target − p⁻, and Newton's correction
  Freedoms force;                            // [bodies] generalised joint moments
  Vectors base_turn;                         // [bodies] where a damped step starts
  Vectors no_force;                          // [bodies] zeros
  mechanics::JointMoments moments;           // of controls and springs
  mechanics::JointMoments damping;           // ψ⁻
  mechanics::JointMoments damping_next;      // ψ⁺
  Freedoms damping_force;                    // [bodies] along the freedoms
  std::vector<Matrix3d> damping_block;       // [bodies]
  std::vector<mechanics::BodyBlock> blocks;  // [bodies]
  mechanics::TreeElimination elimination;
};

/// Controls and springs along the freedoms, [bodies]; none act on the position.
void joint_forces(const model::System& system, const Rotations& rotation, const Moments& control, StepWorkspace& work,
                  Freedoms& force);

/// Finds the step with E⁻ = target and p_x = linear from interval.rotation, starting at the interval's turns and
/// displacement.
StepReport solve_step(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                      const Vector3d& linear, StepWorkspace& work);

/// Advances the state by one step under the moments at its two ends; on failure the state is left as it was.
StepReport advance(const model::System& system, DiscreteLagrangian lagrangian, double time_step, const Moments& control,
                   const Moments& control_next, State& state, StepWorkspace& work);

}  // namespace lamprey::integrator
