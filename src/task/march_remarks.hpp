// What people should know of a march beside its motion.
#pragma once

#include <optional>
#include <string>

#include "maneuver/energy_balance.hpp"
#include "task/tasks.hpp"

namespace lamprey::task {

/// Sentences, each after a blank: how feedback kept to its plan, what of a table or a maneuver was left out, what began otherwise, how far
/// beside the goal it ends, energy that no moment has worked. `problem`: what was marched; `with_goal`: the same with the file's goal,
/// before any perturbation; `asked`: the file's duration.
std::string march_remarks(const MarchOptions& options, const model::System& system, const maneuver::Problem& problem,
                          const maneuver::Problem& with_goal, const maneuver::Duration& asked,
                          const result::Results& results);

/// The energy of a march that its joints' moments have not worked, where that is too much for steps that resolve it. Of marches by a scheme
/// of order 1 or 2 without springs and dampers alone, whose nodes tell the work, and none that feedback has lost.
std::optional<maneuver::EnergyBalance> energy_out_of_balance(const model::System& system,
                                                             const result::Results& results);

}  // namespace lamprey::task
