#include "integrator/step_derivatives.hpp"

#include <limits>

namespace lamprey::integrator {

namespace {

using mechanics::ForcedStep;
using mechanics::RateKind;
using model::at;
using model::System;

// Writes a direction's change of the next state, momentum included, into a column.
void put(const System& system, const Freedoms& freedoms, const Vector3d& shift, const Freedoms& momentum,
         const Vector3d& linear, VectorXd& packed, Eigen::Ref<VectorXd> column) {
  const int half = system.velocity_count();
  mechanics::pack(system, freedoms, shift, packed);
  column.head(half) = packed;
  mechanics::pack(system, momentum, linear, packed);
  column.tail(half) = packed;
}

// Follows one direction of the state and of u_k through the step: turns at k and δp_x in `work.variation`, δμ in
// `momentum`, δx in `position`; fills a column of A or B.
void follow(const ForcedStep& step, const Freedoms& momentum, const Vector3d& linear, const Vector3d& position,
            TangentWorkspace& work, Eigen::Ref<VectorXd> column) {
  const System& system = step.system;
  mechanics::StepVariation& v = work.variation;
  for (Vector3d& right : v.right) right.setZero();
  v.displacement.setZero();
  evaluate_rate(step, work.balance, v, RateKind::tangent, work.rate);
  for (std::size_t i = 0; i < v.right.size(); ++i) v.right[i] = momentum[i] - work.rate.minus[i];
  v.displacement = linear - work.rate.linear;
  work.elimination.solve(system, step.interval.rotation, step.interval.next_rotation, v.right, v.displacement);
  evaluate_rate(step, work.balance, v, RateKind::tangent, work.rate);
  put(system, v.right, position + v.displacement, work.rate.plus, linear, work.column, column);
}

// Calls f with each freedom of each body: body, entry, its place in generalised vectors.
template <typename Function>
void for_each_freedom(const System& system, const Function& f) {
  for (int i = 0; i < system.body_count(); ++i)
    for (int entry = 0; entry < system.body(i).freedoms; ++entry)
      f(at(i), entry, system.body(i).velocity_offset + entry);
}

}  // namespace

StepTangent::StepTangent(const System& system)
    : A(MatrixXd::Zero(2 * system.velocity_count(), 2 * system.velocity_count())),
      B(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())),
      B_next(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())) {}

TangentWorkspace::TangentWorkspace(const System& system)
    : balance(system.body_count()),
      variation(system),
      rate(system.body_count()),
      blocks(at(system.body_count())),
      damping(at(system.body_count()), Matrix3d::Zero()),
      elimination(system),
      freedoms(at(system.body_count())),
      column(system.velocity_count()) {}

bool factor_step(const ForcedStep& step, const mechanics::DiscreteMomenta& momenta,
                 std::vector<mechanics::BodyBlock>& blocks, std::vector<Matrix3d>& damping,
                 mechanics::TreeElimination& elimination) {
  mechanics::step_blocks(step.system, step.lagrangian, step.time_step, step.interval, momenta, blocks);
  if (!step.system.only_free_joints()) mechanics::damping_blocks(step.system, step.interval, damping);
  return elimination.factor(step.system, step.interval.rotation, step.interval.next_rotation, blocks, damping);
}

void linearize_step(const System& system, DiscreteLagrangian lagrangian, double h, const mechanics::Interval& interval,
                    const Moments& control, const Moments& control_next, TangentWorkspace& work, StepTangent& tangent) {
  const int half = system.velocity_count();
  const ForcedStep step{system, lagrangian, h, interval, control, control_next};
  evaluate_balance(step, work.balance);
  if (!factor_step(step, work.balance.momenta, work.blocks, work.damping, work.elimination)) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    tangent.A.setConstant(unknown);
    tangent.B.setConstant(unknown);
    tangent.B_next.setConstant(unknown);
    return;
  }
  work.variation.set_zero();
  for (Vector3d& m : work.freedoms) m.setZero();
  const Vector3d none = Vector3d::Zero();
  for_each_freedom(system, [&](std::size_t i, int entry, int place) {
    work.variation.left[i][entry] = 1.0;
    follow(step, work.freedoms, none, none, work, tangent.A.col(place));
    work.variation.left[i][entry] = 0.0;
    work.freedoms[i][entry] = 1.0;
    follow(step, work.freedoms, none, none, work, tangent.A.col(half + place));
    work.freedoms[i][entry] = 0.0;
  });
  for (int entry = 0; entry < 3; ++entry) {
    tangent.A.col(half - 3 + entry) = VectorXd::Unit(2 * half, half - 3 + entry);  // a shift of the whole
    follow(step, work.freedoms, Vector3d::Unit(entry), none, work, tangent.A.col(2 * half - 3 + entry));
  }
  int column = 0;
  for (int j = 0; j < system.joint_count(); ++j) {
    const auto& actuation = system.joint(j).actuation;
    for (Eigen::Index c = 0; c < actuation.cols(); ++c, ++column) {
      work.variation.control[at(j)] = actuation.col(c);
      follow(step, work.freedoms, none, none, work, tangent.B.col(column));
      work.variation.control[at(j)].setZero();
      for (auto* ends : {&work.variation.left, &work.variation.right})
        for (Vector3d& turn : *ends) turn.setZero();
      work.variation.displacement.setZero();
      work.variation.control_next[at(j)] = actuation.col(c);
      evaluate_rate(step, work.balance, work.variation, RateKind::tangent, work.rate);
      work.variation.control_next[at(j)].setZero();
      put(system, work.freedoms, none, work.rate.plus, none, work.column, tangent.B_next.col(column));
    }
  }
}

PulledBack pull_back(const StepTangent& tangent, const MatrixXd& rows) {
  return {rows * tangent.A, rows * tangent.B, rows * tangent.B_next};
}

SweptGradients gradient_sweep(const System& system, DiscreteLagrangian lagrangian, double h,
                              const IntervalSource& source, const std::vector<Moments>& control, StepRange range,
                              const MatrixXd& end_rows) {
  const int controls = system.control_count();
  SweptGradients result{end_rows, MatrixXd::Zero(end_rows.rows(), controls * range.nodes())};
  TangentWorkspace work(system);
  StepTangent tangent(system);
  mechanics::Interval interval(system.body_count());
  for (int k = range.last - 1; k >= range.first; --k) {
    source(k, interval);
    linearize_step(system, lagrangian, h, interval, control[at(k)], control[at(k + 1)], work, tangent);
    PulledBack pulled = pull_back(tangent, result.by_start);
    result.by_control.middleCols(controls * (k - range.first), controls) += pulled.by_control;
    result.by_control.middleCols(controls * (k + 1 - range.first), controls) += pulled.by_next_control;
    result.by_start.swap(pulled.by_state);
  }
  return result;
}

}  // namespace lamprey::integrator
