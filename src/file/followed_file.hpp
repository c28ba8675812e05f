// The maneuver that a march follows, for `lamprey simulate --feedback`.
#pragma once

#include <string>

#include "file/results.hpp"
#include "model/system.hpp"

namespace lamprey::file {

/// Holds a maneuver to the swimmer that shall follow it for `duration` s: gains, as many bodies, the same joints between them
/// (inertia and offsets may differ), and an end not before the march's. model::InputError with the field where it does not
/// fit; `path` names the maneuver there.
void require_followed(const Results& results, const std::string& path, const model::System& follower, double duration);

}  // namespace lamprey::file
