#include "optimizer/feasibility.hpp"

#include <gtest/gtest.h>

#include "small_programs.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector2d;
using optimizer::polish_feasibility;

TEST(Polish, goes_straight_down_to_a_plane) {
  DenseProgram program = nearest_on_a_plane(VectorXd::Zero(5));
  const VectorXd begin = VectorXd::LinSpaced(5, -1.0, 2.0);
  VectorXd x = begin;
  const double left = polish_feasibility(program, x);
  const VectorXd nearest = begin - VectorXd::Constant(5, (begin.sum() - 1.0) / 5.0);
  EXPECT_LE((x - nearest).norm(), tolerance(1e-14));
  EXPECT_LE(left, tolerance(1e-15));
  EXPECT_GT((x - begin).norm(), 0.1);
}

TEST(Polish, meets_a_curved_constraint_to_round_off_and_moves_along_its_normal) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  VectorXd x = 1.01 * Vector2d(1.2, std::sqrt(2.0 - 1.44));
  const double left = polish_feasibility(program, x);
  EXPECT_LE((x - Vector2d(1.2, std::sqrt(2.0 - 1.44))).norm(), tolerance(1e-14));
  EXPECT_LE(left, tolerance(1e-15));
  VectorXd c;
  program.constraints(x, c);
  EXPECT_EQ(left, std::abs(c[0] - 2.0));
}

TEST(Polish, leaves_a_feasible_point_alone) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  VectorXd x = Vector2d(1.0, 1.0);
  EXPECT_EQ(polish_feasibility(program, x), 0.0);
  EXPECT_TRUE(x == Vector2d(1.0, 1.0));
}

TEST(Polish, tells_what_is_left_of_constraints_that_cannot_be_met) {
  DenseProgram program = rosenbrock(-1.0, -1.0);
  const VectorXd begin = Vector2d(0.5, 0.5);
  VectorXd x = begin;
  const double left = polish_feasibility(program, x);
  EXPECT_TRUE(x.allFinite());
  EXPECT_GE(left, 1.0);
  EXPECT_LE(left, 1.5) << "more than at the start";
}

TEST(Polish, does_not_worsen_a_point_where_constraints_depend_on_each_other) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  VectorXd x = Vector2d::Zero();  // the circle's centre: the Jacobian vanishes
  EXPECT_EQ(polish_feasibility(program, x), 2.0);
  EXPECT_TRUE(x == Vector2d::Zero());
}

}  // namespace
}  // namespace lamprey::tests
