// What is allowed in a problem file but seldom meant: slips of unit, of frame, of body against fluid.
#pragma once

#include <string>
#include <vector>

#include "file/problem_file.hpp"
#include "maneuver/problem.hpp"
#include "model/system.hpp"

namespace lamprey::task {

/// One sentence for each number that looks like a slip: a mass far from that of the water displaced, weight or buoyancy that is left, a fluid as light as a gas, given M or J that are less
/// than the body alone, a joint far off its body or in its very middle, bodies that begin within each other, inertias that double precision cannot hold side by side, a goal many
/// lengths away, one of more than half a turn. None of it is refused. The system must be that of the problem.
std::vector<std::string> model_remarks(const maneuver::Problem& problem, const model::System& system);

/// The same of a file, with what only the keys that it states can tell: that a body which begins turned leaves those behind that hang
/// on ball joints.
std::vector<std::string> model_remarks(const file::ProblemFile& file, const model::System& system);

}  // namespace lamprey::task
