// Gains about a motion: what a swimmer's joints do when it is off its plan (chapter 11).
#pragma once

#include "integrator/feedback_law.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::maneuver {

/// What deviations cost against moments (equation 11.5): each number is the size, in rad, of a deviation that costs as much
/// as the whole maneuver's effort. A gait has cycles to come in which its joints, along the path, bring the whole back.
struct FeedbackWeights {
  double path = 0.1;        // rad, kept up all along: of the bodies, of a gait of the joints
  double gait_whole = 0.3;  // rad, likewise, of a gait as a whole
  double end = 0.03;        // rad, at the end, in what the goal asks for
  double gait_end = 0.3;    // rad, likewise of a gait, at the end of each cycle
  double rate = 0.001;      // of the duration: the time in which a rate at the end makes the turn that it counts as
};

/// Linear-quadratic regulator about a motion: gains at its nodes, or at every few of them where there are more than
/// 1,000. The motion must have steps of the problem's scheme; above order 2 its moments run as its stages say, and what
/// feedback adds linearly between gains. Throws std::domain_error where the motion does not obey its steps.
Feedback design_feedback(const model::System& system, const Problem& problem, const Solution& solution,
                         const FeedbackWeights& weights = {});

/// The nodes of a solution.
integrator::NodeMotion node_motion(const model::System& system, const Solution& solution);

/// Follows a solution by its own gains. `system` is that of the solution's swimmer and must outlive the law; `planned` its
/// moments in time.
integrator::FeedbackLaw feedback_law(const model::System& system, const Solution& solution,
                                     integrator::ControlFunction planned);

}  // namespace lamprey::maneuver
