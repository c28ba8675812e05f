#include "integrator/march.hpp"

#include <algorithm>
#include <cmath>

namespace lamprey::integrator {

using model::at;
using model::System;

March::March(const System& system, Scheme scheme) : system_(system), composition_(composition(scheme)), nodes_{0.0} {
  for (double fraction : composition_.fractions) {
    nodes_.push_back(nodes_.back() + fraction);
    work_.emplace_back(system);
    // what Newton leaves undone adds up over many stages: above order 2 it would show in the energy
    if (composition_.stages() > 1) work_.back().sought_residual = 0.0;
  }
  nodes_.back() = 1.0;
}

StepReport March::advance(double time_step, const StageControl& control, State& state, const StageWitness& witness) {
  StepReport total;
  if (stages() > 1) saved_ = state;
  for (int s = 0; s < stages(); ++s) {
    const StepReport report =
        integrator::advance(system_, composition_.lagrangian, time_step * composition_.fractions[at(s)], control(s),
                            control(s + 1), state, work_[at(s)]);
    total.converged = report.converged;
    total.iterations += report.iterations;
    total.residual = std::isnan(report.residual) ? report.residual : std::max(total.residual, report.residual);
    if (!report.converged) {
      if (stages() > 1) state = saved_;
      return total;
    }
    if (witness) witness(work_[at(s)].interval, state);
  }
  return total;
}

void March::begin_at(const mechanics::Interval& motion) {
  work_.front().interval = motion;
  work_.front().begun = true;
}

void March::restart() {
  for (StepWorkspace& work : work_) work.predictor.forget();
}

}  // namespace lamprey::integrator
