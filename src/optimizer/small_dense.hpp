// Products of small dense matrices, tens of rows, without allocation: Eigen's own for sizes known at run
// time are made for hundreds.
#pragma once

#include <Eigen/Core>

namespace lamprey::optimizer {

using MatrixIn = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using MatrixOut = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using VectorIn = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

/// C += factor A B. No overlap of C with A and B, here and below.
void add_product(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C);

/// C += factor A Bᵀ.
void add_product_transposed(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C);

/// The same for a square C, of whose entries above the diagonal some are left as they are.
void add_lower_product(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C);
void add_lower_product_transposed(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C);

/// C = Aᵀ.
void set_transposed(const MatrixIn& A, MatrixOut C);

/// Copies what is below the diagonal of a square matrix to above it.
void mirror_lower(MatrixOut C);

/// y += factor A x.
void add_image(double factor, const MatrixIn& A, const VectorIn& x, VectorOut y);

/// y += factor Aᵀx.
void add_transposed_image(double factor, const MatrixIn& A, const VectorIn& x, VectorOut y);

}  // namespace lamprey::optimizer
