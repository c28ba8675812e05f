// Marches whose files do not tell the steps: by the reference integrator, or by steps that were divided where they did not converge.
#pragma once

#include "evidence/stored_motion.hpp"

namespace lamprey::certificate {

using evidence::StoredMotion;

/// By how many times the farthest step leads beyond what the stored moments leave open: from each node's state the continuous equations
/// go on to the next one, under moments that are linear in between, and may miss it by what twice the largest moment at the four
/// nodes about the step would do meanwhile; of divided marches, whose pieces are coarse, by the momenta's scale more. There steps that
/// obey the scheme as they are need none of that, nor do those that turn a body by more than a quarter; more of the others than were
/// divided are infinitely many.
/// `scale`: of the momenta, kg m²/s. NaN where nothing is known: without velocities, or of divided steps above order 2.
double beyond_moments(const StoredMotion& motion, double scale);

}  // namespace lamprey::certificate
