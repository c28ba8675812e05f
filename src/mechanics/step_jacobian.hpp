// First derivatives of a forced step along many directions at once (the rates of step_balance, one row for each direction).
#pragma once

#include "mechanics/rows.hpp"
#include "mechanics/step_balance.hpp"

namespace lamprey::mechanics {

/// Many directions of a step, [bodies][directions] and [directions].
struct StepDirections {
  FreedomRows left, right;
  Rows3 displacement;                                // m, world
  std::vector<Support> left_support, right_support;  // [bodies] of those that turn on their own: where they do
  StepDirections(int bodies, Eigen::Index directions);
};

/// Rates of E⁻, E⁺ and p_x along them, and what is needed on the way.
struct StepJacobian {
  FreedomRows minus, plus;                  // [bodies][directions]
  Rows3 linear;                             // [directions]
  std::vector<SparseRows> turn, turn_next;  // [bodies]
  FreedomRows centre;
  FreedomRows force;                    // over subtrees
  FreedomRows moment, moment_next;      // through the joints
  Rows3 relative, relative_next, rate;  // of one joint
  StepJacobian(int bodies, Eigen::Index directions);
};

/// Of a body's momenta, by its turn η at k, its turn η' at k + 1 and the displacement δ of its mass centre; what its
/// BodyBlock does not hold.
struct BodyRates {
  Matrix3d force_by_left, moment_by_left;  // P (world) and π⁻ by η
  Matrix3d next_by_left, next_by_shift;    // π⁺ by η and δ; by η' it is hessian.turn_by_turn
  BodyHessian hessian;                     // of the body's share
};

/// Both for all bodies, [bodies], from the Hessians of their shares.
void body_rates(const ForcedStep& step, const DiscreteMomenta& momenta, std::vector<BodyBlock>& blocks,
                std::vector<BodyRates>& rates);

/// Rates of E⁻, E⁺ and p_x along the first `count` directions, the moments held: minus, plus and linear. The first
/// `left_count`, a multiple of four, have left turns alone, the others right turns and displacements alone.
void rates_at_both_ends(const ForcedStep& step, const StepBalance& balance, const std::vector<BodyBlock>& blocks,
                        const std::vector<BodyRates>& rates, const StepDirections& directions, Eigen::Index left_count,
                        Eigen::Index count, StepJacobian& result);

/// Body-frame turns of all bodies along rows of freedoms.
void turns_of_rows(const model::System& system, const Rotations& R, const FreedomRows& freedoms,
                   const std::vector<Support>& supports, RowRange range, std::vector<SparseRows>& turns);

/// Turns of a joint's child against its parent, child's frame, from the bodies' turns.
void relative_rows(const model::Joint& joint, const Matrix3d& child_to_parent, const std::vector<SparseRows>& turns,
                   RowRange range, Rows3& relative);

/// Sums rows over subtrees, in place.
void sum_row_subtrees(const model::System& system, RowRange range, FreedomRows& force);

/// weight × U of unit moments of all actuated directions at a node, [freedoms][controls].
void control_columns(const model::System& system, const Rotations& R, double weight,
                     Eigen::Ref<Eigen::MatrixXd> columns);

}  // namespace lamprey::mechanics
