#include "long_call.hpp"

#include <sys/mman.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

namespace lamprey::python {

namespace nb = nanobind;

namespace {

constexpr auto look_after = std::chrono::milliseconds(50);

// A number that forked processes share with their parent: how often the work was asked to stop.
class SharedCount {
 public:
  SharedCount() {
    void* page = mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (page == MAP_FAILED) throw std::bad_alloc();
    count_ = new (page) Count(0);
  }
  ~SharedCount() { munmap(count_, sizeof(Count)); }
  SharedCount(const SharedCount&) = delete;
  SharedCount& operator=(const SharedCount&) = delete;
  void raise() { ++*count_; }
  const std::atomic<int>& value() const { return *count_; }

 private:
  using Count = std::atomic<int>;
  static_assert(Count::is_always_lock_free);
  Count* count_;
};

// The exception of a signal's handler, if one has raised, of which only the main thread's calls see any; or of a function.
Raised exception_in_python(Raised* raised, bool& by_signal) {
  by_signal = true;
  const nb::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) return nb::python_error();
  by_signal = false;
  if (!raised || !*raised) return std::nullopt;
  Raised taken(std::move(*raised));
  raised->reset();
  return taken;
}

}  // namespace

Raised run_long(const std::function<void(const Interrupted&)>& work, Raised* raised) {
  SharedCount stop;
  bool by_signal = false;
  Raised first;
  std::exception_ptr failure;
  {
    const nb::gil_scoped_release unlocked;
    std::mutex mutex;
    std::condition_variable finished;
    bool done = false;
    std::thread worker([&] {
      try {
        work(Interrupted(stop.value()));
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      done = true;
      finished.notify_one();
    });
    std::unique_lock lock(mutex);
    while (!finished.wait_for(lock, look_after, [&] { return done; })) {
      lock.unlock();
      if (Raised one = exception_in_python(raised, by_signal)) {
        if (!first) first.emplace(std::move(*one));
        if (by_signal || stop.value() == 0) stop.raise();
      }
      lock.lock();
    }
    lock.unlock();
    worker.join();
    if (Raised one = exception_in_python(raised, by_signal); one && !first) first.emplace(std::move(*one));
  }
  if (!first && failure) std::rethrow_exception(failure);
  return first;
}

}  // namespace lamprey::python
