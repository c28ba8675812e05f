// Second derivatives of a forced step along many directions at once (the adjoint's rates of step_balance, one row for each
// direction).
#pragma once

#include "mechanics/step_jacobian.hpp"

namespace lamprey::mechanics {

/// How a body's momenta change along turns of three kinds: columns by η, by η' or by the displacement of its mass centre.
struct BodyMomentaRates {
  Matrix3d force, moment, next;  // of P (world), of π⁻ and of π⁺
};

struct BodySecondRates {
  BodyMomentaRates by_left, by_right, by_shift;
};

/// Rates of the adjoint along directions, and what is needed on the way.
struct StepHessian {
  FreedomRows minus, plus;  // [bodies][directions] as evaluate_adjoint_rate's
  Rows3 linear;             // [directions]
  std::vector<BodySecondRates> body;
  FreedomRows turn_change, turn_change_next, centre_change;
  FreedomRows force, moment, moment_next;
  Rows3 relative, relative_next, change, change_next, rate, rate_change;  // of one joint
  StepHessian(int bodies, Eigen::Index directions);
};

/// Along `directions`, of which the first `left_count` (a multiple of four) have left turns alone and the others right
/// turns and displacements alone, rates of the adjoint along `first`, moments held; their tangent rates J are those of
/// rates_at_both_ends. `plus` is filled for the second kind alone: what it would be for the first is in `minus`, the
/// second derivatives by both ends being symmetric.
void adjoint_rates(const ForcedStep& step, const StepBalance& balance, const std::vector<BodyBlock>& blocks,
                   const std::vector<BodyRates>& rates, const StepVariation& first, const StepRate& first_rate,
                   const StepDirections& directions, const StepJacobian& J, Eigen::Index left_count, Eigen::Index count,
                   StepHessian& result);

}  // namespace lamprey::mechanics
