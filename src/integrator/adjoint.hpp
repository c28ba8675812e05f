// Derivatives of scalars of a whole motion by sweeps of linear cost: gradients by start, controls, duration and the
// swimmer's parameters, and products of the Hessian with a direction (equations 8.32 to 8.38).
#pragma once

#include <functional>
#include <vector>

#include "integrator/scheme.hpp"
#include "integrator/step.hpp"
#include "mechanics/step_balance.hpp"

namespace lamprey::integrator {

/// A motion kept step by step. Schemes above order 2 count each stage as a step of its own.
struct Trajectory {
  const model::System* system;
  DiscreteLagrangian lagrangian;
  double duration;                            // s, of the whole motion
  std::vector<double> fraction;               // [steps] length of each step as a fraction of the duration
  std::vector<mechanics::Interval> interval;  // [steps]
  std::vector<State> state;                   // [steps + 1]
  std::vector<Moments> control;               // [steps + 1]
  StepReport report;                          // of the step at which the march ended: not converged if it ended early
  int steps() const { return static_cast<int>(interval.size()); }
  double time_step(int step) const { return duration * fraction[static_cast<std::size_t>(step)]; }
};

/// Moments at a time in s.
using TimeControl = std::function<Moments(double time)>;

/// Marches `steps` steps of a scheme from a state, keeping everything. Where a step does not converge it ends there.
Trajectory roll_out(const model::System& system, Scheme scheme, double duration, int steps, const State& start,
                    const TimeControl& control);

/// The same under given moments at the nodes of all stages, [steps · stages + 1].
Trajectory roll_out(const model::System& system, Scheme scheme, double duration, int steps, const State& start,
                    const std::vector<Moments>& control);

/// Gradient of a scalar by the state at one node: along the freedoms (body side), by position and by momentum.
struct StateGradient {
  Freedoms turn;      // [bodies]
  Vector3d position;  // 1/m
  Freedoms momentum;  // [bodies]
  Vector3d linear;
  explicit StateGradient(const model::System& system);
  void set_zero();
};

/// A scalar of a motion, a sum over its nodes.
class Objective {
 public:
  virtual ~Objective() = default;
  /// Adds the gradient of node's term by its state, and by its moments (along the joints, [joints]).
  virtual void add_gradient(int node, const State& state, const Moments& control, StateGradient& by_state,
                            Moments& by_control) const = 0;
  /// Adds the rate of that gradient when state and moments change along a direction: a body-side gradient at a turned
  /// point, so for a free body the Hessian in exponential coordinates applied to the turn, plus half of gradient × turn
  /// (equation 4.12).
  virtual void add_gradient_rate(int node, const State& state, const Moments& control, const StateGradient& along,
                                 const Moments& control_along, StateGradient& by_state, Moments& by_control) const = 0;
};

/// By the parameters of the swimmer; matrices count each entry as a number of its own.
struct ParameterGradient {
  std::vector<Matrix3d> mass_matrix;      // [bodies] 1/kg
  std::vector<Matrix3d> inertia_matrix;   // [bodies] 1/(kg m²)
  std::vector<Matrix3d> coupling_matrix;  // [bodies] 1/(kg m)
  Vectors parent_offset;                  // [joints] 1/m, parent's frame
  Vectors child_offset;                   // [joints] 1/m, child's frame
  VectorXd stiffness;                     // [joints] rad/(N m)
  VectorXd damping;                       // [joints] rad/(N m s)
  explicit ParameterGradient(const model::System& system);
};

/// Gradient of an objective.
struct TrajectoryGradient {
  StateGradient by_start;
  std::vector<Moments> by_control;  // [steps + 1] 1/(N m), along the joints; unactuated directions included
  double by_duration = 0.0;         // 1/s, at fixed fractions and fixed moments at the nodes
  ParameterGradient by_parameters;  // at fixed momentum at the start
  explicit TrajectoryGradient(const Trajectory& trajectory);
};

/// A direction of start and controls.
struct TrajectoryDirection {
  StateGradient start;           // here a perturbation of the state: turns, m, momenta
  std::vector<Moments> control;  // [steps + 1] N m
  explicit TrajectoryDirection(const Trajectory& trajectory);
};

/// Product of the Hessian with a direction.
struct HessianProduct {
  StateGradient by_start;
  std::vector<Moments> by_control;  // [steps + 1]
  explicit HessianProduct(const Trajectory& trajectory);
};

/// Buffers of the sweeps, and what they keep for the next one: no allocation after construction.
class AdjointSweep {
 public:
  explicit AdjointSweep(const Trajectory& trajectory);

  /// One sweep from the end to the start.
  void gradient(const Objective& objective, TrajectoryGradient& result);

  /// A sweep along the direction and one back. `gradient` must have been called before, for the same objective.
  void hessian_product(const Objective& objective, const TrajectoryDirection& direction, HessianProduct& result);

  /// Follows a direction through the motion: the perturbation of the state at the end.
  void tangent(const TrajectoryDirection& direction, StateGradient& end);

 private:
  mechanics::ForcedStep forced(int step) const;
  void pull_back(int step, StateGradient& costate, TrajectoryGradient& result);
  void push(int step, const TrajectoryDirection& direction, StateGradient& moved);
  void pull_back_rate(int step, StateGradient& costate_rate, HessianProduct& result);
  void add_parameters(int step, TrajectoryGradient& result);

  const Trajectory& trajectory_;
  const model::System& system_;
  std::vector<mechanics::TreeElimination> elimination_;  // [steps]
  std::vector<mechanics::StepBalance> balance_;          // [steps]
  std::vector<mechanics::StepVariation> multiplier_;     // [steps] (w, v) of the adjoint
  std::vector<mechanics::StepRate> multiplier_rate_;     // [steps] its adjoint rates
  std::vector<mechanics::StepVariation> motion_;         // [steps] of a direction
  std::vector<StateGradient> moved_;                     // [steps + 1]
  std::vector<mechanics::BodyBlock> blocks_;
  std::vector<Matrix3d> damping_;
  mechanics::StepRate rate_;
  mechanics::StepRate motion_rate_;
  mechanics::StepVariation variation_;
  mechanics::SecondRateWorkspace second_;
  mechanics::JointMoments node_moments_;
  Freedoms minus_, plus_;
  Moments work_;
  StateGradient costate_;
};

}  // namespace lamprey::integrator
