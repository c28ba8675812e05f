#include "certificate/optimality.hpp"

#include <Eigen/QR>

#include "certificate/goal_check.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/control_path.hpp"

namespace lamprey::certificate {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double vanishing_row = 1e-11;       // of the largest row: no control moves it
constexpr double dependent_row = 1e-12;       // of the largest pivot, all rows scaled to 1

// Moments along the actuation axes, [N+1][controls].
MatrixXd actuated_moments(const StoredMotion& motion) {
  MatrixXd moments(motion.steps + 1, motion.system.control_count());
  for (int k = 0; k <= motion.steps; ++k) {
    int column = 0;
    for (int j = 0; j < motion.system.joint_count(); ++j) {
      const auto& actuation = motion.system.joint(j).actuation;
      const int columns = static_cast<int>(actuation.cols());
      moments.row(k).segment(column, columns) =
          (actuation.transpose() * motion.solution.control[at(k)][at(j)]).transpose();
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
      const Vector3d& u = motion.solution.control[at(k)][at(j)];
      outside.add((u - actuation * moments.row(k).segment(column, columns).transpose()).norm());
      largest.add(u.norm());
      column += columns;
    }
  }
  return outside.relative_to(largest.value());
}

// Weight of each node's ½|u|² in the cost, s.
VectorXd node_weights(const StoredMotion& motion) {
  VectorXd weights = VectorXd::Constant(motion.steps + 1, motion.problem.effort * motion.time_step);
  if (motion.problem.cost_rule() == maneuver::CostRule::trapezoid) {
    weights[0] *= 0.5;
    weights[motion.steps] *= 0.5;
  }
  return weights;
}

// Rows that no control moves are left out, the others scaled to length 1.
MatrixXd comparable_rows(const MatrixXd& jacobian, const VectorXd& unit) {
  MatrixXd rows = unit.cwiseInverse().asDiagonal() * jacobian;
  const VectorXd length = rows.rowwise().norm();
  Eigen::Index kept = 0;
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    if (length[r] > vanishing_row * length.maxCoeff()) rows.row(kept++) = (rows.row(r) / length[r]).eval();
  rows.conservativeResize(kept, Eigen::NoChange);
  return rows;
}

// What is left of g when the best combination of the rows is taken off: by an orthonormal basis, so that the multipliers,
// which may be large along an unstable motion, need not be formed.
VectorXd beyond_rows(const VectorXd& g, const MatrixXd& rows) {
  if (rows.rows() == 0) return g;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.transpose());
  qr.setThreshold(dependent_row);
  VectorXd left = qr.householderQ().adjoint() * g;
  left.head(qr.rank()).setZero();
  return qr.householderQ() * left;
}

}  // namespace

ControlSpace control_space(const StoredMotion& motion) {
  const MatrixXd moments = actuated_moments(motion);
  if (motion.problem.control == maneuver::ControlKind::steps)
    return {moments.transpose().reshaped(), MatrixXd(), difference(motion, moments)};
  const double duration = motion.steps * motion.time_step;
  const MatrixXd basis = maneuver::natural_spline_basis(motion.problem.points, duration,
                                                        VectorXd::LinSpaced(motion.steps + 1, 0.0, duration));
  const MatrixXd points = basis.completeOrthogonalDecomposition().solve(moments);
  return {points.transpose().reshaped(), basis, difference(motion, basis * points)};
}

VectorXd cost_gradient(const StoredMotion& motion, const ControlSpace& space) {
  const int controls = motion.system.control_count();
  if (space.basis.size() == 0)
    return (space.value.reshaped(controls, motion.steps + 1) * node_weights(motion).asDiagonal()).reshaped();
  const MatrixXd points = space.value.reshaped(controls, space.basis.cols());
  return (points * space.basis.transpose() * node_weights(motion).asDiagonal() * space.basis).reshaped();
}

MatrixXd control_jacobian(const StoredMotion& motion, const ControlSpace& space, const MatrixXd& end_rows) {
  const int controls = motion.system.control_count();
  const MatrixXd by_nodes = integrator::gradient_sweep(
      motion.system, motion.lagrangian, motion.time_step,
      [&motion](int k, mechanics::Interval& interval) { read_interval(motion, k, interval); }, motion.solution.control,
      end_rows);
  if (space.basis.size() == 0) return by_nodes;
  MatrixXd by_points(end_rows.rows(), controls * space.basis.cols());
  for (Eigen::Index r = 0; r < end_rows.rows(); ++r) {
    const VectorXd row = by_nodes.row(r);
    by_points.row(r) = (row.reshaped(controls, motion.steps + 1) * space.basis).reshaped().transpose();
  }
  return by_points;
}

double kkt_residual(const StoredMotion& motion, const ControlSpace& space, double momentum_scale) {
  const VectorXd gradient = cost_gradient(motion, space);
  const integrator::State end = node_states(motion).back();
  const GoalRows goal = goal_rows(motion.system, motion.problem, end, momentum_scale);
  const MatrixXd jacobian = control_jacobian(motion, space, goal.by_end_state);
  Largest left, whole;
  for (double entry : beyond_rows(gradient, comparable_rows(jacobian, goal.unit))) left.add(std::abs(entry));
  for (double entry : gradient) whole.add(std::abs(entry));
  return left.relative_to(whole.value());
}

}  // namespace lamprey::certificate
