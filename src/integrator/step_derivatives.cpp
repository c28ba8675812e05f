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
      directions(system.body_count(), 2 * system.velocity_count() - 3 + system.control_count()),
      jacobian(system.body_count(), 2 * system.velocity_count() - 3 + system.control_count()),
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

  // directions: turns at k, then u_k, then the momentum at k, p_x last
  const Eigen::Index turns = half - 3;
  const Eigen::Index controls = system.control_count();
  const Eigen::Index given = turns + controls;  // those that change E⁻ at a fixed next node
  mechanics::StepDirections& d = work.directions;
  mechanics::StepJacobian& J = work.jacobian;
  rates_at_beginning(step, work.balance, work.blocks, work.rates, d, turns, J);
  const Eigen::Index all = given + half;
  const auto set_against = [&](const mechanics::Rows3& rates, mechanics::Rows3& rows) {
    mechanics::clear_rows(all, rows);
    mechanics::add_rows(-1.0, rates, turns, rows);
  };
  for (std::size_t i = 0; i < d.right.size(); ++i) set_against(J.minus[i], d.right[i]);
  set_against(J.linear, d.displacement);
  d.displacement.middleRows(all - 3, 3).setIdentity();
  mechanics::add_control_rows(system, interval.rotation, 0.5 * h, turns, d.right);
  for_each_freedom(system, [&](std::size_t i, int entry, int place) { d.right[i](given + place, entry) = 1.0; });
  work.elimination.solve_rows(system, interval.rotation, interval.next_rotation, d.right, d.displacement);
  rates_at_end(step, work.balance, work.blocks, work.rates, d, all, turns, J);

  const auto put = [&](const mechanics::FreedomRows& freedoms, Eigen::Index first, Eigen::Index count, Eigen::Index row,
                       Eigen::Ref<MatrixXd> columns) {
    for (int i = 0; i < system.body_count(); ++i) {
      const model::Body& body = system.body(i);
      const mechanics::Rows3& rows = freedoms[at(i)];
      const Eigen::Index place = row + body.velocity_offset;
      for (Eigen::Index r = 0; r < count; ++r) {
        double* column = &columns.coeffRef(0, r) + place;
        if (body.freedoms == 3) {
          for (int entry = 0; entry < 3; ++entry) column[entry] = rows(first + r, entry);
        } else {
          for (int entry = 0; entry < body.freedoms; ++entry) column[entry] = rows(first + r, entry);
        }
      }
    }
  };
  const auto put_all = [&](Eigen::Index first, Eigen::Index count, Eigen::Ref<MatrixXd> columns) {
    put(d.right, first, count, 0, columns);
    columns.middleRows(turns, 3) = d.displacement.middleRows(first, count).transpose();
    put(J.plus, first, count, half, columns);
    columns.bottomRows(3).setZero();
  };
  put_all(0, turns, tangent.A.leftCols(turns));
  put_all(turns, controls, tangent.B);
  put_all(given, half, tangent.A.rightCols(half));
  tangent.A.middleCols(turns, 3).setZero();
  tangent.A.block(turns, turns, 3, 3).setIdentity();  // a shift of the whole
  tangent.A.bottomRightCorner(3, 3).setIdentity();
  for (mechanics::Rows3& rows : work.control_rows) rows.setZero();
  mechanics::add_control_rows(system, interval.next_rotation, 0.5 * h, 0, work.control_rows);
  put(work.control_rows, 0, controls, half, tangent.B_next);
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
