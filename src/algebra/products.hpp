// Eigen's products of matrices whose sizes are known only at run time, compiled once: A * B instantiates a view of each
// operand and one call instead of a dozen expression types. Every source of Lamprey begins with this header
// (CMakeLists.txt sees to it), so that the same product is the same function everywhere.
#pragma once

#include <Eigen/Core>

namespace lamprey::algebra {

/// Entries of a matrix wherever they lie: (i, j) at data[i * down + j * right].
struct Entries {
  double* data;
  Eigen::Index rows, columns, down, right;
};

/// C += factor A B; C = factor A B. No overlap of C with A and B.
void add_product(double factor, const Entries& A, const Entries& B, const Entries& C);
void set_product(double factor, const Entries& A, const Entries& B, const Entries& C);

/// The entries of an expression that has them in memory.
template <typename Expression>
Entries entries_of(const Expression& x) {
  return {const_cast<double*>(x.data()), x.rows(), x.cols(), x.rowStride(), x.colStride()};
}

template <typename Expression>
inline constexpr bool in_memory = bool(Eigen::internal::has_direct_access<Expression>::ret);

/// An operand's entries, and the factor before them: computed first where they are not in memory.
template <typename Expression>
struct Operand {
  explicit Operand(const Expression& x) : value(x), entries(entries_of(value)) {}
  typename Expression::PlainObject value;
  Entries entries;
  double factor = 1.0;
};

template <typename Expression>
requires in_memory<Expression>
struct Operand<Expression> {
  explicit Operand(const Expression& x) : entries(entries_of(x)) {}
  Entries entries;
  double factor = 1.0;
};

template <typename Expression>
requires(!in_memory<Expression> &&
         bool(Eigen::internal::blas_traits<Expression>::HasUsableDirectAccess)) struct Operand<Expression> {
  using Scaled = Eigen::internal::blas_traits<Expression>;
  explicit Operand(const Expression& x)
      : entries(entries_of(Scaled::extract(x))), factor(Scaled::extractScalarFactor(x)) {}
  Entries entries;
  double factor;
};

/// What Eigen asks of a product: dst = A B, dst += A B, dst -= A B, dst += factor A B.
template <typename Left, typename Right>
struct Product {
  template <typename Out>
  static void evalTo(Out& dst, const Left& left, const Right& right) {
    into<set_product>(dst, left, right, 1.0);
  }
  template <typename Out>
  static void addTo(Out& dst, const Left& left, const Right& right) {
    into<add_product>(dst, left, right, 1.0);
  }
  template <typename Out>
  static void subTo(Out& dst, const Left& left, const Right& right) {
    into<add_product>(dst, left, right, -1.0);
  }
  template <typename Out>
  static void scaleAndAddTo(Out& dst, const Left& left, const Right& right, double factor) {
    into<add_product>(dst, left, right, factor);
  }

 private:
  template <auto combine, typename Out>
  static void into(Out& dst, const Left& left, const Right& right, double factor) {
    static_assert(in_memory<Out>, "the result of a product goes to a matrix or a part of one");
    const Operand<Left> A(left);
    const Operand<Right> B(right);
    combine(factor * A.factor * B.factor, A.entries, B.entries, entries_of(dst));
  }
};

template <typename Left, typename Right>
concept of_doubles = std::is_same_v<typename Left::Scalar, double> && std::is_same_v<typename Right::Scalar, double>;

/// A size is known only at run time.
template <typename Left, typename Right>
concept of_any_size = of_doubles<Left, Right> &&
    (Left::SizeAtCompileTime == Eigen::Dynamic || Right::SizeAtCompileTime == Eigen::Dynamic);

}  // namespace lamprey::algebra

namespace Eigen::internal {

template <typename Left, typename Right>
requires lamprey::algebra::of_doubles<Left, Right>
struct generic_product_impl<Left, Right, DenseShape, DenseShape, GemmProduct> : lamprey::algebra::Product<Left, Right> {
};

template <typename Left, typename Right>
requires lamprey::algebra::of_doubles<Left, Right>
struct generic_product_impl<Left, Right, DenseShape, DenseShape, GemvProduct> : lamprey::algebra::Product<Left, Right> {
};

template <typename Left, typename Right>
requires lamprey::algebra::of_any_size<Left, Right>
struct generic_product_impl<Left, Right, DenseShape, DenseShape, CoeffBasedProductMode>
    : lamprey::algebra::Product<Left, Right> {
};

template <typename Left, typename Right>
requires lamprey::algebra::of_any_size<Left, Right>
struct generic_product_impl<Left, Right, DenseShape, DenseShape, OuterProduct>
    : lamprey::algebra::Product<Left, Right> {
};

}  // namespace Eigen::internal
