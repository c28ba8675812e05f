#include "integrator/step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mechanics/step_balance.hpp"

namespace lamprey::integrator {

namespace {

using mechanics::Interval;
using mechanics::JointMoments;
using model::at;
using model::Body;
using model::Joint;
using model::JointKind;
using model::System;

constexpr int max_iterations = 60;
constexpr double accepted_residual = 1e-12;  // of a step that gets no better
constexpr int bodies_to_round_off = 5;       // the tolerances hold for trees up to this
constexpr double least_momentum = 1e-280;    // kg m²/s: less is rest, and has no digits left to balance
constexpr double good_contraction = 1e-3;    // below it the factors serve another iteration

// A body's turn is known to round-off and moves all bodies beyond it: what a step can balance grows with the tree.
double attainable(const System& system, double residual) {
  return residual * std::max(1.0, static_cast<double>(system.body_count()) / bodies_to_round_off);
}

// Joint moments along the freedoms, added to `result`.
void gather_moments(const System& system, const Rotations& R, const Vectors& no_force, JointMoments& moments,
                    Freedoms& result) {
  if (system.only_free_joints()) {
    result = moments.body;
    return;
  }
  mechanics::gather(system, R, no_force, moments.body, result);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] += moments.along[i];
}

double largest(const Vector3d& v) { return v.lpNorm<Eigen::Infinity>(); }

double largest_of(const algebra::Four& v) { return std::max({v[0], v[1], v[2], v[3]}); }

// Calls f with each stretch of an interval's unknowns: where it lies, how long it is, and its place among all.
template <typename Function, typename Step>
void for_each_stretch(Step& interval, const Function& f) {
  const std::size_t turns = 3 * interval.cayley.size();
  f(interval.cayley.front().data(), turns, std::size_t{0});
  f(interval.joint_turn.front().data(), turns, turns);
  f(interval.displacement.data(), std::size_t{3}, 2 * turns);
}

// Evaluates E⁻ at the current guess; returns the largest missing momentum relative to the largest one in the step.
double evaluate(const System& system, DiscreteLagrangian lagrangian, double h, const Vector3d& linear,
                StepWorkspace& work) {
  mechanics::update_interval(system, work.interval);
  mechanics::momenta_at_beginning(system, lagrangian, h, work.interval, work.momenta);
  const bool resisted = system.damped();
  if (resisted) {
    work.damping.set_zero();
    work.damping_next.set_zero();
    mechanics::damping_momenta(system, work.interval, work.damping, work.damping_next);
    gather_moments(system, work.interval.rotation, work.no_force, work.damping, work.damping_force);
  }
  double missing = largest(linear - work.momenta.linear);
  double scale = largest(linear);
  double sum = work.momenta.linear.sum();  // not finite if any entry is: a largest entry would hide it
  for (std::size_t i = 0; i < work.missing.size(); ++i) {
    work.missing[i] = work.target[i] - work.momenta.minus[i];
    if (resisted) work.missing[i] -= work.damping_force[i];
    sum += work.missing[i].sum();
    missing = std::max(missing, largest(work.missing[i]));
    scale = std::max(
        {scale, largest(work.target[i]), largest(work.momenta.minus[i]), largest(work.momenta.subtree_linear[i])});
  }
  if (!std::isfinite(sum)) return std::numeric_limits<double>::quiet_NaN();
  return missing <= least_momentum ? 0.0 : missing / scale;
}

bool factor(const System& system, DiscreteLagrangian lagrangian, double h, StepWorkspace& work) {
  mechanics::step_blocks(system, lagrangian, h, work.interval, work.momenta, work.blocks);
  mechanics::damping_blocks(system, work.interval, work.damping_block);
  return work.elimination.factor(system, work.interval.rotation, work.interval.next_rotation, work.blocks,
                                 work.damping_block);
}

bool finite(const Moments& moments) {
  return std::all_of(moments.begin(), moments.end(), [](const Vector3d& u) { return u.allFinite(); });
}

// ζ moves so that F turns by η' on its right: δζ = ½ (I + ζ̂ + ζζᵀ) η'.
Vector3d cayley_correction(const Vector3d& zeta, const Vector3d& turn) {
  return 0.5 * (turn + zeta.cross(turn) + zeta * zeta.dot(turn));
}

void keep_turns(const System& system, StepWorkspace& work) {
  for (int i = 0; i < system.body_count(); ++i)
    work.base_turn[at(i)] =
        system.body(i).freedoms == 3 ? work.interval.cayley[at(i)] : work.interval.joint_turn[at(i)];
}

// A fraction of Newton's correction away from where the iteration stood.
void move(const System& system, double fraction, const Freedoms& correction, const Vector3d& base_displacement,
          const Vector3d& shift, StepWorkspace& work) {
  for (int i = 0; i < system.body_count(); ++i) {
    const Vector3d& base = work.base_turn[at(i)];
    if (system.body(i).freedoms == 3) {
      work.interval.cayley[at(i)] = base + fraction * cayley_correction(base, correction[at(i)]);
    } else {
      work.interval.joint_turn[at(i)] = base + fraction * correction[at(i)];
    }
  }
  work.interval.displacement = base_displacement + fraction * shift;
}

// Stands still where no step is known yet: Newton's first step from there is h 𝕀⁻¹ of the target, without forming 𝕀.
void stand_still(Interval& interval) {
  for (Vector3d& zeta : interval.cayley) zeta.setZero();
  for (Vector3d& turn : interval.joint_turn) turn.setZero();
  interval.displacement.setZero();
}

// Keeps a led body's rotation on its joint: takes out what round-off has turned across the axes.
Matrix3d realigned(const Joint& joint, const Matrix3d& R_parent, const Matrix3d& R_child) {
  if (joint.kind == JointKind::fixed) return R_parent * joint.reference_rotation;
  const Vector3d axis = R_parent * joint.parent_axis;
  const Vector3d carried = R_child * joint.child_axis;
  Vector3d turn = carried.cross(axis);
  if (joint.kind == JointKind::universal) turn *= -carried.dot(axis) / turn.squaredNorm();
  return lie::renormalized(R_child + lie::hat(turn) * R_child);
}

// Newton's residual stays in the momentum, turned on with its body: totals stay what they are to round-off. What p_x
// lacks counts with the lever of the step.
void carry_residual(const System& system, const Vector3d& linear, StepWorkspace& work) {
  const Vector3d lever = work.interval.displacement.cross(linear - work.momenta.linear);
  work.missing[0] -= work.interval.rotation[0].transpose() * lever;
  for (int i = 0; i < system.body_count(); ++i)
    if (system.body(i).freedoms == 3)
      work.missing[at(i)] = (work.interval.relative_rotation[at(i)].transpose() * work.missing[at(i)]).eval();
}

void accept(const System& system, double h, const Moments& control_next, State& state, StepWorkspace& work) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    state.rotation[at(i)] = body.freedoms == 3 ? lie::renormalized(work.interval.next_rotation[at(i)])
                                               : realigned(system.joint(body.joint), state.rotation[at(body.parent)],
                                                           work.interval.next_rotation[at(i)]);
  }
  state.position += work.interval.displacement;
  mechanics::momenta_at_end(system, work.interval, work.momenta);
  carry_residual(system, state.momentum.tail<3>(), work);
  joint_forces(system, state.rotation, control_next, work, work.force);
  const bool resisted = system.damped();
  if (resisted)
    gather_moments(system, work.interval.next_rotation, work.no_force, work.damping_next, work.damping_force);
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    Vector3d mu = work.momenta.plus[at(i)] + work.missing[at(i)] + 0.5 * h * work.force[at(i)];
    if (resisted) mu -= work.damping_force[at(i)];
    for (int f = 0; f < body.freedoms; ++f) state.momentum[body.velocity_offset + f] = mu[f];
  }
}

}  // namespace

