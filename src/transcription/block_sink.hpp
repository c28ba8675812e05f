// Sparse matrices filled block by block: the first pass records the pattern, later passes the values, in the same order.
#pragma once

#include "optimizer/program.hpp"

namespace lamprey::transcription {

class BlockSink {
 public:
  /// An empty pattern is recorded, a filled one is followed.
  BlockSink(optimizer::SparsePattern& pattern, Eigen::VectorXd& values)
      : pattern_(pattern), values_(values), recording_(pattern.size() == 0) {
    if (!recording_) values_.resize(pattern_.size());
  }

  /// A block at (row, column).
  template <typename Derived>
  void add(int row, int column, const Eigen::MatrixBase<Derived>& expression) {
    const auto& block = expression.derived().eval();
    for (Eigen::Index c = 0; c < block.cols(); ++c)
      for (Eigen::Index r = 0; r < block.rows(); ++r)
        put(row + static_cast<int>(r), column + static_cast<int>(c), block(r, c));
  }

  /// A block of a symmetric matrix of which the lower triangle is kept: on the diagonal half of it, above it transposed.
  template <typename Derived>
  void add_symmetric(int row, int column, const Eigen::MatrixBase<Derived>& expression) {
    const auto& block = expression.derived().eval();
    for (Eigen::Index c = 0; c < block.cols(); ++c)
      for (Eigen::Index r = row == column ? c : 0; r < block.rows(); ++r) {
        const int i = row + static_cast<int>(r);
        const int j = column + static_cast<int>(c);
        put(std::max(i, j), std::min(i, j), block(r, c));
      }
  }

 private:
  void put(int row, int column, double value) {
    if (recording_) {
      pattern_.add(row, column);
    } else {
      values_[next_++] = value;
    }
  }

  optimizer::SparsePattern& pattern_;
  Eigen::VectorXd& values_;
  bool recording_;
  int next_ = 0;
};

}  // namespace lamprey::transcription
