// Operators between matrices do what they say, wherever operands and result lie in memory, and give matrices.
#include <gtest/gtest.h>

#include <type_traits>

#include <Eigen/Dense>

#include "chains.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

MatrixXd random_matrix(Random& random, Index rows, Index columns) {
  MatrixXd m(rows, columns);
  for (double& entry : m.reshaped()) entry = random.normal();
  return m;
}

template <typename Left, typename Right>
MatrixXd summed(const Left& A, const Right& B) {
  MatrixXd sum = MatrixXd::Zero(A.rows(), B.cols());
  for (Index i = 0; i < A.rows(); ++i)
    for (Index j = 0; j < B.cols(); ++j)
      for (Index k = 0; k < A.cols(); ++k) sum(i, j) += A.coeff(i, k) * B.coeff(k, j);
  return sum;
}

// Every way of asking for A B, into columns, rows and parts of a matrix.
template <typename Left, typename Right>
void expect_products(const Left& A, const Right& B, Random& random) {
  const MatrixXd expected = summed(A, B);
  const double tolerance = 1e-13 * static_cast<double>(A.cols() + 1) * (1.0 + expected.cwiseAbs().sum());
  const auto near = [&](const MatrixXd& found, const MatrixXd& wanted, const char* how) {
    ASSERT_EQ(found.rows(), wanted.rows()) << how;
    ASSERT_EQ(found.cols(), wanted.cols()) << how;
    if (found.size() == 0) return;
    EXPECT_LE((found - wanted).cwiseAbs().maxCoeff(), tolerance)
        << how << ", " << A.rows() << " x " << A.cols() << " x " << B.cols();
  };
  const MatrixXd before = random_matrix(random, A.rows(), B.cols());
  near(A * B, expected, "new");
  MatrixXd whole = before;
  whole += A * B;
  near(whole, before + expected, "added");
  whole = before;
  whole.noalias() -= A * B;
  near(whole, before - expected, "taken away");
  whole = before;
  whole.noalias() += 2.5 * A * (-B);
  near(whole, before - 2.5 * expected, "scaled");
  RowMajor rows = before;
  rows.noalias() += A * B;
  near(rows, before + expected, "by rows");
  MatrixXd larger = MatrixXd::Constant(A.rows() + 2, B.cols() + 3, 7.0);
  larger.block(1, 2, A.rows(), B.cols()) = A * B;
  near(larger.block(1, 2, A.rows(), B.cols()), expected, "part");
  EXPECT_EQ(larger.row(0).minCoeff(), 7.0);
  EXPECT_EQ(larger.col(0).maxCoeff(), 7.0);
  MatrixXd turned = before.transpose();
  turned.transpose().noalias() += A * B;
  near(turned.transpose(), before + expected, "transposed");
}

void expect_products_of_sizes(Index n, Index depth, Index m) {
  Random random(17);
  const MatrixXd A = random_matrix(random, n, depth), B = random_matrix(random, depth, m);
  const MatrixXd A_around = random_matrix(random, n + 3, depth + 2), B_around = random_matrix(random, depth + 1, m + 4);
  const MatrixXd A_turned = A.transpose();
  const RowMajor A_rows = A, B_rows = B;
  expect_products(A, B, random);
  expect_products(A_turned.transpose(), B, random);
  expect_products(A_rows, B, random);
  expect_products(A, B_rows, random);
  expect_products(A_around.block(2, 1, n, depth), B_around.block(1, 3, depth, m), random);
  expect_products(A_around.block(2, 1, n, depth), MatrixXd(B.transpose()).transpose(), random);
  if (n > 0 && m > 0 && depth > 0) {
    expect_products(A.row(n - 1), B, random);
    expect_products(A, B.col(m - 1), random);
    expect_products(A.row(n - 1), B.col(0), random);
    expect_products(A.col(0), B.row(0), random);
    expect_products(A_rows.row(0), B_rows.col(m - 1), random);
  }
}

TEST(Products, are_the_sums_that_define_them) {
  for (const Index n : {0, 1, 4, 7, 30})
    for (const Index depth : {0, 1, 6, 29})
      for (const Index m : {0, 1, 3, 8, 31}) expect_products_of_sizes(n, depth, m);
}

TEST(ProductsOfFixedSize, agree_with_those_of_any_size) {
  Random random(19);
  const Eigen::Matrix3d R = random_matrix(random, 3, 3);
  const Eigen::Matrix<double, 6, 6> M = random_matrix(random, 6, 6);
  const Eigen::Matrix<double, 3, Eigen::Dynamic> wide = random_matrix(random, 3, 11);
  expect_products(R, wide, random);
  expect_products(wide.transpose(), R, random);
  expect_products(M, MatrixXd(random_matrix(random, 6, 2)), random);
  expect_products(wide, wide.transpose(), random);
}

