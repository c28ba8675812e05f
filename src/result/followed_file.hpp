// Stored motions that a march follows: their moments, their joint angles, or their moments and gains.
#pragma once

#include <string>

#include "model/system.hpp"
#include "result/joint_table.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// Holds a stored motion to the joints that shall follow it, by number, name and kind (masses and offsets may differ), and its times to
/// rise. model::InputError with the field where it does not fit; `path` names it there.
void require_motion_of(const Joints& joints, const Results& results, const std::string& path);

/// Holds a stored motion to a swimmer: as many bodies and the same joints between them, of the same kinds where these count
/// (inertia and offsets may differ), and nodes. model::InputError with the field where it does not fit; `path` names it there.
void require_same_tree(const Results& results, const std::string& path, const model::System& swimmer, bool same_kinds);

/// Refuses a march that ended before its duration as the first guess of a maneuver: its motion is none to begin with.
void require_whole(const Results& results, const std::string& path);

/// A start like a motion's first node.
maneuver::Start first_node(const maneuver::Solution& solution);

/// Holds a maneuver to the swimmer that shall follow it for `duration` s from `from` s of its time on: the same tree, gains, and an end
/// not before the march's; gaits are followed from their beginning. model::InputError with the field where it does not fit; `path`
/// names the maneuver there.
void require_followed(const Results& results, const std::string& path, const model::System& follower, double from,
                      double duration);

}  // namespace lamprey::result
