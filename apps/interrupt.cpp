#include "interrupt.hpp"

#include <sys/mman.h>

#include <atomic>
#include <csignal>
#include <new>

namespace lamprey::app {

namespace {

using Flag = std::atomic<bool>;
static_assert(Flag::is_always_lock_free);

Flag seen{false};        // by this process
Flag* by_any = nullptr;  // of this process and of those that it forks

void on_signal(int signal) {
  if (seen.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  by_any->store(true);
}

}  // namespace

void watch_for_interrupt() {
  void* page = mmap(nullptr, sizeof(Flag), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::bad_alloc();
  by_any = new (page) Flag(false);
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool interrupted() { return by_any && by_any->load(); }

}  // namespace lamprey::app
