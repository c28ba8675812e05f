// What a stored answer says beside its certificate, against what the rest of the file makes of it.
#pragma once

#include <vector>

#include "certificate/claims.hpp"
#include "result/results.hpp"

namespace lamprey::task {

/// Numbers of `stored` that do not follow from its others: what the problem itself settles, such as its times and the axes of a hinge's
/// moments; gains and their times (where `with_gains`); angles that jump; where bodies come nearest and limits are broken most. And
/// numbers of minima and other grids, which no file shows again, that contradict the rest. `found`: the same answer with its
/// certificate computed again.
std::vector<certificate::FalseClaim> false_statements(const result::Results& stored, const result::Results& found,
                                                      bool with_gains);

}  // namespace lamprey::task
