// What a stored answer says beside its certificate, against what the rest of the file makes of it.
#pragma once

#include <vector>

#include "certificate/claims.hpp"
#include "result/results.hpp"

namespace lamprey::task {

/// Numbers of `stored` that do not follow from its others: times of the problem, gains and their times (where `with_gains`), angles that
/// jump, moments' axes and other numbers that the problem itself settles, where bodies come nearest and limits are broken most; or that contradict each other, of
/// minima and other grids, which no file shows again. `found`: the same answer
/// with its certificate computed again.
std::vector<certificate::FalseClaim> false_statements(const result::Results& stored, const result::Results& found,
                                                      bool with_gains);

}  // namespace lamprey::task
