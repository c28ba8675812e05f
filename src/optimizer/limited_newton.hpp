// Newton's method for a StageProgram with limits: searches with the limits as terms of the cost, and between them new
// multipliers, until the limits are met (augmented Lagrangian; Bertsekas 1982).
#pragma once

#include "optimizer/stage_newton.hpp"

namespace lamprey::optimizer {

/// As StageNewton::solve where there are no limits. `limit_tolerance`: of StageProgram::limit_error. Termination::infeasible
/// where limits stay violated however they weigh.
Outcome solve_within_limits(StageNewton& newton, StageProgram& program, const Options& options, double limit_tolerance);

}  // namespace lamprey::optimizer
