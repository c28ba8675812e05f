// Sums, differences, multiples and products of Eigen's matrices, evaluated at once: A + B is a matrix, and not one more
// expression type for the compiler to instantiate. Formulas look the same. Every source of Lamprey begins with this header
// (CMakeLists.txt sees to it), so that the same formula is the same functions everywhere.
#pragma once

#include <type_traits>
#include <utility>

#include <Eigen/Core>

namespace lamprey::algebra {

using Eigen::Dynamic;
using Eigen::Index;

/// Entries of a matrix wherever they lie: (i, j) at data[i * down + j * right].
struct Entries {
  double* data;
  Index rows, columns, down, right;
};

/// C = a A + b B and C = a A, where C may be A or B; C = A B and C += factor A B, where it may not.
void set_sum(double a, const Entries& A, double b, const Entries& B, const Entries& C);
void set_multiple(double a, const Entries& A, const Entries& C);
void set_product(const Entries& A, const Entries& B, const Entries& C);
void add_product(double factor, const Entries& A, const Entries& B, const Entries& C);

/// Matrices, vectors, their parts and transposes, and every expression that Eigen still makes of them.
template <typename T>
concept Dense = requires {
  typename T::StorageKind;
  typename T::PlainObject;
  requires std::is_same_v<typename T::Scalar, double>;
  requires std::is_same_v<typename T::StorageKind, Eigen::Dense>;
  requires std::is_same_v<typename Eigen::internal::traits<T>::XprKind, Eigen::MatrixXpr>;
};

// Return types are named before a constraint is asked, of whatever stands beside an operator: what is no matrix has a size too.
template <typename T>
inline constexpr int rows_of = Dynamic;
template <Dense T>
inline constexpr int rows_of<T> = T::RowsAtCompileTime;
template <typename T>
inline constexpr int columns_of = Dynamic;
template <Dense T>
inline constexpr int columns_of<T> = T::ColsAtCompileTime;
template <typename T>
inline constexpr bool fixed_size = T::SizeAtCompileTime != Dynamic;
template <typename T>
inline constexpr bool in_memory = bool(Eigen::internal::has_direct_access<T>::ret);

constexpr bool may_equal(int size, int other) { return size == other || size == Dynamic || other == Dynamic; }
constexpr int known(int size, int other) { return size == Dynamic ? other : size; }

template <typename A, typename B>
concept OneShape = Dense<A> && Dense<B> && may_equal(rows_of<A>, rows_of<B>) && may_equal(columns_of<A>, columns_of<B>);
template <typename A, typename B>
concept Chained = Dense<A> && Dense<B> && may_equal(columns_of<A>, rows_of<B>);
template <typename A>
concept Temporary = Dense<A> && !fixed_size<A> && std::is_same_v<A, typename A::PlainObject>;  // to be written into
template <typename A, typename B>
concept AllFixed = fixed_size<A> && fixed_size<B>;

// Sizes that are known to be at most so many need no heap.
template <int rows, int columns, int most_rows = rows, int most_columns = columns>
using Plain = Eigen::Matrix<double, rows, columns, rows == 1 && columns != 1 ? Eigen::RowMajor : Eigen::ColMajor,
                            most_rows, most_columns>;
template <typename A>
using PlainOf = Plain<rows_of<A>, columns_of<A>, A::MaxRowsAtCompileTime, A::MaxColsAtCompileTime>;
template <typename A, typename B>
using SumOf = Plain<known(rows_of<A>, rows_of<B>), known(columns_of<A>, columns_of<B>),
                    known(A::MaxRowsAtCompileTime, B::MaxRowsAtCompileTime),
                    known(A::MaxColsAtCompileTime, B::MaxColsAtCompileTime)>;
template <typename A, typename B>
using ProductOf = Plain<rows_of<A>, columns_of<B>, A::MaxRowsAtCompileTime, B::MaxColsAtCompileTime>;

/// The entries of an expression that has them in memory.
template <typename A>
Entries entries_of(const A& x) {
  return {const_cast<double*>(x.data()), x.rows(), x.cols(), x.rowStride(), x.colStride()};
}

/// For loops that ask for no memory: C += factor A; C = A B; C += factor A B, where C is not A or B. C may be a part of a matrix.
template <Dense A, typename C>
void add_multiple(double factor, const A& a, C&& c) {
  eigen_assert(a.rows() == c.rows() && a.cols() == c.cols());
  set_sum(1.0, entries_of(c), factor, entries_of(a), entries_of(c));
}
template <Dense A, Dense B, typename C>
void set_product(const A& a, const B& b, C&& c) {
  eigen_assert(a.rows() == c.rows() && a.cols() == b.rows() && b.cols() == c.cols());
  set_product(entries_of(a), entries_of(b), entries_of(c));
}
template <Dense A, Dense B, typename C>
void add_product(double factor, const A& a, const B& b, C&& c) {
  eigen_assert(a.rows() == c.rows() && a.cols() == b.rows() && b.cols() == c.cols());
  add_product(factor, entries_of(a), entries_of(b), entries_of(c));
}

/// The expression itself where it is in memory, else its values.
template <Dense A>
decltype(auto) in_place(const A& x) {
  if constexpr (in_memory<A>)
    return (x);
  else
    return typename A::PlainObject(x);
}

/// A matrix of fixed size, by columns, with these values: itself where it is one.
template <int rows, int columns, int order>
requires(order == Plain<rows, columns>::Options) const Plain<rows, columns>& plain(
    const Eigen::Matrix<double, rows, columns, order>& x) {
  return x;
}
template <Dense A>
PlainOf<A> plain(const A& x) {
  if constexpr (in_memory<A>) {
    PlainOf<A> result;
    const double* from = x.data();
    const Index down = x.rowStride(), right = x.colStride();
    for (int j = 0; j < columns_of<A>; ++j)
      for (int i = 0; i < rows_of<A>; ++i) result.data()[j * rows_of<A> + i] = from[i * down + j * right];
    return result;
  } else {
    return PlainOf<A>(x);
  }
}

/// a + b, or a - b where the sign is negative.
template <int sign, typename M>
M sum(const M& a, const M& b) {
  M result;
  for (int i = 0; i < M::SizeAtCompileTime; ++i)
    result.data()[i] = sign > 0 ? a.data()[i] + b.data()[i] : a.data()[i] - b.data()[i];
  return result;
}

template <typename M>
M multiple(double factor, const M& a) {
  M result;
  for (int i = 0; i < M::SizeAtCompileTime; ++i) result.data()[i] = factor * a.data()[i];
  return result;
}

/// A B of fixed sizes, both by columns, A's entry (i, k) at i * down + k * right.
template <int rows, int depth, int columns, int down, int right>
Plain<rows, columns> product(const double* a, const double* b) {
  Plain<rows, columns> result;
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i) {
      double value = a[i * down] * b[j * depth];
      for (int k = 1; k < depth; ++k) value += a[i * down + k * right] * b[j * depth + k];
      result.data()[j * rows + i] = value;
    }
  return result;
}

