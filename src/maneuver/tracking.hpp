// Following a maneuver from elsewhere: starts off the plan, and how near a march kept to it.
#pragma once

#include <cstdint>

#include "integrator/feedback_law.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::maneuver {

/// The start with every body turned by `angle` rad about a random axis, a body that its joint leads by so much about its
/// joint's axes; velocities keep their numbers. Turns are drawn from the span of the columns of `turns`
/// [velocity_count − 3][any]: along the freedoms.
Start turned_start(const model::System& system, const Start& start, double angle, std::uint64_t seed,
                   const Eigen::MatrixXd& turns);

/// The start with the total momentum of another one, of that swimmer or of one whose bodies weigh otherwise: joints turn at the
/// rates that they have, and the whole moves so. What is at rest there stays so here.
Start with_momentum_of(const model::System& planned, const Start& plan, const model::System& system,
                       const Start& start);

/// The turns that gains answer, as columns: those that moments can influence along the motion.
Eigen::MatrixXd answered_turns(const model::System& system, const Feedback& feedback);

/// How far a march was off the path of the law that it followed, which stood at `from` s when it began.
Tracking tracking_of(const integrator::FeedbackLaw& law, const Solution& marched, double from = 0.0);

}  // namespace lamprey::maneuver
