#include "optimizer/small_dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// All heights and widths of the tiles that products are made of, as blocks of larger matrices.
template <typename Check>
void for_sizes(const Check& check) {
  for (Index rows = 0; rows <= 26; ++rows)
    for (Index columns = 0; columns <= 6; ++columns)
      for (Index depth : {0, 1, 5}) check(rows, depth, columns);
}

TEST(SmallDense, products_are_those_of_the_definition) {
  for_sizes([](Index rows, Index depth, Index columns) {
    const MatrixXd a = MatrixXd::Random(rows + 2, depth + 1), b = MatrixXd::Random(depth + 3, columns + 2);
    const auto A = a.bottomLeftCorner(rows, depth);
    const auto B = b.topRightCorner(depth, columns);
    MatrixXd c = MatrixXd::Random(rows + 1, columns + 1);
    MatrixXd expected = c;
    expected.topLeftCorner(rows, columns) += -2.0 * (A.lazyProduct(B));
    optimizer::add_product(-2.0, A, B, c.topLeftCorner(rows, columns));
    EXPECT_LE((c - expected).norm(), tolerance(1e-14)) << rows << " x " << depth << " x " << columns;
    const MatrixXd Bt = B.transpose();
    expected.topLeftCorner(rows, columns) += 3.0 * A.lazyProduct(B);
    optimizer::add_product_transposed(3.0, A, Bt, c.topLeftCorner(rows, columns));
    EXPECT_LE((c - expected).norm(), tolerance(2e-14)) << rows << " x " << depth << " x " << columns;
  });
}

TEST(SmallDense, images_of_vectors_are_those_of_the_definition) {
  for_sizes([](Index rows, Index, Index columns) {
    const MatrixXd A = MatrixXd::Random(rows, columns);
    const VectorXd x = VectorXd::Random(columns), z = VectorXd::Random(rows);
    VectorXd y = z, w = x;
    optimizer::add_image(-1.5, A, x, y);
    optimizer::add_transposed_image(0.5, A, z, w);
    EXPECT_LE((y - (z - 1.5 * A * x)).norm(), tolerance(1e-14));
    EXPECT_LE((w - (x + 0.5 * A.transpose() * z)).norm(), tolerance(1e-14));
  });
}

TEST(SmallDense, lower_products_fill_the_lower_triangle_and_mirroring_the_rest) {
  for (Index size = 0; size <= 26; ++size) {
    const MatrixXd A = MatrixXd::Random(size, 3), At = A.transpose();
    const MatrixXd start = MatrixXd::Identity(size, size), expected = start - A * At;
    MatrixXd one = start, other = start;
    optimizer::add_lower_product_transposed(-1.0, A, A, one);
    optimizer::add_lower_product(-1.0, A, At, other);
    optimizer::mirror_lower(one);
    optimizer::mirror_lower(other);
    EXPECT_LE((one - expected).norm(), tolerance(1e-14));
    EXPECT_LE((other - expected).norm(), tolerance(1e-14));
    EXPECT_EQ(one, one.transpose());
  }
}

}  // namespace
}  // namespace lamprey::tests