State state_of_velocity(const System& system, const Rotations& rotation, const Vector3d& position,
                        const VectorXd& velocity) {
  return {rotation, position, mechanics::generalized_momentum(system, rotation, velocity)};
}

VectorXd velocity_of_state(const System& system, const State& state) {
  return mechanics::velocity_of_momentum(system, state.rotation, state.momentum);
}

Predictor::Predictor(int bodies)
    : unknown_(at((6 * bodies + 3 + 3) / 4 * 4), 0.0), difference_(unknown_.size() * depth, 0.0) {}

void Predictor::remember(const Interval& interval) {
  for_each_stretch(interval, [&](const double* from, std::size_t count, std::size_t place) {
    std::copy_n(from, count, unknown_.data() + place);
  });
  using algebra::Four;
  const std::size_t size = unknown_.size();
  const int kept = std::min(known_, depth - 1);
  Four errors[depth] = {};
  for (std::size_t i = 0; i < size; i += 4) {
    Four value = algebra::load<Four>(unknown_.data() + i);
    for (int d = 0; d < depth; ++d) {
      double* stored = difference_.data() + at(d) * size + i;
      const Four next = value - algebra::load<Four>(stored);
      algebra::store(value, stored);
      const Four magnitude = value < 0.0 ? -value : value;
      errors[d] = magnitude > errors[d] ? magnitude : errors[d];
      value = next;
    }
  }
  known_ = std::min(known_ + 1, depth);
  degree_ = 1;
  double least = largest_of(errors[1]);
  for (int d = 2; d <= kept; ++d)
    if (const double error = largest_of(errors[d]); error < least) degree_ = d, least = error;
}

