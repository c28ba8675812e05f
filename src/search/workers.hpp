// Independent tasks side by side: in threads, or in worker processes where solvers with global data (MUMPS) cannot share one.
#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace lamprey::search {

/// Runs task(0) … task(count − 1) in up to `workers` threads, the caller's among them; in fewer where the machine gives no more.
/// Once a task throws no other begins. When all threads have ended, what the first of the tasks by number threw goes on: the
/// same for any number of workers.
void run_in_threads(int count, int workers, const std::function<void(int)>& task);

/// Is told how many tasks have ended, and the numbers of the last of them.
using Finished = std::function<void(int done, const std::optional<std::vector<double>>& numbers)>;

/// Runs task(0) … task(count − 1) in up to `workers` forked processes and returns their numbers in order; nothing for a task
/// whose process died. The result does not depend on the number of workers. One worker or one task: runs right here.
/// Once `stopped` says so (it may be empty) no task but the first begins any more: nothing for those that did not.
/// Exceptions go on as from run_in_threads: a task that throws in another process runs once more in this one.
std::vector<std::optional<std::vector<double>>> run_in_workers(int count, int workers,
                                                               const std::function<std::vector<double>(int)>& task,
                                                               const Finished& finished,
                                                               const std::function<bool()>& stopped = {});

}  // namespace lamprey::search
