// The certificate's word on a motion: its status and message.
#pragma once

#include <string>

#include "certificate/certificate.hpp"
#include "maneuver/failure.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::study {

/// Sets status and message from the numbers of the certificate: "optimal" needs the discrete equations, the goal, rest and the
/// KKT residual to hold, whatever the optimiser thought. Of what is not optimal the message in its parts.
maneuver::Failure judge(const maneuver::Problem& problem, const certificate::Certificate& certificate,
                        maneuver::Solution& solution);

/// The same of a simulated motion, which seeks no goal: status simulated where its numbers fit each other and the mechanics as
/// far as the certificate can tell, else stalled with the reason as message.
void judge_march(const maneuver::Problem& problem, const certificate::Certificate& certificate,
                 maneuver::Solution& solution);

/// What second derivatives say, as sentences after a blank.
std::string curvature_words(const maneuver::Problem& problem, const certificate::Certificate& certificate);

}  // namespace lamprey::study
