#include "integrator/adjoint.hpp"

#include "integrator/march.hpp"
#include "integrator/step_derivatives.hpp"

namespace lamprey::integrator {

namespace {

using mechanics::ForcedStep;
using mechanics::Interval;
using mechanics::NodeTurns;
using mechanics::RateKind;
using mechanics::StepRate;
using mechanics::StepVariation;
using model::at;
using model::System;

void add(const Vectors& terms, double weight, Vectors& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * terms[i];
}

void set_zero(Vectors& vectors) {
  for (Vector3d& v : vectors) v.setZero();
}

Vectors zeros(int count) { return Vectors(at(count), Vector3d::Zero()); }

Trajectory empty_trajectory(const System& system, Scheme scheme, double duration, int steps) {
  Trajectory trajectory;
  trajectory.system = &system;
  trajectory.lagrangian = lagrangian_of(scheme);
  trajectory.duration = duration;
  for (int k = 0; k < steps; ++k)
    for (double fraction : composition(scheme).fractions) trajectory.fraction.push_back(fraction / steps);
  return trajectory;
}

// Marches under `trajectory.control`, [steps · stages + 1].
void march(Scheme scheme, int steps, const State& start, Trajectory& trajectory) {
  March march(*trajectory.system, scheme);
  State state = start;
  trajectory.interval.reserve(trajectory.fraction.size());
  trajectory.state.reserve(trajectory.fraction.size() + 1);
  trajectory.state.push_back(start);
  for (int k = 0; k < steps; ++k) {
    trajectory.report = march.advance(
        trajectory.duration / steps,
        [&](int stage) -> const Moments& { return trajectory.control[at(k * march.stages() + stage)]; }, state,
        [&](const Interval& interval, const State& after) {
          trajectory.interval.push_back(interval);
          trajectory.state.push_back(after);
        });
    if (!trajectory.report.converged) return;
  }
}

}  // namespace

Trajectory roll_out(const System& system, Scheme scheme, double duration, int steps, const State& start,
                    const std::vector<Moments>& control) {
  Trajectory trajectory = empty_trajectory(system, scheme, duration, steps);
  trajectory.control = control;
  march(scheme, steps, start, trajectory);
  return trajectory;
}

Trajectory roll_out(const System& system, Scheme scheme, double duration, int steps, const State& start,
                    const TimeControl& control) {
  std::vector<Moments> moments;
  const std::vector<double> nodes = March(system, scheme).nodes();
  for (int k = 0; k < steps; ++k)
    for (std::size_t s = 0; s + 1 < nodes.size(); ++s) moments.push_back(control((k + nodes[s]) * duration / steps));
  moments.push_back(control(duration));
  return roll_out(system, scheme, duration, steps, start, moments);
}

StateGradient::StateGradient(const System& system)
    : turn(zeros(system.body_count())),
      position(Vector3d::Zero()),
      momentum(zeros(system.body_count())),
      linear(Vector3d::Zero()) {}

void StateGradient::set_zero() {
  integrator::set_zero(turn);
  integrator::set_zero(momentum);
  position.setZero();
  linear.setZero();
}

ParameterGradient::ParameterGradient(const System& system)
    : mass_matrix(at(system.body_count()), Matrix3d::Zero()),
      inertia_matrix(mass_matrix),
      coupling_matrix(mass_matrix),
      parent_offset(zeros(system.joint_count())),
      child_offset(zeros(system.joint_count())),
      stiffness(VectorXd::Zero(system.joint_count())),
      damping(VectorXd::Zero(system.joint_count())) {}

TrajectoryGradient::TrajectoryGradient(const Trajectory& trajectory)
    : by_start(*trajectory.system),
      by_control(trajectory.control.size(), zeros(trajectory.system->joint_count())),
      by_parameters(*trajectory.system) {}

TrajectoryDirection::TrajectoryDirection(const Trajectory& trajectory)
    : start(*trajectory.system), control(trajectory.control.size(), zeros(trajectory.system->joint_count())) {}

HessianProduct::HessianProduct(const Trajectory& trajectory)
    : by_start(*trajectory.system), by_control(trajectory.control.size(), zeros(trajectory.system->joint_count())) {}

AdjointSweep::AdjointSweep(const Trajectory& trajectory)
    : trajectory_(trajectory),
      system_(*trajectory.system),
      elimination_(trajectory.interval.size(), mechanics::TreeElimination(system_)),
      balance_(trajectory.interval.size(), mechanics::StepBalance(system_.body_count())),
      multiplier_(trajectory.interval.size(), StepVariation(system_)),
      multiplier_rate_(trajectory.interval.size(), StepRate(system_.body_count())),
      motion_(trajectory.interval.size(), StepVariation(system_)),
      blocks_(at(system_.body_count())),
      damping_(at(system_.body_count()), Matrix3d::Zero()),
      rate_(system_.body_count()),
      motion_rate_(system_.body_count()),
      variation_(system_),
      second_(system_.body_count()),
      node_moments_(system_.body_count()),
      minus_(zeros(system_.body_count())),
      plus_(zeros(system_.body_count())),
      work_(zeros(system_.joint_count())),
      costate_(system_) {}

ForcedStep AdjointSweep::forced(int k) const {
  return {system_,
          trajectory_.lagrangian,
          trajectory_.time_step(k),
          trajectory_.interval[at(k)],
          trajectory_.control[at(k)],
          trajectory_.control[at(k + 1)]};
}

// From the costate at k + 1 to that at k: equation 8.34.
void AdjointSweep::pull_back(int k, StateGradient& costate, TrajectoryGradient& result) {
  const ForcedStep step = forced(k);
  mechanics::StepBalance& balance = balance_[at(k)];
  evaluate_balance(step, balance);
  factor_step(step, balance.momenta, blocks_, damping_, elimination_[at(k)]);

  // what the next momentum makes of the next configuration, then the multiplier of E⁻ = μ
  StepVariation& w = multiplier_[at(k)];
  w.set_zero();
  w.right = costate.momentum;
  evaluate_rate(step, balance, w, RateKind::adjoint, rate_);
  w.left = costate.turn;
  add(rate_.plus, 1.0, w.left);
  w.displacement = costate.position + rate_.linear;
  elimination_[at(k)].solve_transposed(system_, step.interval.rotation, step.interval.next_rotation, w.left,
                                       w.displacement);
  w.displacement = -w.displacement;

  StepRate& rate = multiplier_rate_[at(k)];
  evaluate_rate(step, balance, w, RateKind::adjoint, rate);
  costate.turn = rate.minus;
  costate.momentum = w.left;
  costate.linear -= w.displacement;
  const double half = 0.5 * step.time_step;
  mechanics::control_work(system_, step.interval.rotation, {w.left, rate.turn}, work_);
  add(work_, half, result.by_control[at(k)]);
  mechanics::control_work(system_, step.interval.next_rotation, {w.right, rate.turn_next}, work_);
  add(work_, half, result.by_control[at(k + 1)]);
  add_parameters(k, result);
}

void AdjointSweep::add_parameters(int k, TrajectoryGradient& result) {
  const ForcedStep step = forced(k);
  const Interval& interval = step.interval;
  const mechanics::DiscreteMomenta& p = balance_[at(k)].momenta;
  const StepVariation& w = multiplier_[at(k)];
  const StepRate& rate = multiplier_rate_[at(k)];
  const NodeTurns left{w.left, rate.turn}, right{w.right, rate.turn_next};

  double kinetic = 0.0;
  for (std::size_t i = 0; i < rate.seen.size(); ++i)
    kinetic += p.turn[i].dot(rate.seen[i].turn) + p.impulse[i].dot(rate.seen[i].shift);
  node_moments_.set_zero();
  add_node_moments(system_, interval.rotation, step.control, 0.5, node_moments_);
  double work = virtual_work(node_moments_, left);
  node_moments_.set_zero();
  add_node_moments(system_, interval.next_rotation, step.control_next, 0.5, node_moments_);
  work += virtual_work(node_moments_, right);
  result.by_duration += trajectory_.fraction[at(k)] * (work - kinetic / step.time_step);

  ParameterGradient& by = result.by_parameters;
  const double half = 0.5 * step.time_step;
  add_spring_work(system_, interval.rotation, left, half, by.stiffness);
  add_spring_work(system_, interval.next_rotation, right, half, by.stiffness);
  add_damping_work(system_, interval, left, right, by.damping);
  for (int i = 0; i < system_.body_count(); ++i) {
    mechanics::BodyInertiaGradient inertia;
    mechanics::BodyLagrangian(system_, step.lagrangian, step.time_step, i)
        .add_inertia_gradient(body_step(interval, p, i), rate.seen[at(i)], 1.0, inertia);
    by.mass_matrix[at(i)] += inertia.mass_matrix;
    by.inertia_matrix[at(i)] += inertia.inertia_matrix;
    by.coupling_matrix[at(i)] += inertia.coupling_matrix;
    const int j = system_.body(i).joint;
    if (j < 0) continue;
    // the subtree's displacement holds (R' − R) d of the parent and −(R' − R) d of the child
    const auto by_offset = [&](int b) {
      const Matrix3d& R = interval.rotation[at(b)];
      const Matrix3d& R_next = interval.next_rotation[at(b)];
      const Vector3d& force = p.subtree_linear[at(i)];
      return Vector3d((R_next - R).transpose() * rate.force[at(i)] -
                      rate.turn_next[at(b)].cross(R_next.transpose() * force) +
                      rate.turn[at(b)].cross(R.transpose() * force));
    };
    by.parent_offset[at(j)] += by_offset(system_.body(i).parent);
    by.child_offset[at(j)] += inertia.child_offset - by_offset(i);
  }
}

void AdjointSweep::gradient(const Objective& objective, TrajectoryGradient& result) {
  const int steps = trajectory_.steps();
  StateGradient& costate = costate_;
  costate.set_zero();
  result.by_duration = 0.0;
  result.by_parameters = ParameterGradient(system_);
  for (Moments& by : result.by_control) set_zero(by);
  objective.add_gradient(steps, trajectory_.state[at(steps)], trajectory_.control[at(steps)], costate,
                         result.by_control[at(steps)]);
  for (int k = steps - 1; k >= 0; --k) {
    pull_back(k, costate, result);
    objective.add_gradient(k, trajectory_.state[at(k)], trajectory_.control[at(k)], costate, result.by_control[at(k)]);
  }
  result.by_start = costate;
}

// A direction of the state through step k: equation 8.33.
void AdjointSweep::push(int k, const TrajectoryDirection& direction, StateGradient& moved) {
  const ForcedStep step = forced(k);
  StepVariation& z = motion_[at(k)];
  z.left = moved.turn;
  z.control = direction.control[at(k)];
  z.control_next = direction.control[at(k + 1)];
  set_zero(z.right);
  z.displacement.setZero();
  evaluate_rate(step, balance_[at(k)], z, RateKind::tangent, rate_);
  for (std::size_t i = 0; i < z.right.size(); ++i) z.right[i] = moved.momentum[i] - rate_.minus[i];
  z.displacement = moved.linear - rate_.linear;
  elimination_[at(k)].solve(system_, step.interval.rotation, step.interval.next_rotation, z.right, z.displacement);
  evaluate_rate(step, balance_[at(k)], z, RateKind::tangent, rate_);
  moved.turn = z.right;
  moved.position += z.displacement;
  moved.momentum = rate_.plus;
}

void AdjointSweep::tangent(const TrajectoryDirection& direction, StateGradient& end) {
  end = direction.start;
  moved_.clear();
  moved_.push_back(end);
  for (int k = 0; k < trajectory_.steps(); ++k) {
    push(k, direction, end);
    moved_.push_back(end);
  }
}

// Rate of the costate along the direction: equation 8.37.
void AdjointSweep::pull_back_rate(int k, StateGradient& costate, HessianProduct& result) {
  const ForcedStep step = forced(k);
  const mechanics::StepBalance& balance = balance_[at(k)];
  mechanics::TreeElimination& elimination = elimination_[at(k)];
  const StepVariation& w = multiplier_[at(k)];
  const StepRate& w_rate = multiplier_rate_[at(k)];
  const StepVariation& z = motion_[at(k)];
  evaluate_rate(step, balance, z, RateKind::tangent, motion_rate_);
  Vector3d linear;
  evaluate_adjoint_rate(step, balance, w, w_rate, z, motion_rate_, second_, minus_, plus_, linear);

  StepVariation& change = variation_;  // of the multiplier
  change.set_zero();
  change.right = costate.momentum;
  evaluate_rate(step, balance, change, RateKind::adjoint, rate_);
  change.left = costate.turn;
  add(rate_.plus, 1.0, change.left);
  add(plus_, 1.0, change.left);
  change.displacement = costate.position + rate_.linear + linear;
  elimination.solve_transposed(system_, step.interval.rotation, step.interval.next_rotation, change.left,
                               change.displacement);
  change.displacement = -change.displacement;
  evaluate_rate(step, balance, change, RateKind::adjoint, rate_);
  costate.turn = rate_.minus;
  add(minus_, 1.0, costate.turn);
  costate.momentum = change.left;
  costate.linear -= change.displacement;

  const double half = 0.5 * step.time_step;
  const auto add_control = [&](const mechanics::Rotations& R, NodeTurns of_change, NodeTurns of_w, NodeTurns of_z,
                               const Vectors& turn_change, Moments& sum) {
    mechanics::control_work(system_, R, of_change, work_);
    add(work_, half, sum);
    mechanics::control_work_rate(system_, R, of_w, of_z, turn_change, work_);
    add(work_, half, sum);
  };
  add_control(step.interval.rotation, {change.left, rate_.turn}, {w.left, w_rate.turn}, {z.left, motion_rate_.turn},
              second_.turn_change, result.by_control[at(k)]);
  add_control(step.interval.next_rotation, {change.right, rate_.turn_next}, {w.right, w_rate.turn_next},
              {z.right, motion_rate_.turn_next}, second_.turn_change_next, result.by_control[at(k + 1)]);
}

void AdjointSweep::hessian_product(const Objective& objective, const TrajectoryDirection& direction,
                                   HessianProduct& result) {
  const int steps = trajectory_.steps();
  StateGradient& costate = costate_;
  tangent(direction, costate);
  costate.set_zero();
  for (Moments& by : result.by_control) set_zero(by);
  const auto add_node = [&](int k) {
    objective.add_gradient_rate(k, trajectory_.state[at(k)], trajectory_.control[at(k)], moved_[at(k)],
                                direction.control[at(k)], costate, result.by_control[at(k)]);
  };
  add_node(steps);
  for (int k = steps - 1; k >= 0; --k) {
    pull_back_rate(k, costate, result);
    add_node(k);
  }
  result.by_start = costate;
}

}  // namespace lamprey::integrator
