// The maneuver that a march follows, for `lamprey simulate --feedback`.
#pragma once

#include <string>

#include "file/results.hpp"
#include "model/system.hpp"

namespace lamprey::file {

/// Reads FOLDER/solution.json and holds it to the swimmer that shall follow it for `duration` s: gains, as many bodies, the
/// same joints between them (inertia and offsets may differ), and an end not before the march's. IoError when the file
/// cannot be read, model::InputError with the field when it does not fit.
Results read_followed(const std::string& folder, const model::System& follower, double duration);

}  // namespace lamprey::file
