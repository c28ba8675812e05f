// Products and elimination of small dense matrices, tens of rows, without allocation: Eigen's own for sizes known at run time are made for
// hundreds.
#pragma once

#include <Eigen/Core>

namespace lamprey::algebra {

using Eigen::Index;

/// A matrix by columns.
struct Tiled {
  const double* data;
  Index rows, columns;
  Index stride;  // between columns
};

/// Entries of a matrix wherever they lie.
struct Strided {
  const double* data;
  Index row, column;  // strides
};

/// C += factor A B, C [A.rows][columns] by columns. `lower`: C is square, and of its entries above the diagonal some are left
/// as they are. No overlap of C with A and B.
void add_tiled(double factor, const Tiled& A, const Strided& B, Index columns, double* C, Index stride,
               bool lower = false);

/// Solves A X = B in place by elimination with pivots: `equations` is (A, B), with spare rows up to a multiple of four; on
/// return B is X, and A is lost. Not finite where A is singular.
void solve_columns(Index unknowns, Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>> equations);

}  // namespace lamprey::algebra
