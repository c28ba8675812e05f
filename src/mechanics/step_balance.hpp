// One forced step as a relation between momenta and configurations: μ_k = E⁻(g_k, g_{k+1}, u_k) and
// μ_{k+1} = E⁺(g_k, g_{k+1}, u_{k+1}), with first and second derivatives along directions, in time linear in the bodies
// (equations 8.27 to 8.31).
#pragma once

#include "mechanics/joint_moments.hpp"
#include "mechanics/tree_elimination.hpp"

namespace lamprey::mechanics {

/// A step with the moments at its ends.
struct ForcedStep {
  const model::System& system;
  DiscreteLagrangian lagrangian;
  double time_step;             // s
  const Interval& interval;     // updated
  const Moments& control;       // [joints] at k
  const Moments& control_next;  // [joints] at k + 1
};

/// E⁻, E⁺ and what they are made of.
struct StepBalance {
  DiscreteMomenta momenta;  // of which what body_momenta fills
  Freedoms minus;           // [bodies] E⁻ along the freedoms at k
  Freedoms plus;            // [bodies] E⁺ along the freedoms at k + 1
  Vector3d linear;          // kg m/s, world: p_x of both
  Vectors moment;           // [bodies] moments through the joints at k
  Vectors moment_next;      // [bodies] the same at k + 1
  JointMoments joint_minus, joint_plus;
  explicit StepBalance(int bodies);
};

void evaluate_balance(const ForcedStep& step, StepBalance& balance);

/// The same where balance.momenta holds what body_momenta fills.
void gather_balance(const ForcedStep& step, StepBalance& balance);

/// A direction of a step: turns of both ends, displacement of the root over the step, change of the moments.
struct StepVariation {
  Freedoms left, right;           // [bodies] along the freedoms at k and at k + 1
  Vector3d displacement;          // m, world
  Moments control, control_next;  // [joints]
  explicit StepVariation(const model::System& system);
  void set_zero();
};

/// Rates along a direction.
struct StepRate {
  // how the bodies move along it
  Vectors turn, turn_next;          // [bodies] η_i, η'_i, body frames at k and at k + 1
  Vectors centre;                   // [bodies] world
  std::vector<BodyDirection> seen;  // [bodies] a_i, b_i: change of F_i and w_i
  std::vector<char> still;          // [bodies] whether neither the body nor any on its path moves
  // what that changes
  std::vector<BodyGradient> gradient;  // [bodies] γ_i, β_i
  Vectors force;                       // [bodies] world, over subtrees
  Vectors moment, moment_next;         // [bodies] through the joints
  // tangent: rates of E⁻ and E⁺; adjoint: gradient of −E⁻·left + E⁺·right + p_x·displacement by both configurations
  Freedoms minus, plus;
  Vector3d linear;
  JointMoments joint_minus, joint_plus;
  explicit StepRate(int bodies);
};

/// Rates along a direction; the adjoint leaves the direction's moments aside.
void evaluate_rate(const ForcedStep& step, const StepBalance& balance, const StepVariation& direction, RateKind kind,
                   StepRate& rate);

/// Buffers of evaluate_adjoint_rate.
struct SecondRateWorkspace {
  Vectors turn_change, turn_change_next, centre_change;
  Vectors force, moment, moment_next;
  JointMoments joint_minus, joint_plus;
  explicit SecondRateWorkspace(int bodies);
};

/// Rate along `second` (its tangent rate known) of the adjoint along `first` (known too), whose direction is constant:
/// results as the adjoint's minus, plus and linear.
void evaluate_adjoint_rate(const ForcedStep& step, const StepBalance& balance, const StepVariation& first,
                           const StepRate& first_rate, const StepVariation& second, const StepRate& second_rate,
                           SecondRateWorkspace& work, Freedoms& minus, Freedoms& plus, Vector3d& linear);

/// Block of body n from the Hessian of its share.
void set_block(const Interval& interval, const DiscreteMomenta& momenta, const BodyHessian& hessian, std::size_t n,
               BodyBlock& block);

/// Blocks of each body of the derivative of E⁻ by g_{k+1}: what TreeElimination factors for a step.
void step_blocks(const model::System& system, DiscreteLagrangian lagrangian, double time_step, const Interval& interval,
                 const DiscreteMomenta& momenta, std::vector<BodyBlock>& blocks);

}  // namespace lamprey::mechanics
