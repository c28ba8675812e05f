// A motion's angles and moments as CSV tables, for controllers and spreadsheets, such as `lamprey simulate` reads.
#pragma once

#include <optional>

#include "document/atomic_write.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// angles.csv: t, then the angles of each joint from its zero angle, rad, node by node. model::InputError where the results hold none;
/// `path` names them.
document::PendingFile angles_table(const Results& results, const std::string& path);

/// moments.csv: t, then x, y, z of each joint's moment on its parent, N m, in the parent's frame with the joint at its
/// zero angle, and after them the moments of its motors: "fin" of a hinge, "fin 1" and "fin 2" of a universal joint; linear between nodes. Nothing of schemes above order 2, whose moments are polynomials over the stages of each step.
std::optional<document::PendingFile> moments_table(const Results& results, const std::string& path);

}  // namespace lamprey::result
