#include "integrator/step.hpp"

#include <cmath>

#include <Eigen/Cholesky>

namespace lamprey::integrator {

namespace {

using mechanics::Interval;
using model::System;

constexpr int max_iterations = 60;
constexpr double accepted_residual = 1e-12;

using model::at;

// Evaluates p⁻ at the current guess; returns the largest missing momentum relative to the largest one in the step.
double evaluate(const System& system, DiscreteLagrangian lagrangian, double h, const Vector3d& linear,
                StepWorkspace& work) {
  mechanics::update_interval(system, work.interval);
  mechanics::discrete_momenta(system, lagrangian, h, work.interval, work.momenta);
  double missing = (linear - work.momenta.linear).lpNorm<Eigen::Infinity>();
  double scale = linear.lpNorm<Eigen::Infinity>();
  for (int i = 0; i < system.body_count(); ++i) {
    work.missing[at(i)] = work.target[at(i)] - work.momenta.minus[at(i)];
    missing = std::max(missing, work.missing[at(i)].lpNorm<Eigen::Infinity>());
    scale = std::max({scale, work.target[at(i)].lpNorm<Eigen::Infinity>(),
                      work.momenta.minus[at(i)].lpNorm<Eigen::Infinity>(),
                      work.momenta.subtree_linear[at(i)].lpNorm<Eigen::Infinity>()});
  }
  return missing == 0.0 ? 0.0 : missing / scale;
}

// ζ moves so that F turns by η' on its right: δζ = ½ (I + ζ̂ + ζζᵀ) η'.
Vector3d cayley_correction(const Vector3d& zeta, const Vector3d& turn) {
  return 0.5 * (turn + zeta.cross(turn) + zeta * zeta.dot(turn));
}

// Guess by extrapolating the last two steps.
void predict(StepWorkspace& work) {
  const double slope = work.history >= 2 ? 1.0 : 0.0;
  for (std::size_t i = 0; i < work.interval.cayley.size(); ++i)
    work.interval.cayley[i] = work.latest_cayley[i] + slope * (work.latest_cayley[i] - work.previous_cayley[i]);
  work.interval.displacement =
      work.latest_displacement + slope * (work.latest_displacement - work.previous_displacement);
}

void remember(StepWorkspace& work) {
  work.previous_cayley.swap(work.latest_cayley);
  work.latest_cayley = work.interval.cayley;
  work.previous_displacement = work.latest_displacement;
  work.latest_displacement = work.interval.displacement;
  work.history = std::min(work.history + 1, 2);
}

// Stands still where no step is known yet: Newton's first step from there is h 𝕀⁻¹ of the target, without forming 𝕀.
void stand_still(StepWorkspace& work) {
  for (Vector3d& zeta : work.interval.cayley) zeta.setZero();
  work.interval.displacement.setZero();
}

}  // namespace

State state_of_velocity(const System& system, const Rotations& rotation, const Vector3d& position,
                        const VectorXd& velocity) {
  return {rotation, position, mechanics::generalized_momentum(system, rotation, velocity)};
}

VectorXd velocity_of_state(const System& system, const State& state) {
  return mechanics::generalized_inertia(system, state.rotation).llt().solve(state.momentum);
}

StepWorkspace::StepWorkspace(const System& system)
    : interval(system.body_count()),
      momenta(system.body_count()),
      target(at(system.body_count())),
      missing(at(system.body_count())),
      turns(at(system.body_count())),
      cayley_base(at(system.body_count())),
      force(at(system.body_count())),
      latest_cayley(at(system.body_count()), Vector3d::Zero()),
      previous_cayley(at(system.body_count()), Vector3d::Zero()),
      latest_displacement(Vector3d::Zero()),
      previous_displacement(Vector3d::Zero()),
      newton(system.body_count()) {}

void joint_forces(const System& system, const Rotations& rotation, const Moments& control,
                  std::vector<Vector3d>& force) {
  for (Vector3d& f : force) f.setZero();
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const Vector3d& u = control[at(j)];
    force[at(joint.parent)] += u;
    force[at(joint.child)] -= rotation[at(joint.child)].transpose() * (rotation[at(joint.parent)] * u);
  }
}

StepReport solve_step(const System& system, DiscreteLagrangian lagrangian, double h, const Vector3d& linear,
                      StepWorkspace& work) {
  StepReport report;
  Vector3d shift;
  report.residual = evaluate(system, lagrangian, h, linear, work);
  while (report.residual > 0.0 && report.iterations < max_iterations) {
    if (!std::isfinite(report.residual) ||
        !solve_tree_newton(system, lagrangian, h, work.interval, work.missing, linear - work.momenta.linear,
                           work.newton, work.turns, shift))
      return report;
    ++report.iterations;
    work.cayley_base = work.interval.cayley;
    const Vector3d displacement_base = work.interval.displacement;
    const double before = report.residual;
    // at round-off a full step that does not help ends the iteration; before it, steps are halved until they help
    for (double fraction = 1.0; fraction > 1e-3; fraction *= 0.5) {
      for (std::size_t i = 0; i < work.turns.size(); ++i)
        work.interval.cayley[i] =
            work.cayley_base[i] + fraction * cayley_correction(work.cayley_base[i], work.turns[i]);
      work.interval.displacement = displacement_base + fraction * shift;
      report.residual = evaluate(system, lagrangian, h, linear, work);
      if (report.residual < before || before < accepted_residual) break;
    }
    if (before < accepted_residual && report.residual > 0.25 * before) break;
  }
  report.converged = report.residual < accepted_residual;
  return report;
}

StepReport advance(const System& system, DiscreteLagrangian lagrangian, double h, const Moments& control,
                   const Moments& control_next, State& state, StepWorkspace& work) {
  const Vector3d linear = state.momentum.tail<3>();
  work.interval.rotation = state.rotation;
  if (work.history == 0) {
    stand_still(work);
  } else {
    predict(work);
  }
  joint_forces(system, state.rotation, control, work.force);
  for (int i = 0; i < system.body_count(); ++i)
    work.target[at(i)] = state.momentum.segment<3>(3 * i) + 0.5 * h * work.force[at(i)];
  const StepReport report = solve_step(system, lagrangian, h, linear, work);
  if (!report.converged) return report;

  remember(work);
  for (int i = 0; i < system.body_count(); ++i)
    state.rotation[at(i)] = lie::renormalized(work.interval.next_rotation[at(i)]);
  state.position += work.interval.displacement;
  joint_forces(system, state.rotation, control_next, work.force);
  for (int i = 0; i < system.body_count(); ++i)
    state.momentum.segment<3>(3 * i) = work.momenta.plus[at(i)] + 0.5 * h * work.force[at(i)];
  return report;
}

}  // namespace lamprey::integrator
