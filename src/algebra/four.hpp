// Four numbers, or two, that the processor takes at once: arithmetic is the compiler's own, entry by entry.
#pragma once

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

inline double sum(const Four& v) { return (v[0] + v[2]) + (v[1] + v[3]); }

}  // namespace lamprey::algebra
