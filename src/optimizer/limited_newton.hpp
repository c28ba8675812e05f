// Newton's method for a StageProgram with limits: searches with the limits as terms of the cost that come nearer to them from
// search to search, and at last with those that hold as equalities (chapter 10).
#pragma once

#include "optimizer/stage_newton.hpp"

namespace lamprey::optimizer {

/// As StageNewton::solve where there are no limits; adds to the outcome as it does. `limit_tolerance`: of
/// StageProgram::limit_error. Termination::infeasible where limits stay violated however they weigh.
void solve_within_limits(StageNewton& newton, StageProgram& program, const Options& options, double limit_tolerance,
                         Outcome& outcome);

/// Most iterations that it may add, with limits or without.
int most_iterations(const StageProgram& program, const Options& options);

}  // namespace lamprey::optimizer
