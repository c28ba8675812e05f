#include "interrupt.hpp"

#include <sys/mman.h>

#include <atomic>
#include <csignal>
#include <new>

namespace lamprey::app {

namespace {

using Count = std::atomic<int>;
static_assert(Count::is_always_lock_free);

Count seen{0};            // by this process
int looked_for = 0;       // signals
Count* by_any = nullptr;  // the most that this process or one that it forks has seen

void on_signal(int signal) {
  const int count = ++seen;
  if (count > looked_for) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  for (int most = by_any->load(); most < count && !by_any->compare_exchange_weak(most, count);) continue;
}

}  // namespace

void watch_for_interrupts(int count) {
  void* page = mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::bad_alloc();
  by_any = new (page) Count(0);
  looked_for = count;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool interrupted() { return by_any && by_any->load() > 0; }
bool interrupted_again() { return by_any && by_any->load() > 1; }

}  // namespace lamprey::app
