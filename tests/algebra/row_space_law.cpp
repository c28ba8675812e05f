#include "algebra/row_space.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows whose singular values fall evenly, on a logarithmic scale, from 1 to 1/condition.
MatrixXd rows_of_condition(double condition, Index rows, Index columns) {
  const Eigen::JacobiSVD<MatrixXd> random(MatrixXd::Random(rows, columns), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd values = VectorXd::LinSpaced(rows, 0.0, -std::log(condition)).array().exp();
  return random.matrixU() * values.asDiagonal() * random.matrixV().transpose();
}

TEST(RowSpace, shortest_solution_solves_rows_close_to_dependent) {
  for (const double condition : {1.0, 1e4, 1e8, 1e10}) {
    const MatrixXd rows = rows_of_condition(condition, 12, 20);
    const VectorXd values = VectorXd::Random(12);
    const VectorXd x = algebra::shortest_solution(rows, values);
    EXPECT_LE((rows * x - values).norm(), tolerance(1e-14) * (x.norm() + values.norm())) << condition;
  }
}

TEST(RowSpace, shortest_solution_has_nothing_in_the_null_space) {
  for (const double condition : {1.0, 1e4, 1e8}) {
    const MatrixXd rows = rows_of_condition(condition, 12, 20);
    const VectorXd x = algebra::shortest_solution(rows, VectorXd::Random(12));
    EXPECT_LE((algebra::null_space(rows).transpose() * x).norm(), tolerance(1e-14) * x.norm() * condition);
  }
}

// What is left beside the rows is orthogonal to them, and what they span leaves nothing.
TEST(RowSpace, nothing_is_left_beyond_rows_of_what_they_span) {
  const MatrixXd rows = rows_of_condition(1e6, 12, 20);
  const VectorXd g = VectorXd::Random(20);
  const VectorXd left = algebra::beyond_rows(g, rows, 1e-12);
  EXPECT_GT(left.norm(), 0.1);
  EXPECT_LE((rows * left).norm(), tolerance(1e-14) * g.norm());
  const VectorXd spanned = rows.transpose() * VectorXd::Random(12);
  EXPECT_LE(algebra::beyond_rows(spanned, rows, 1e-12).norm(), tolerance(1e-14));
}

// Of rows that lie next to each other, too: where all are exactly zero what they span is exactly zero.
TEST(RowSpace, what_rows_span_is_zero_where_they_are) {
  MatrixXd rows = MatrixXd::Random(4, 9);
  rows.row(2) = rows.row(0) + 1e-6 * rows.row(2);
  for (const Index column : {0, 1, 5}) rows.col(column).setZero();
  const MatrixXd span = algebra::span_of_rows(rows, 1e-9);
  ASSERT_EQ(span.cols(), 4);
  for (const Index column : {0, 1, 5}) EXPECT_TRUE(span.row(column).isZero(0.0)) << column;
  EXPECT_LE((span.transpose() * span - MatrixXd::Identity(4, 4)).norm(), tolerance(1e-14));
  EXPECT_LE((rows.transpose() - span * (span.transpose() * rows.transpose())).norm(), tolerance(1e-13));
  EXPECT_EQ(algebra::span_of_rows(rows, 1e-4).cols(), 3);
}

TEST(RowSpace, of_no_rows_is_empty) {
  const MatrixXd none(0, 5);
  EXPECT_TRUE(algebra::independent_rows(none, 1e-9).empty());
  EXPECT_EQ(algebra::span_of_rows(none, 1e-9).rows(), 5);
  EXPECT_EQ(algebra::span_of_rows(none, 1e-9).cols(), 0);
  EXPECT_EQ(algebra::least_squares(none.transpose(), MatrixXd::Ones(5, 2)).cols(), 2);
}

}  // namespace
}  // namespace lamprey::tests
