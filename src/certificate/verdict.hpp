// What a certificate's numbers add up to.
#pragma once

#include "certificate/certificate.hpp"
#include "maneuver/problem.hpp"

namespace lamprey::certificate {

/// Whether goal and limits are met by a motion of the problem's swimmer that obeys the law.
bool meets_goal(const maneuver::Problem& problem, const Certificate& certificate);

/// Whether kkt and the signs of multipliers keep their marks: the cost is stationary where the goal and limits are kept.
bool stationary(const maneuver::Problem& problem, const Certificate& certificate);

/// What a certificate's numbers add up to.
Verdict verdict(const maneuver::Problem& problem, const Certificate& certificate);

}  // namespace lamprey::certificate
