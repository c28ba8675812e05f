// Ipopt as the solver of a Program.
#pragma once

#include "optimizer/outcome.hpp"
#include "optimizer/program.hpp"

namespace lamprey::optimizer {

/// Solves from `start`; with multipliers of the right length, from these too (a warm start).
/// Not converging is an Outcome with its reason. MUMPS keeps global data: run one solve at a time in a process.
Outcome solve_with_ipopt(Program& program, const Options& options, const VectorXd& start,
                         const VectorXd& multipliers = VectorXd());

}  // namespace lamprey::optimizer
