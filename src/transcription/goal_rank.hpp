// Which end conditions are independent: momentum conservation and symmetry make some of them follow from the others.
#pragma once

#include "transcription/transcription.hpp"

namespace lamprey::transcription {

/// The stated goal rows that can be moved independently of each other, by the rank of what they see of the changes that keep
/// the equations of motion at `path` (chapter 5). The path must not be still: there the rank is too small.
std::vector<GoalRow> independent_goal_rows(const model::System& system, const Maneuver& maneuver, const NodePath& path);

}  // namespace lamprey::transcription
