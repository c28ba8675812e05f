#include "algebra/operators.hpp"

#include <utility>

#include "algebra/tiles.hpp"

namespace lamprey::algebra {

namespace {

using Eigen::ColMajor;
using Eigen::MatrixXd;
using Eigen::RowMajor;
using Eigen::VectorXd;

using Column = Eigen::Map<VectorXd, 0, Eigen::InnerStride<>>;

Entries transposed(const Entries& m) { return {m.data, m.columns, m.rows, m.right, m.down}; }
bool columns_contiguous(const Entries& m) { return m.down == 1 || m.rows == 1; }
bool rows_contiguous(const Entries& m) { return m.right == 1 || m.columns == 1; }
bool contiguous_somehow(const Entries& m) { return columns_contiguous(m) || rows_contiguous(m); }

bool in_one_piece(const Entries& m) { return m.down == 1 && (m.right == m.rows || m.columns == 1); }

MatrixXd copy(const Entries& m) {
  MatrixXd result(m.rows, m.columns);
  for (Index j = 0; j < m.columns; ++j)
    for (Index i = 0; i < m.rows; ++i) result(i, j) = m.data[i * m.down + j * m.right];
  return result;
}

void put(const MatrixXd& from, const Entries& to) {
  for (Index j = 0; j < to.columns; ++j)
    for (Index i = 0; i < to.rows; ++i) to.data[i * to.down + j * to.right] = from(i, j);
}

// From here on A and B are contiguous along order, C along its columns.

template <int order>
Index stride(const Entries& m) {
  return order == ColMajor ? m.right : m.down;
}

constexpr Index tiled_sizes = 160;      // rows, columns and depth together: up to here add_tiled is faster
constexpr Index turned_entries = 1024;  // of a matrix that is laid by columns first

template <int of_A>
bool add_small(double factor, const Entries& A, const Entries& B, const Entries& C) {
  if (C.rows + C.columns + A.columns > tiled_sizes) return false;
  const Strided b{B.data, B.down, B.right};
  if (of_A == ColMajor) {
    add_tiled(factor, {A.data, A.rows, A.columns, A.right}, b, C.columns, C.data, C.right);
    return true;
  }
  if (A.rows * A.columns > turned_entries) return false;
  double turned[turned_entries];
  for (Index k = 0; k < A.columns; ++k)
    for (Index i = 0; i < A.rows; ++i) turned[k * A.rows + i] = A.data[i * A.down + k * A.right];
  add_tiled(factor, {turned, A.rows, A.columns, A.rows}, b, C.columns, C.data, C.right);
  return true;
}

template <int of_A, int of_B>
void add_large(double factor, const Entries& A, const Entries& B, const Entries& C) {
  namespace internal = Eigen::internal;
  using Blocking =
      internal::gemm_blocking_space<ColMajor, double, double, Eigen::Dynamic, Eigen::Dynamic, Eigen::Dynamic>;
  Blocking blocking(C.rows, C.columns, A.columns, 1, true);
  internal::general_matrix_matrix_product<Index, double, of_A, false, double, of_B, false, ColMajor, 1>::run(
      C.rows, C.columns, A.columns, A.data, stride<of_A>(A), B.data, stride<of_B>(B), C.data, 1, C.right, factor,
      blocking, nullptr);
}

template <int of_A, int of_B>
void add_matrix(double factor, const Entries& A, const Entries& B, const Entries& C) {
  if (!add_small<of_A>(factor, A, B, C)) add_large<of_A, of_B>(factor, A, B, C);
}

template <int order>
using Mapper = Eigen::internal::const_blas_data_mapper<double, Index, order>;

void add_image_by_columns(double factor, const Entries& A, const Entries& x, const Entries& y) {
  Eigen::internal::general_matrix_vector_product<Index, double, Mapper<ColMajor>, ColMajor, false, double,
                                                 Mapper<RowMajor>, false>::run(A.rows, A.columns, {A.data, A.right},
                                                                               {x.data, x.down}, y.data, 1, factor);
}

void add_image_by_rows(double factor, const Entries& A, const Entries& x, const Entries& y) {
  Eigen::internal::general_matrix_vector_product<Index, double, Mapper<RowMajor>, RowMajor, false, double,
                                                 Mapper<ColMajor>, false>::run(A.rows, A.columns, {A.data, A.down},
                                                                               {x.data, 1}, y.data, y.down, factor);
}

void add_dot(double factor, const Entries& A, const Entries& x, const Entries& y) {
  const Eigen::InnerStride<> along_A(A.right), along_x(x.down);
  if (A.right == 1 && x.down == 1)
    y.data[0] += factor * Eigen::Map<const VectorXd>(A.data, A.columns).dot(Eigen::Map<const VectorXd>(x.data, x.rows));
  else
    y.data[0] += factor * Column(A.data, A.columns, along_A).dot(Column(x.data, x.rows, along_x));
}

// y += factor A x for a single column x.
void add_image(double factor, const Entries& A, const Entries& x, const Entries& y) {
  if (A.rows == 1) return add_dot(factor, A, x, y);
  if (columns_contiguous(A)) {
    if (y.down == 1) return add_image_by_columns(factor, A, x, y);
    MatrixXd sum = copy(y);
    add_image_by_columns(factor, A, x, entries_of(sum));
    return put(sum, y);
  }
  if (x.down == 1) return add_image_by_rows(factor, A, x, y);
  const MatrixXd contiguous = copy(x);
  add_image_by_rows(factor, A, entries_of(contiguous), y);
}

// One column times one row.
void add_outer(double factor, const Entries& A, const Entries& B, const Entries& C) {
  for (Index j = 0; j < C.columns; ++j) {
    const double share = factor * B.data[j * B.right];
    double* to = C.data + j * C.right;
    for (Index i = 0; i < C.rows; ++i) to[i] += share * A.data[i];
  }
}

void add_to_columns(double factor, const Entries& A, const Entries& B, const Entries& C) {
  if (A.columns == 1 && A.down == 1) return add_outer(factor, A, B, C);
  if (columns_contiguous(A))
    columns_contiguous(B) ? add_matrix<ColMajor, ColMajor>(factor, A, B, C)
                          : add_matrix<ColMajor, RowMajor>(factor, A, B, C);
  else
    columns_contiguous(B) ? add_matrix<RowMajor, ColMajor>(factor, A, B, C)
                          : add_matrix<RowMajor, RowMajor>(factor, A, B, C);
}

}  // namespace

void add_product(double factor, const Entries& A, const Entries& B, const Entries& C) {
  if (C.rows == 0 || C.columns == 0 || A.columns == 0) return;
  if (!contiguous_somehow(A)) {
    const MatrixXd contiguous = copy(A);
    return add_product(factor, entries_of(contiguous), B, C);
  }
  if (C.columns == 1) return add_image(factor, A, B, C);
  if (!contiguous_somehow(B)) {
    const MatrixXd contiguous = copy(B);
    return add_product(factor, A, entries_of(contiguous), C);
  }
  if (C.rows == 1) return add_image(factor, transposed(B), transposed(A), transposed(C));
  if (columns_contiguous(C)) return add_to_columns(factor, A, B, C);
  if (rows_contiguous(C)) return add_to_columns(factor, transposed(B), transposed(A), transposed(C));
  MatrixXd sum = copy(C);
  add_to_columns(factor, A, B, entries_of(sum));
  put(sum, C);
}

void set_product(const Entries& A, const Entries& B, const Entries& C) {
  const Entries along = columns_contiguous(C) ? C : transposed(C);
  for (Index j = 0; j < along.columns; ++j)
    for (Index i = 0; i < along.rows; ++i) along.data[i * along.down + j * along.right] = 0.0;
  add_product(1.0, A, B, C);
}

void set_sum(double a, const Entries& A, double b, const Entries& B, const Entries& C) {
  if (in_one_piece(A) && in_one_piece(B) && in_one_piece(C)) {
    const Index size = C.rows * C.columns;
    for (Index i = 0; i < size; ++i) C.data[i] = a * A.data[i] + b * B.data[i];
    return;
  }
  const bool by_columns = A.down == 1 && B.down == 1 && C.down == 1;
  for (Index j = 0; j < C.columns; ++j) {
    const double *from_A = A.data + j * A.right, *from_B = B.data + j * B.right;
    double* to = C.data + j * C.right;
    if (by_columns)
      for (Index i = 0; i < C.rows; ++i) to[i] = a * from_A[i] + b * from_B[i];
    else
      for (Index i = 0; i < C.rows; ++i) to[i * C.down] = a * from_A[i * A.down] + b * from_B[i * B.down];
  }
}

void set_multiple(double a, const Entries& A, const Entries& C) {
  if (in_one_piece(A) && in_one_piece(C)) {
    const Index size = C.rows * C.columns;
    for (Index i = 0; i < size; ++i) C.data[i] = a * A.data[i];
    return;
  }
  for (Index j = 0; j < C.columns; ++j)
    for (Index i = 0; i < C.rows; ++i) C.data[i * C.down + j * C.right] = a * A.data[i * A.down + j * A.right];
}

}  // namespace lamprey::algebra