/// The same of whatever there is.
template <int sign, Dense A, Dense B>
SumOf<A, B> sum_of(const A& a, const B& b) {
  if constexpr (AllFixed<A, B>) {
    return sum<sign>(plain(a), plain(b));
  } else {
    eigen_assert(a.rows() == b.rows() && a.cols() == b.cols());
    decltype(auto) left = in_place(a);
    decltype(auto) right = in_place(b);
    SumOf<A, B> result(a.rows(), a.cols());
    set_sum(1.0, entries_of(left), sign, entries_of(right), entries_of(result));
    return result;
  }
}

}  // namespace lamprey::algebra

namespace lamprey {

template <typename A, typename B>
requires algebra::OneShape<A, B> algebra::SumOf<A, B>
operator+(const A& a, const B& b) { return algebra::sum_of<1>(a, b); }

template <typename A, typename B>
requires algebra::OneShape<A, B> algebra::SumOf<A, B>
operator-(const A& a, const B& b) { return algebra::sum_of<-1>(a, b); }

// The same into memory that nobody else needs.

template <typename A, typename B>
requires(algebra::OneShape<A, B>&& algebra::Temporary<A>) A operator+(A&& a, const B& b) {
  algebra::add_multiple(1.0, algebra::in_place(b), a);
  return std::forward<A>(a);
}

template <typename A, typename B>
requires(algebra::OneShape<A, B>&& algebra::Temporary<A>) A operator-(A&& a, const B& b) {
  algebra::add_multiple(-1.0, algebra::in_place(b), a);
  return std::forward<A>(a);
}

template <typename Factor, typename A>
requires(std::is_arithmetic_v<Factor>&& algebra::Temporary<A>) A operator*(const Factor& factor, A&& a) {
  algebra::set_multiple(static_cast<double>(factor), algebra::entries_of(a), algebra::entries_of(a));
  return std::forward<A>(a);
}

template <typename Factor, typename A>
requires(std::is_arithmetic_v<Factor>&& algebra::Dense<A>) algebra::PlainOf<A>
operator*(const Factor& factor, const A& a) {
  using namespace algebra;
  if constexpr (fixed_size<A>) {
    return multiple(static_cast<double>(factor), plain(a));
  } else {
    decltype(auto) from = in_place(a);
    PlainOf<A> result(a.rows(), a.cols());
    set_multiple(static_cast<double>(factor), entries_of(from), entries_of(result));
    return result;
  }
}

template <typename A, typename Factor>
requires(std::is_arithmetic_v<Factor>&& algebra::Dense<A>) algebra::PlainOf<A>
operator*(const A& a, const Factor& factor) { return factor * a; }

template <typename A, typename Divisor>
requires(std::is_arithmetic_v<Divisor>&& algebra::Dense<A>) algebra::PlainOf<A>
operator/(const A& a, const Divisor& divisor) {
  algebra::PlainOf<A> result(a);
  for (Eigen::Index i = 0; i < result.size(); ++i) result.data()[i] /= static_cast<double>(divisor);
  return result;
}

template <typename A>
requires algebra::Dense<A> algebra::PlainOf<A>
operator-(const A& a) { return -1.0 * a; }

template <typename A, typename B>
requires algebra::Chained<A, B> algebra::ProductOf<A, B>
operator*(const A& a, const B& b) {
  using namespace algebra;
  constexpr int rows = rows_of<A>, depth = columns_of<A>;
  if constexpr (AllFixed<A, B>) {
    return product<rows, depth, columns_of<B>, 1, rows>(plain(a).data(), plain(b).data());
  } else {
    eigen_assert(a.cols() == b.rows());
    decltype(auto) left = in_place(a);
    decltype(auto) right = in_place(b);
    ProductOf<A, B> result(a.rows(), b.cols());
    set_product(entries_of(left), entries_of(right), entries_of(result));
    return result;
  }
}

/// Aᵀ B of fixed sizes, without a copy of Aᵀ.
template <int rows, int depth, typename B>
requires(rows > 1 && depth > 1 && algebra::Dense<B> && algebra::fixed_size<B> &&
         algebra::may_equal(depth, algebra::rows_of<B>)) algebra::Plain<rows, algebra::columns_of<B>>
operator*(const Eigen::Transpose<const Eigen::Matrix<double, depth, rows>>& a, const B& b) {
  using namespace algebra;
  return product<rows, depth, columns_of<B>, depth, 1>(a.nestedExpression().data(), plain(b).data());
}

}  // namespace lamprey
