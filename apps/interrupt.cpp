#include "interrupt.hpp"

#include <atomic>
#include <csignal>

namespace lamprey::app {

namespace {

std::atomic<bool> seen{false};

void on_signal(int signal) {
  if (seen.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

void watch_for_interrupt() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool interrupted() { return seen; }

}  // namespace lamprey::app
