// Dense rows: what they span, what is left beside them. Eigen's decompositions, compiled once.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lamprey::algebra {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The x, column by column, with basis · x nearest to the samples; the basis has independent columns.
MatrixXd least_squares(const MatrixXd& basis, const MatrixXd& samples);

/// The shortest x with rows · x = values; the rows are independent. By an orthonormal basis: normal equations would square
/// the rows' condition number.
VectorXd shortest_solution(const MatrixXd& rows, const VectorXd& values);

/// Orthonormal columns that span the null space of rows of full rank.
MatrixXd null_space(const MatrixXd& rows);

/// Indices of rows that span all of them; a row counts as dependent where less than `threshold` of the longest is left.
std::vector<int> independent_rows(const MatrixXd& rows, double threshold);

/// Orthonormal columns that span the rows, with the threshold of independent_rows.
MatrixXd span_of_rows(const MatrixXd& rows, double threshold);

/// At most as many rows as columns whose sums of squares along any direction are those of the rows.
MatrixXd condensed_rows(const MatrixXd& rows);

/// Makes rows of unit length; those no longer than this share of the longest become 0.
void normalize_rows(Eigen::Ref<MatrixXd> rows, double threshold);

/// What is left of g when the best combination of the rows is taken off: by an orthonormal basis, so that the
/// combination's coefficients, which may be large, need not be formed.
VectorXd beyond_rows(const VectorXd& g, const MatrixXd& rows, double threshold);

/// Largest singular value.
double largest_singular_value(const MatrixXd& m);

}  // namespace lamprey::algebra
