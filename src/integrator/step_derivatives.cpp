#include "integrator/step_derivatives.hpp"

#include <limits>

namespace lamprey::integrator {

namespace {

using mechanics::ForcedStep;
using model::at;
using model::System;

// Calls f with each freedom of each body: body, entry, its place in generalised vectors.
template <typename Function>
void for_each_freedom(const System& system, const Function& f) {
  for (int i = 0; i < system.body_count(); ++i)
    for (int entry = 0; entry < system.body(i).freedoms; ++entry)
      f(at(i), entry, system.body(i).velocity_offset + entry);
}

// Rows of freedoms as columns, bodies one below the other from `row` on.
void put(const System& system, const mechanics::FreedomRows& freedoms, Eigen::Index row, Eigen::Ref<MatrixXd> columns) {
  for (int i = 0; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    const mechanics::Rows3& rows = freedoms[at(i)];
    const Eigen::Index place = row + body.velocity_offset;
    for (Eigen::Index r = 0; r < columns.cols(); ++r)
      for (int entry = 0; entry < body.freedoms; ++entry) columns(place + entry, r) = rows(r, entry);
  }
}

// One direction for each freedom's momentum, and three for p_x.
void lay_unit_momenta(const System& system, mechanics::StepDirections& d) {
  const Eigen::Index half = system.velocity_count();
  for (mechanics::Rows3& rows : d.right) mechanics::clear_rows(half, rows);
  for_each_freedom(system, [&](std::size_t i, int entry, int place) { d.right[i](place, entry) = 1.0; });
  mechanics::clear_rows(half, d.displacement);
  d.displacement.middleRows(half - 3, 3).setIdentity();
}

// Half a step's impulses of unit moments at a node along the freedoms, [freedoms][controls].
void put_controls(const System& system, const mechanics::Rotations& R, double h, TangentWorkspace& work,
                  Eigen::Ref<MatrixXd> columns) {
  for (mechanics::Rows3& rows : work.control_rows) rows.setZero();
  mechanics::add_control_rows(system, R, 0.5 * h, 0, work.control_rows);
  put(system, work.control_rows, 0, columns);
}

}  // namespace

StepTangent::StepTangent(const System& system)
    : A(MatrixXd::Zero(2 * system.velocity_count(), 2 * system.velocity_count())),
      B(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())),
      B_next(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())) {}

TangentWorkspace::TangentWorkspace(const System& system)
    : balance(system.body_count()),
      rates(at(system.body_count())),
      blocks(at(system.body_count())),
      damping(at(system.body_count()), Matrix3d::Zero()),
      elimination(system),
      directions(system.body_count(), system.velocity_count()),
      jacobian(system.body_count(), system.velocity_count()),
      by_turns(system.velocity_count(), system.velocity_count() - 3),
      by_controls(system.velocity_count() - 3, system.control_count()),
      control_rows(at(system.body_count()), mechanics::Rows3::Zero(mechanics::rows_for(system.control_count()), 3)) {
  for_each_freedom(system, [&](std::size_t i, int entry, int place) { directions.left[i](place, entry) = 1.0; });
}

bool factor_step(const ForcedStep& step, const mechanics::DiscreteMomenta& momenta,
                 std::vector<mechanics::BodyBlock>& blocks, std::vector<Matrix3d>& damping,
                 mechanics::TreeElimination& elimination) {
  mechanics::step_blocks(step.system, step.lagrangian, step.time_step, step.interval, momenta, blocks);
  mechanics::damping_blocks(step.system, step.interval, damping);
  return elimination.factor(step.system, step.interval.rotation, step.interval.next_rotation, blocks, damping);
}

void linearize_step(const System& system, DiscreteLagrangian lagrangian, double h, const mechanics::Interval& interval,
                    const Moments& control, const Moments& control_next, TangentWorkspace& work, StepTangent& tangent) {
  const int half = system.velocity_count();
  const ForcedStep step{system, lagrangian, h, interval, control, control_next};
  evaluate_balance(step, work.balance);
  body_rates(step, work.balance.momenta, work.blocks, work.rates);
  mechanics::damping_blocks(system, interval, work.damping);
  if (!work.elimination.factor(system, interval.rotation, interval.next_rotation, work.blocks, work.damping)) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    tangent.A.setConstant(unknown);
    tangent.B.setConstant(unknown);
    tangent.B_next.setConstant(unknown);
    return;
  }

  // along turns at k, the next node held; then along the momentum at k, p_x last
  const Eigen::Index turns = half - 3;
  mechanics::StepDirections& d = work.directions;
  mechanics::StepJacobian& J = work.jacobian;
  rates_at_both_ends(step, work.balance, work.blocks, work.rates, d, turns, turns, J);
  put(system, J.minus, 0, work.by_turns.topRows(turns));
  work.by_turns.bottomRows(3) = J.linear.topRows(turns).transpose();
  put(system, J.plus, half, tangent.A.leftCols(turns));
  lay_unit_momenta(system, d);
  work.elimination.solve_rows(system, interval.rotation, interval.next_rotation, d.right, d.displacement);
  rates_at_end(step, work.balance, work.blocks, work.rates, d, half, J);
  auto by_momentum = tangent.A.rightCols(half);
  put(system, d.right, 0, by_momentum);
  by_momentum.middleRows(turns, 3) = d.displacement.topRows(half).transpose();
  put(system, J.plus, half, by_momentum);
  by_momentum.bottomRows(3).setZero();
  by_momentum.bottomRightCorner(3, 3).setIdentity();

  // what turns at k and u_k change of E⁻ counts as momentum
  const auto followed = by_momentum.topRows(half + turns);
  auto by_turns = tangent.A.topLeftCorner(half + turns, turns);
  by_turns.topRows(half).setZero();
  algebra::add_product(-1.0, followed, work.by_turns, by_turns);
  tangent.A.bottomLeftCorner(3, turns).setZero();
  tangent.A.middleCols(turns, 3).setZero();
  tangent.A.block(turns, turns, 3, 3).setIdentity();  // a shift of the whole
  put_controls(system, interval.rotation, h, work, work.by_controls);
  tangent.B.setZero();
  algebra::add_product(1.0, followed.leftCols(turns), work.by_controls, tangent.B.topRows(half + turns));
  put_controls(system, interval.next_rotation, h, work, tangent.B_next.middleRows(half, turns));
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
