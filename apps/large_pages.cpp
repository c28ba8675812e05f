#include "large_pages.hpp"

#if defined(__GLIBC__)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#endif

namespace lamprey::app {

#if defined(__GLIBC__)

void use_large_pages() {
  constexpr int reserved = 256 << 20;  // bytes of the heap: of addresses alone until they are used
  constexpr std::uintptr_t page = 2 << 20;
  mallopt(M_MMAP_THRESHOLD, reserved);  // large blocks from the heap too
  mallopt(M_TRIM_THRESHOLD, reserved);  // and back into it, not to the system
  mallopt(M_TOP_PAD, reserved);
  void* first = std::malloc(static_cast<std::size_t>(page));  // the heap grows
  mallopt(M_TOP_PAD, static_cast<int>(page));
  const auto end = reinterpret_cast<std::uintptr_t>(sbrk(0)) / page * page;
  const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(first) / page + 1) * page;
  if (first != nullptr && begin < end) (void)madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  std::free(first);
}

#else

void use_large_pages() {}

#endif

}  // namespace lamprey::app
