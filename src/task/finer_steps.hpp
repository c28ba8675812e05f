// An answer on as many steps as show its motion: where the file's do not, it is solved again from there on more.
#pragma once

#include <optional>
#include <string>

#include "task/tasks.hpp"

namespace lamprey::task {

/// solve_task, and where its steps do not resolve the answer from it on once more on as many as its replay proposes, until they do: a few
/// times, within the time limit, while searches arrive. The results are then of more steps than the file's, and their message says so.
result::Results resolve_task(const file::ProblemFile& file, const search::SolveOptions& options,
                             const std::string& command, const std::optional<EarlierMotion>& first = {});

}  // namespace lamprey::task
