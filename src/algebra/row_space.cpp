#include "algebra/row_space.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace lamprey::algebra {

namespace {

using Pivoted = Eigen::ColPivHouseholderQR<MatrixXd>;

Pivoted factored(const MatrixXd& rows, double threshold) {
  Pivoted qr(rows.transpose());
  qr.setThreshold(threshold);
  return qr;
}

}  // namespace

MatrixXd least_squares(const MatrixXd& basis, const MatrixXd& samples) {
  if (basis.cols() == 0) return MatrixXd::Zero(0, samples.cols());
  return Pivoted(basis).solve(samples);
}

VectorXd shortest_solution(const MatrixXd& rows, const VectorXd& values) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(rows).solve(values);
}

MatrixXd null_space(const MatrixXd& rows) {
  const Eigen::Index free = rows.cols() - rows.rows();
  if (rows.rows() == 0) return MatrixXd::Identity(free, free);
  MatrixXd last = MatrixXd::Zero(rows.cols(), free);
  last.bottomRows(free).setIdentity();
  return Pivoted(rows.transpose()).householderQ() * last;
}

std::vector<int> independent_rows(const MatrixXd& rows, double threshold) {
  if (rows.rows() == 0) return {};
  const Pivoted qr = factored(rows, threshold);
  const auto& order = qr.colsPermutation().indices();
  return std::vector<int>(order.data(), order.data() + qr.rank());
}

MatrixXd span_of_rows(const MatrixXd& rows, double threshold) {
  if (rows.rows() == 0) return MatrixXd::Zero(rows.cols(), 0);
  // Gram and Schmidt's way, the longest remainder next, each freed of the span twice: reflections would leave round-off in
  // columns where all rows are exactly zero, which then passes for something that is reached
  MatrixXd left = rows.transpose(), span(rows.cols(), 0);
  double longest = 0.0;
  while (span.cols() < std::min(rows.rows(), rows.cols())) {
    Eigen::Index next = 0;
    const double length = left.colwise().norm().maxCoeff(&next);
    longest = std::max(longest, length);
    if (!(length > threshold * longest)) break;
    VectorXd direction = left.col(next) / length;
    direction -= span * (span.transpose() * direction);
    direction.normalize();
    span.conservativeResize(Eigen::NoChange, span.cols() + 1);
    span.rightCols<1>() = direction;
    left -= direction * (direction.transpose() * left);
    left.col(next).setZero();
  }
  return span;
}

MatrixXd condensed_rows(const MatrixXd& rows) {
  if (rows.rows() <= rows.cols()) return rows;
  const Eigen::HouseholderQR<MatrixXd> qr(rows);
  return qr.matrixQR().topRows(rows.cols()).triangularView<Eigen::Upper>();
}

void normalize_rows(Eigen::Ref<MatrixXd> rows, double threshold) {
  if (rows.rows() == 0) return;
  const double longest = rows.rowwise().norm().maxCoeff();
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const double length = rows.row(r).norm();
    rows.row(r) *= length > threshold * longest ? 1.0 / length : 0.0;
  }
}

VectorXd beyond_rows(const VectorXd& g, const MatrixXd& rows, double threshold) {
  if (rows.rows() == 0) return g;
  const Pivoted qr = factored(rows, threshold);
  MatrixXd left = qr.householderQ().adjoint() * MatrixXd(g);
  left.topRows(qr.rank()).setZero();
  return qr.householderQ() * left;
}

double largest_singular_value(const MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(m.transpose() * m, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues().tail<1>()[0]);
}

}  // namespace lamprey::algebra
