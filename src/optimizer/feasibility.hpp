// Newton polish of a Program's equations.
#pragma once

#include "optimizer/program.hpp"

namespace lamprey::optimizer {

/// Largest amount by which a constraint is not met.
double largest_violation(Program& program, const VectorXd& x);

/// Moves x by the least change that meets the equality constraints and inequalities that are broken, repeated until round-off; returns the largest violation left.
/// For points next to feasible: x is changed only where that lowers the violation.
double polish_feasibility(Program& program, VectorXd& x);

}  // namespace lamprey::optimizer
