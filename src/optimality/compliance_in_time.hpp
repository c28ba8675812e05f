// Springs and dampers tell how long a step lasts: what a free duration changes of a motion whose impulses h²u and scaled
// momenta hμ are held (equations 6.24 and 6.25).
#pragma once

#include "optimality/effort_chain.hpp"

namespace lamprey::optimality {

/// Rates of a step's scaled momenta by the duration's logarithm, along the freedoms, [velocity_count] N m s: what they take off at
/// the beginning and add at the end.
struct TimedImpulses {
  VectorXd minus, plus;
};

/// Of all steps, [N]; empty where the duration is given or nothing is compliant.
std::vector<TimedImpulses> timed_impulses(const StoredMotion& motion);

/// Steps' scaled next states by the duration's logarithm, [N][n] in units of the tangents; empty likewise.
std::vector<VectorXd> steps_by_duration(const StoredMotion& motion, const StepTangents& tangents);

/// Adds that to a chain widened by the duration's logarithm as its last state, and to its forms the Lagrangian's second derivatives
/// that come of it.
void add_compliance_in_time(const StoredMotion& motion, const EffortChain& effort,
                            const std::vector<VectorXd>& costates, Chain& chain);

}  // namespace lamprey::optimality
