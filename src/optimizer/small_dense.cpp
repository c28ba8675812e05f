#include "optimizer/small_dense.hpp"

#include <algorithm>
#include <cmath>

#include "algebra/four.hpp"
#include "algebra/tiles.hpp"

namespace lamprey::optimizer {

namespace {

using algebra::Four;
using algebra::load;
using algebra::store;

algebra::Strided plain(const MatrixIn& m) { return {m.data(), 1, m.outerStride()}; }
algebra::Strided transposed(const MatrixIn& m) { return {m.data(), m.outerStride(), 1}; }

void add_strided(double factor, const MatrixIn& A, const algebra::Strided& B, MatrixOut& C, bool lower) {
  algebra::add_tiled(factor, {A.data(), C.rows(), A.cols(), A.outerStride()}, B, C.cols(), C.data(), C.outerStride(),
                     lower);
}

}  // namespace

void add_product(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, plain(B), C, false);
}

void add_product_transposed(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, transposed(B), C, false);
}

void add_lower_product(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, plain(B), C, true);
}

void add_lower_product_transposed(double factor, const MatrixIn& A, const MatrixIn& B, MatrixOut C) {
  add_strided(factor, A, transposed(B), C, true);
}

void set_transposed(const MatrixIn& A, MatrixOut C) {
  const Eigen::Index stride = A.outerStride(), c_stride = C.outerStride(), rows = A.rows();
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const double* from = A.data() + j * stride;
    double* to = C.data() + j;
    for (Eigen::Index i = 0; i < rows; ++i) to[i * c_stride] = from[i];
  }
}

void mirror_lower(MatrixOut C) {
  double* c = C.data();
  const Eigen::Index stride = C.outerStride();
  for (Eigen::Index j = 0; j < C.cols(); ++j)
    for (Eigen::Index i = j + 1; i < C.rows(); ++i) c[i * stride + j] = c[j * stride + i];
}

void add_image(double factor, const MatrixIn& A, const VectorIn& x, VectorOut y) {
  algebra::add_tiled(factor, {A.data(), A.rows(), A.cols(), A.outerStride()}, {x.data(), 1, A.cols()}, 1, y.data(),
                     y.size());
}

void add_transposed_image(double factor, const MatrixIn& A, const VectorIn& x, VectorOut y) {
  const Eigen::Index rows = A.rows(), stride = A.outerStride();
  const double* v = x.data();
  double* to = y.data();
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const double* a = A.data() + j * stride;
    Four sum{};
    Eigen::Index i = 0;
    for (; i + 4 <= rows; i += 4) sum += load<Four>(a + i) * load<Four>(v + i);
    double rest = algebra::sum(sum);
    for (; i < rows; ++i) rest += a[i] * v[i];
    to[j] += factor * rest;
  }
}

}  // namespace lamprey::optimizer
