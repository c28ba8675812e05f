// Options of a solve and its Outcome, the same for every solver.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace lamprey::optimizer {

struct Options {
  double tolerance = 1e-10;  // scaled KKT error
  int max_iterations = 500;
  int most_iterations = std::numeric_limits<int>::max();  // of an outcome in all, however many times it is gone on with
  int patience = 1;  // so many times as many, as long as the cost goes on falling; of StageNewton
  double time_limit = std::numeric_limits<double>::infinity();  // s, wall clock
  bool exact_limits = true;    // of solve_within_limits: end with the limits that hold as equalities
  bool near_solution = false;  // the start is close: cheap pivoting in the factorisation will do
  // Asked once an iteration; may be empty: whether someone ends it, and whether the time is over before time_limit is.
  std::function<bool()> interrupted, out_of_time;

  bool late(double seconds) const { return seconds > time_limit || (out_of_time && out_of_time()); }
};

enum class Termination { converged, feasible, infeasible, stalled, time_limit, interrupted };

struct Iteration {
  int iteration;
  double objective;
  double infeasibility;       // largest violation
  double dual_infeasibility;  // largest entry of the Lagrangian's gradient
  double goal_error;
  double step;                                              // length along the search direction, in [0, 1]
  double drift = std::numeric_limits<double>::quiet_NaN();  // of StageProgram
};

struct Outcome {
  Termination termination = Termination::stalled;
  std::string reason = "it was not begun";  // one clause for a person
  Eigen::VectorXd point;                    // [variables]
  Eigen::VectorXd multipliers;              // [constraints]
  double objective = std::numeric_limits<double>::quiet_NaN();
  double infeasibility = std::numeric_limits<double>::infinity();
  int iterations = 0;
  int evaluations = 0;
  std::vector<Iteration> history;
};

}  // namespace lamprey::optimizer
