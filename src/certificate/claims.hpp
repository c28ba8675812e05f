// Claims: what a stored certificate says, against what is found when it is computed again.
#pragma once

#include <string>
#include <vector>

#include "certificate/certificate.hpp"

namespace lamprey::certificate {

struct FalseClaim {
  std::string field;               // as in solution.json
  double stored, found;            // NaN: nothing
  std::string contradiction = {};  // what the stored number is beside others that are stored; of these `found` is one
};

/// Fields of `stored` that promise more than `found` has: errors that are much larger (beyond round-off), other curvatures,
/// gaps and verdicts. What `stored` leaves out promises nothing; costs on other grids, which only a search finds, are not judged.
/// `duration`, s: whole replays that do not multiply round-off much over it come out the same everywhere; with `length`, the swimmer's
/// unit in m, it is what a time or gap is small against.
std::vector<FalseClaim> false_claims(const Certificate& stored, const Certificate& found, double duration,
                                     double length);

}  // namespace lamprey::certificate
