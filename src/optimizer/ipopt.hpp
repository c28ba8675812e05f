// Ipopt as the solver of a Program.
#pragma once

#include <mutex>

#include "optimizer/outcome.hpp"
#include "optimizer/program.hpp"

namespace lamprey::optimizer {

/// MUMPS keeps global data: who holds this is the only one in the process that uses it. Searches take it by themselves; who forks takes it
/// meanwhile, and lets go of it in the child, too, so that the child finds those data whole.
std::unique_lock<std::mutex> turn_of_ipopt();

/// Solves from `start`; with multipliers of the right length, from these too (a warm start).
/// Not converging is an Outcome with its reason. Threads of one process take turns.
Outcome solve_with_ipopt(Program& program, const Options& options, const VectorXd& start,
                         const VectorXd& multipliers = VectorXd());

}  // namespace lamprey::optimizer
