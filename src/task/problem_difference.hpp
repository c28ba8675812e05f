// Whether a stored answer is one to the question of a problem file.
#pragma once

#include <string>
#include <vector>

#include "file/problem_file.hpp"
#include "result/results.hpp"

namespace lamprey::task {

/// A JSON pointer as people write it, for a number of a list or an object's field: goal.move[0].
std::string path_in_words(const std::string& pointer);

/// A sentence for each field of the stored problem that is not what the file asks for, at most ten and what is left in one more:
/// bodies, joints and fluid, start, goal, time, scheme, cost, limits, waypoints and tolerance. Of a march, which options tell when and how,
/// the swimmer alone. Throws model::InputError where the file makes no system.
std::vector<std::string> problem_differences(const result::Results& stored, const file::ProblemFile& asked);

/// Of a march what is not as in the file, in words: "start", "duration", "steps", "scheme". Of answers none.
std::vector<std::string> march_differences(const result::Results& stored, const file::ProblemFile& asked);

}  // namespace lamprey::task
