// Independent tasks in worker processes: solvers with global data (MUMPS) cannot share one.
#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace lamprey::study {

/// Runs task(0) … task(count − 1) in up to `workers` forked processes and returns their numbers in order; nothing for a task
/// whose process died. The result does not depend on the number of workers. One worker or one task: runs right here.
/// Once `stopped` says so (it may be empty) no task but the first begins any more: nothing for those that did not.
std::vector<std::optional<std::vector<double>>> run_in_workers(int count, int workers,
                                                               const std::function<std::vector<double>(int)>& task,
                                                               const std::function<void(int)>& finished,
                                                               const std::function<bool()>& stopped = {});

}  // namespace lamprey::study
