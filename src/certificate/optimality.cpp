#include "certificate/optimality.hpp"

#include <algorithm>
#include <cstdint>

#include "certificate/goal_check.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/control_path.hpp"
#include "maneuver/row_space.hpp"

namespace lamprey::certificate {

namespace {

using model::at;

constexpr double dependent_row = 1e-11;  // of the largest pivot
constexpr int most_segments = 20;        // a growth of 1e20 over the whole is 10 over each

// Moments along the actuation axes, [N+1][controls].
MatrixXd actuated_moments(const StoredMotion& motion) {
  MatrixXd moments(motion.steps + 1, motion.system.control_count());
  for (int k = 0; k <= motion.steps; ++k) {
    int column = 0;
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const auto& actuation = motion.system.joint(j).actuation;
      const int columns = static_cast<int>(actuation.cols());
      moments.row(k).segment(column, columns) = (actuation.transpose() * motion.control[at(k)][at(j)]).transpose();
      column += columns;
    }
  }
  return moments;
}

// Largest difference of the stored moments from given ones along the axes, relative to the largest moment.
double difference(const StoredMotion& motion, const MatrixXd& moments) {
  Largest outside, largest;
  for (int k = 0; k <= motion.steps; ++k) {
    int column = 0;
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const auto& actuation = motion.system.joint(j).actuation;
      const int columns = static_cast<int>(actuation.cols());
      const Vector3d& u = motion.control[at(k)][at(j)];
      outside.add((u - actuation * moments.row(k).segment(column, columns).transpose()).norm());
      largest.add(u.norm());
      column += columns;
    }
  }
  return outside.relative_to(largest.value());
}

// Rows by the moments at all nodes turned into rows by the free numbers.
MatrixXd by_free_numbers(const StoredMotion& motion, const ControlSpace& space, const MatrixXd& by_nodes) {
  if (space.basis.size() == 0) return by_nodes;
  const int controls = motion.system.control_count();
  MatrixXd by_points(by_nodes.rows(), controls * space.basis.cols());
  for (Eigen::Index r = 0; r < by_nodes.rows(); ++r) {
    const VectorXd row = by_nodes.row(r);
    by_points.row(r) = (row.reshaped(controls, motion.steps + 1) * space.basis).reshaped().transpose();
  }
  return by_points;
}

integrator::SweptGradients sweep(const StoredMotion& motion, integrator::StepRange range, const MatrixXd& end_rows) {
  return integrator::gradient_sweep(
      motion.system, motion.lagrangian, motion.time_step,
      [&motion](int k, mechanics::Interval& interval) { read_interval(motion, k, interval); }, motion.control, range,
      end_rows);
}

// Typical size of each entry of a state's perturbation when turns and shifts are of size 1 over `duration` s.
VectorXd state_scale(const StoredMotion& motion, double duration) {
  const MatrixXd inertia = mechanics::generalized_inertia(motion.system, motion.solution.rotation.front());
  VectorXd scale(2 * inertia.rows());
  scale << VectorXd::Ones(inertia.rows()), inertia.diagonal() / duration;
  return scale;
}

}  // namespace

ControlSpace control_space(const StoredMotion& motion) {
  const MatrixXd moments = actuated_moments(motion);
  if (motion.problem.control == maneuver::ControlKind::steps)
    return {moments.transpose().reshaped(), MatrixXd(), difference(motion, moments)};
  const double duration = motion.steps * motion.time_step;
  const MatrixXd basis = maneuver::natural_spline_basis(motion.problem.points, duration,
                                                        VectorXd::LinSpaced(motion.steps + 1, 0.0, duration));
  const MatrixXd points = maneuver::least_squares(basis, moments);
  return {points.transpose().reshaped(), basis, difference(motion, basis * points)};
}

VectorXd node_weights(const StoredMotion& motion) {
  VectorXd weights = VectorXd::Constant(motion.steps + 1, motion.problem.effort * motion.time_step);
  if (motion.problem.cost_rule() == maneuver::CostRule::trapezoid) {
    weights[0] *= 0.5;
    weights[motion.steps] *= 0.5;
  }
  return weights;
}

VectorXd cost_gradient(const StoredMotion& motion, const ControlSpace& space) {
  const int controls = motion.system.control_count();
  if (space.basis.size() == 0)
    return (space.value.reshaped(controls, motion.steps + 1) * node_weights(motion).asDiagonal()).reshaped();
  const MatrixXd points = space.value.reshaped(controls, space.basis.cols());
  return (points * space.basis.transpose() * node_weights(motion).asDiagonal() * space.basis).reshaped();
}

MatrixXd control_jacobian(const StoredMotion& motion, const ControlSpace& space, const MatrixXd& end_rows) {
  return by_free_numbers(motion, space, sweep(motion, {0, motion.steps}, end_rows).by_control);
}

MatrixXd spanning_rows(const StoredMotion& motion, const ControlSpace& space, const MatrixXd& end_rows) {
  const int controls = motion.system.control_count();
  const int segments = std::min(most_segments, motion.steps);
  const auto node = [&](int s) { return static_cast<int>(std::int64_t{motion.steps} * s / segments); };
  const VectorXd scale = state_scale(motion, motion.time_step * node(1));
  const int size = static_cast<int>(scale.size());
  // unknowns: scaled costates at the inner segment ends, then the goal's multipliers
  const auto unknowns = static_cast<int>(end_rows.rows()) + size * (segments - 1);
  MatrixXd ties = MatrixXd::Zero(size * (segments - 1), unknowns);
  MatrixXd by_nodes = MatrixXd::Zero(unknowns, controls * (motion.steps + 1));
  for (int s = 0; s < segments; ++s) {
    const bool last = s + 1 == segments;
    const MatrixXd rows = last ? end_rows : MatrixXd(scale.cwiseInverse().asDiagonal());
    const auto swept = sweep(motion, {node(s), node(s + 1)}, rows);
    by_nodes.block(size * s, controls * node(s), rows.rows(), swept.by_control.cols()) += swept.by_control;
    if (s == 0) continue;
    ties.block(size * (s - 1), size * (s - 1), size, size).setIdentity();
    ties.block(size * (s - 1), size * s, size, rows.rows()) = -(scale.asDiagonal() * swept.by_start.transpose());
  }
  return by_free_numbers(motion, space, maneuver::null_space(ties).transpose() * by_nodes);
}

double kkt_residual(const StoredMotion& motion, const ControlSpace& space, double momentum_scale) {
  const VectorXd gradient = cost_gradient(motion, space);
  const integrator::State end = node_states(motion).back();
  const GoalRows goal = goal_rows(motion.system, motion.problem, end, momentum_scale);
  const MatrixXd rows = spanning_rows(motion, space, goal.unit.cwiseInverse().asDiagonal() * goal.by_end_state);
  Largest left, whole;
  // multipliers, which may be large along an unstable motion, are not formed
  for (double entry : maneuver::beyond_rows(gradient, rows, dependent_row)) left.add(std::abs(entry));
  for (double entry : gradient) whole.add(std::abs(entry));
  return left.relative_to(whole.value());
}

}  // namespace lamprey::certificate
