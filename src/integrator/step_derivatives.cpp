#include "integrator/step_derivatives.hpp"

#include <Eigen/LU>

namespace lamprey::integrator {

namespace {

using lie::hat;
using model::System;

using model::at;

// Derivative of U by turns η, and U of unit controls (equation 4.6).
void force_derivatives(const System& system, const Rotations& R, const Moments& control, MatrixXd& by_turn,
                       MatrixXd& map) {
  by_turn.setZero();
  map.setZero();
  int column = 0;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const int p = 3 * joint.parent;
    const int c = 3 * joint.child;
    const Matrix3d Q = R[at(joint.child)].transpose() * R[at(joint.parent)];
    const Vector3d& u = control[at(j)];
    by_turn.block<3, 3>(c, c) -= hat(Q * u);
    by_turn.block<3, 3>(c, p) += Q * hat(u);
    const int columns = static_cast<int>(joint.actuation.cols());
    map.block(p, column, 3, columns) += joint.actuation;
    map.block(c, column, 3, columns) -= Q * joint.actuation;
    column += columns;
  }
}

}  // namespace

StepTangent::StepTangent(const System& system)
    : A(MatrixXd::Zero(2 * system.velocity_count(), 2 * system.velocity_count())),
      B(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())),
      B_next(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())) {}

TangentWorkspace::TangentWorkspace(const System& system)
    : derivatives(system.body_count()),
      quadratic(system.body_count()),
      jacobian(system.body_count()),
      given(system.velocity_count(), 2 * system.velocity_count() + system.control_count()),
      next(system.velocity_count(), 2 * system.velocity_count() + system.control_count()),
      moment(system.velocity_count(), 2 * system.velocity_count() + system.control_count()),
      force_derivative(3 * system.body_count(), 3 * system.body_count()),
      force_map(3 * system.body_count(), system.control_count()) {}

void linearize_step(const System& system, DiscreteLagrangian lagrangian, double h, const mechanics::Interval& interval,
                    const Moments& control, const Moments& control_next, TangentWorkspace& work, StepTangent& tangent) {
  const int turns = 3 * system.body_count();
  const int half = system.velocity_count();
  const int controls = system.control_count();
  mechanics::lagrangian_quadratic(system, lagrangian, h, interval, work.derivatives, work.quadratic);
  mechanics::momentum_jacobian(work.quadratic, work.jacobian);
  const mechanics::MomentumJacobian& K = work.jacobian;

  // p⁻ and p_x at the next node's perturbation answer for the state's and the first moments'
  force_derivatives(system, interval.rotation, control, work.force_derivative, work.force_map);
  work.given.setZero();
  work.given.topLeftCorner(turns, turns) = 0.5 * h * work.force_derivative - K.minus.leftCols(turns);
  work.given.bottomLeftCorner(3, turns) = -K.linear.leftCols(turns);
  work.given.middleCols(half, half).setIdentity();
  work.given.topRightCorner(turns, controls) = 0.5 * h * work.force_map;
  MatrixXd by_next(half, half);
  by_next << K.minus.rightCols(half), K.linear.rightCols(half);
  work.next = by_next.partialPivLu().solve(work.given);

  // momentum at the next node: p⁺ and the second half of the impulse; p_x stays
  force_derivatives(system, interval.next_rotation, control_next, work.force_derivative, work.force_map);
  MatrixXd moment_by_next = K.plus.rightCols(half);
  moment_by_next.leftCols(turns) += 0.5 * h * work.force_derivative;
  work.moment.topRows(turns) = moment_by_next * work.next;
  work.moment.topLeftCorner(turns, turns) += K.plus.leftCols(turns);
  work.moment.bottomRows(3).setZero();
  work.moment.block(turns, 2 * half - 3, 3, 3).setIdentity();

  tangent.A << work.next.leftCols(2 * half), work.moment.leftCols(2 * half);
  tangent.A.block(turns, turns, 3, 3) += Matrix3d::Identity();
  tangent.B << work.next.rightCols(controls), work.moment.rightCols(controls);
  tangent.B_next.middleRows(half, turns) = 0.5 * h * work.force_map;
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
