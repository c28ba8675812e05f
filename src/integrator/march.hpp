// Marching with a scheme: one time step is a row of steps of its discrete Lagrangian (chapter 8, equation 8.39).
#pragma once

#include <functional>

#include "integrator/scheme.hpp"
#include "integrator/step.hpp"

namespace lamprey::integrator {

/// Moments at the stages' nodes: 0 at the step's beginning, `stages` at its end; nodes lie at March::nodes.
using StageControl = std::function<const Moments&(int node)>;

/// Told of each stage as it is done: the stage's motion and the state after it, whose momentum it may change.
using StageWitness = std::function<void(const mechanics::Interval& interval, State& state)>;

/// Steps of a scheme; owns the buffers of all its stages.
class March {
 public:
  March(const model::System& system, Scheme scheme);

  /// Advances the state by one time step. On failure the state is left as it was and the report is that of the stage
  /// that did not converge.
  StepReport advance(double time_step, const StageControl& control, State& state, const StageWitness& witness = {});

  /// The next step seeks its motion from this one on, in place of a guess: turns and displacement count, in m and world
  /// directions. Of schemes with one stage.
  void begin_at(const mechanics::Interval& motion);

  /// Forgets the steps seen: the next guess begins anew.
  void restart();

  /// Fractions of the time step at which stages meet, [stages + 1]: from 0 to 1.
  const std::vector<double>& nodes() const { return nodes_; }
  int stages() const { return composition_.stages(); }

 private:
  const model::System& system_;
  const Composition& composition_;
  std::vector<double> nodes_;
  std::vector<StepWorkspace> work_;  // [stages]
  State saved_;
};

}  // namespace lamprey::integrator