// Sums, differences and multiples, entry by entry.
template <typename Left, typename Right>
void expect_sums(const Left& A, const Right& B) {
  const MatrixXd sum = A + B, difference = A - B, multiple = 2.5 * A, other = A * 2, negative = -A, part = A / 4.0;
  const MatrixXd chained = 2.0 * (A + B) - A + B, begun = (A - B) + A;  // temporaries are written into
  ASSERT_EQ(sum.rows(), A.rows());
  ASSERT_EQ(sum.cols(), A.cols());
  for (Index i = 0; i < A.rows(); ++i)
    for (Index j = 0; j < A.cols(); ++j) {
      const double a = A.coeff(i, j), b = B.coeff(i, j), round_off = 1e-14 * (std::abs(a) + std::abs(b));
      EXPECT_EQ(sum(i, j), a + b);
      EXPECT_EQ(difference(i, j), a - b);
      EXPECT_EQ(multiple(i, j), 2.5 * a);
      EXPECT_EQ(other(i, j), 2.0 * a);
      EXPECT_EQ(negative(i, j), -a);
      EXPECT_EQ(part(i, j), a / 4.0);
      EXPECT_NEAR(chained(i, j), a + 3.0 * b, round_off);
      EXPECT_NEAR(begun(i, j), 2.0 * a - b, round_off);
    }
}

TEST(Sums, are_those_of_the_entries) {
  Random random(29);
  for (const Index n : {0, 1, 5})
    for (const Index m : {1, 4}) {
      const MatrixXd A = random_matrix(random, n, m), B = random_matrix(random, n, m), turned = B.transpose();
      const MatrixXd around = random_matrix(random, n + 2, m + 1);
      const RowMajor rows = A;
      expect_sums(A, B);
      expect_sums(turned.transpose(), rows);
      expect_sums(around.block(1, 1, n, m), A);
      expect_sums(B, around.block(2, 0, n, m));
      expect_sums(A.cwiseAbs(), B);
      if (n > 0) expect_sums(A.row(n - 1), around.row(0).head(m));
      if (n == 5 && m == 4) expect_sums(A.topLeftCorner<3, 3>(), Eigen::Matrix3d(B.bottomRightCorner<3, 3>()));
    }
  const Eigen::Vector3d v(1.0, 2.0, 3.0);
  const Eigen::Matrix3d R = random_matrix(random, 3, 3);
  expect_sums(v, R.col(1));
  expect_sums(R, Eigen::Matrix3d::Identity());
  expect_sums(R.transpose(), R);
  expect_sums(R.row(2), v.transpose());
}

TEST(Sums, are_matrices) {
  const Eigen::Vector3d v = Eigen::Vector3d::Ones();
  const Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  const Eigen::VectorXd x = Eigen::VectorXd::Ones(6);
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> few = Eigen::MatrixXd::Ones(3, 5);
  static_assert(std::is_same_v<decltype(v + v), Eigen::Vector3d>);
  static_assert(std::is_same_v<decltype(R * (v - v)), Eigen::Vector3d>);
  static_assert(std::is_same_v<decltype(R.transpose() * R), Eigen::Matrix3d>);
  static_assert(std::is_same_v<decltype(x.head<3>() + v), Eigen::Vector3d>);
  static_assert(std::is_same_v<decltype(v * v.transpose()), Eigen::Matrix3d>);
  static_assert(std::is_same_v<decltype(-x), Eigen::VectorXd>);
  static_assert(std::is_same_v<decltype(2.0 * few), std::remove_const_t<decltype(few)>>,
                "no heap where none is needed");
  EXPECT_EQ((R * few).cols(), 5);
  EXPECT_TRUE((x.transpose() + x.transpose()).isConstant(2.0));
}

TEST(OperationsInPlace, change_what_they_are_given) {
  Random random(31);
  MatrixXd C = random_matrix(random, 6, 5);
  const MatrixXd before = C, A = random_matrix(random, 5, 3), B = random_matrix(random, 6, 3);
  algebra::add_multiple(0.5, B, C.middleCols(1, 3));
  EXPECT_TRUE(C.middleCols(1, 3).isApprox(before.middleCols(1, 3) + 0.5 * B, 1e-14));
  EXPECT_EQ(C.col(0), before.col(0));
  algebra::set_product(B, A.transpose(), C);
  EXPECT_TRUE(C.isApprox(summed(B, A.transpose()), 1e-13));
  algebra::add_product(-1.0, B, A.transpose(), C);
  EXPECT_LE(C.norm(), 1e-13 * before.norm());
}

TEST(ProductsInPlace, may_change_an_operand) {
  Random random(23);
  MatrixXd A = random_matrix(random, 5, 5);
  const MatrixXd expected = summed(A, A);
  A = A * A;
  EXPECT_LE((A - expected).norm(), 1e-13 * expected.norm());
}

}  // namespace
}  // namespace lamprey::tests
