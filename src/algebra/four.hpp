// Four numbers, or two, that the processor takes at once: arithmetic is the compiler's own, entry by entry.
#pragma once

#include <cmath>
#include <cstring>

namespace lamprey::algebra {

using Two = double __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));

/// Numbers that lie one after the other, aligned or not.
template <typename Numbers>
inline Numbers load(const double* from) {
  Numbers numbers;
  std::memcpy(&numbers, from, sizeof(Numbers));
  return numbers;
}
template <typename Numbers>
inline void store(const Numbers& numbers, double* to) {
  std::memcpy(to, &numbers, sizeof(Numbers));
}

/// Rows become columns.
inline void transpose(Four& a, Four& b, Four& c, Four& d) {
  const Four ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
}

/// Entry by entry.
inline Four square_root(const Four& v) {
  return Four{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
}

inline double sum(const Four& v) { return (v[0] + v[2]) + (v[1] + v[3]); }

}  // namespace lamprey::algebra
