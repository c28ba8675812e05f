// What people should know of a march beside its motion.
#pragma once

#include <string>

#include "task/tasks.hpp"

namespace lamprey::task {

/// Sentences, each after a blank: how feedback kept to its plan, what of a table or a maneuver was left out, what began otherwise, how far
/// beside the goal it ends, energy that no moment has worked. `problem`: what was marched; `with_goal`: the same with the file's goal,
/// before any perturbation; `asked`: the file's duration.
std::string march_remarks(const MarchOptions& options, const model::System& system, const maneuver::Problem& problem,
                          const maneuver::Problem& with_goal, const maneuver::Duration& asked,
                          const result::Results& results);

}  // namespace lamprey::task
