// Long calls: without Python's lock, and ended by Ctrl-C.
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <functional>
#include <optional>

namespace lamprey::python {

/// Whether the work shall stop; asked from any thread and from forked processes, never takes Python's lock.
class Interrupted {
 public:
  explicit Interrupted(const std::atomic<int>& count) : count_(count) {}
  bool operator()() const { return count_.load(std::memory_order_relaxed) > 0; }
  /// Whether it was asked to more than once.
  bool again() const { return count_.load(std::memory_order_relaxed) > 1; }

 private:
  const std::atomic<int>& count_;
};

/// What a Python function raised that the work called; touched under Python's lock alone.
using Raised = std::optional<nanobind::python_error>;

/// Runs `work` in a thread of its own, the lock released, while the calling thread looks after Python's signals. If a signal's
/// handler raises, or a function that the work calls has (`raised`), the work is asked to stop; once it has, `work` has returned and
/// the exception is returned for the caller to throw, after adding to it what there is. What the work throws is thrown here.
Raised run_long(const std::function<void(const Interrupted&)>& work, Raised* raised = nullptr);

}  // namespace lamprey::python
