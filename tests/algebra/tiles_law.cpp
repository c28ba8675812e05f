// Elimination in place gives what Eigen's gives, whatever the size and the order of the equations.
#include "algebra/tiles.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

TEST(SolveColumns, finds_what_the_equations_were_made_of) {
  for (Index unknowns = 1; unknowns <= 30; ++unknowns)
    for (Index sides : {0, 1, 4, 13}) {
      MatrixXd A = MatrixXd::Random(unknowns, unknowns);
      A(0, 0) = 0.0;  // a pivot must be looked for
      if (unknowns == 1) A(0, 0) = -2.0;
      const MatrixXd X = MatrixXd::Random(unknowns, sides);
      MatrixXd equations = MatrixXd::Zero((unknowns + 3) / 4 * 4, unknowns + sides);
      equations.topRows(unknowns) << A, A * X;
      algebra::solve_columns(unknowns, equations);
      const double condition = A.norm() * A.inverse().norm();
      EXPECT_LE((equations.topRightCorner(unknowns, sides) - X).norm(), tolerance(1e-14) * condition * (1.0 + X.norm()))
          << unknowns << " unknowns, " << sides << " sides";
    }
}

TEST(SolveColumns, leaves_nothing_finite_of_singular_equations) {
  MatrixXd equations = MatrixXd::Zero(4, 3);
  equations.topRows(2) << 1.0, 2.0, 1.0, 2.0, 4.0, 1.0;
  algebra::solve_columns(2, equations);
  EXPECT_FALSE(equations.topRightCorner(2, 1).allFinite());
}

}  // namespace
}  // namespace lamprey::tests