void Predictor::predict(Interval& interval, double scale) {
  const std::size_t size = unknown_.size();
  const int terms = std::min(degree_, known_);
  for (std::size_t i = 0; i < size; i += 4) {
    using algebra::Four;
    Four sum = algebra::load<Four>(difference_.data() + i);
    for (int d = 1; d < terms; ++d) sum += algebra::load<Four>(difference_.data() + at(d) * size + i);
    algebra::store(scale * sum, unknown_.data() + i);
  }
  for_each_stretch(interval, [&](double* to, std::size_t count, std::size_t place) {
    std::copy_n(unknown_.data() + place, count, to);
  });
}

StepWorkspace::StepWorkspace(const System& system)
    : interval(system.body_count()),
      momenta(system.body_count()),
      predictor(system.body_count()),
      target(at(system.body_count())),
      missing(at(system.body_count())),
      force(at(system.body_count())),
      base_turn(at(system.body_count())),
      no_force(at(system.body_count()), Vector3d::Zero()),
      moments(system.body_count()),
      damping(system.body_count()),
      damping_next(system.body_count()),
      damping_force(at(system.body_count())),
      damping_block(at(system.body_count()), Matrix3d::Zero()),
      blocks(at(system.body_count())),
      elimination(system) {}

void joint_forces(const System& system, const Rotations& rotation, const Moments& control, StepWorkspace& work,
                  Freedoms& force) {
  work.moments.set_zero();
  mechanics::add_node_moments(system, rotation, control, 1.0, work.moments);
  gather_moments(system, rotation, work.no_force, work.moments, force);
}

StepReport solve_step(const System& system, DiscreteLagrangian lagrangian, double h, const Vector3d& linear,
                      StepWorkspace& work) {
  StepReport report;
  report.residual = evaluate(system, lagrangian, h, linear, work);
  const double sought = attainable(system, work.sought_residual);
  const double accepted = attainable(system, accepted_residual);
  bool factored = false;
  while (!(report.residual <= sought) && report.iterations < max_iterations) {
    if (!std::isfinite(report.residual) || (!factored && !factor(system, lagrangian, h, work))) return report;
    keep_turns(system, work);
    const Vector3d base_displacement = work.interval.displacement;
    const double before = report.residual;
    Vector3d shift = linear - work.momenta.linear;
    work.elimination.solve(system, work.interval.rotation, work.interval.next_rotation, work.missing, shift);
    ++report.iterations;
    move(system, 1.0, work.missing, base_displacement, shift, work);
    work.force = work.missing;  // the correction, should it have to be shortened
    report.residual = evaluate(system, lagrangian, h, linear, work);
    if (before < accepted && !(report.residual < 0.25 * before)) break;
    // before round-off, steps that do not help are halved until they do
    for (double fraction = 0.5; fraction > 1e-3 && !(report.residual < before); fraction *= 0.5) {
      move(system, fraction, work.force, base_displacement, shift, work);
      report.residual = evaluate(system, lagrangian, h, linear, work);
    }
    factored = report.residual < good_contraction * before;
  }
  report.converged = report.residual < accepted;
  return report;
}

StepReport advance(const System& system, DiscreteLagrangian lagrangian, double h, const Moments& control,
                   const Moments& control_next, State& state, StepWorkspace& work) {
  const Vector3d linear = state.momentum.tail<3>();
  work.interval.rotation = state.rotation;
  if (std::exchange(work.begun, false)) {
    // where the caller has set it
  } else if (work.predictor.knows()) {
    work.predictor.predict(work.interval, h / work.latest_time_step);
  } else {
    stand_still(work.interval);
  }
  if (!finite(control_next)) return {false, 0, std::numeric_limits<double>::quiet_NaN()};
  joint_forces(system, state.rotation, control, work, work.force);
  mechanics::unpack(system, state.momentum, work.target);
  for (std::size_t i = 0; i < work.target.size(); ++i) work.target[i] += 0.5 * h * work.force[i];
  const StepReport report = solve_step(system, lagrangian, h, linear, work);
  if (!report.converged) return report;
  work.predictor.remember(work.interval);
  work.latest_time_step = h;
  accept(system, h, control_next, state, work);
  return report;
}

}  // namespace lamprey::integrator
