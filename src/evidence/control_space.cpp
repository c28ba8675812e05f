#include "evidence/control_space.hpp"

#include "algebra/row_space.hpp"
#include "maneuver/control_path.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::evidence {

namespace {

using model::at;

// Largest difference of the stored moments from given ones along the axes, relative to the largest moment.
double difference(const StoredMotion& motion, const MatrixXd& moments) {
  Largest outside, largest;
  for (int k = 0; k <= motion.steps; ++k) {
    // led joints exert what is along their axes, no more
    const mechanics::Vectors exerted =
        mechanics::applied_moments(motion.system, motion.solution.rotation[at(k)], motion.control[at(k)]);
    const mechanics::Moments along = mechanics::joint_moments(motion.system, moments.row(k).transpose());
    for (std::size_t j = 0; j < along.size(); ++j) {
      const Vector3d& u = motion.control[at(k)][j];
      outside.add((motion.solution.control[at(k)][j] - exerted[j]).norm());
      outside.add((u - along[j]).norm());
      largest.add(u.norm());
    }
  }
  return outside.relative_to(largest.value());
}

}  // namespace

model::Axes axes_of(const model::System& system, const model::Drive& drive) {
  const model::Joint& joint = system.joint(drive.joint);
  return joint.actuation.middleCols(drive.first_control - joint.first_control, drive.controls);
}

Vector3d moment_of(const StoredMotion& motion, const model::Drive& drive, int node) {
  const model::Axes axes = axes_of(motion.system, drive);
  return axes * (axes.transpose() * motion.control[at(node)][at(drive.joint)]);
}

VectorXd moments_at(const StoredMotion& motion, int node) {
  return mechanics::along_actuation(motion.system, motion.control[at(node)]);
}

MatrixXd actuated_moments(const StoredMotion& motion) {
  MatrixXd moments(motion.steps + 1, motion.system.control_count());
  for (int k = 0; k <= motion.steps; ++k)
    moments.row(k) = mechanics::along_actuation(motion.system, motion.control[at(k)]).transpose();
  return moments;
}

double beyond_actuation(const StoredMotion& motion) { return difference(motion, actuated_moments(motion)); }

ControlSpace control_space(const StoredMotion& motion) {
  const MatrixXd moments = actuated_moments(motion);
  if (motion.problem.control == maneuver::ControlKind::steps)
    return {moments.transpose().reshaped(), MatrixXd(), difference(motion, moments)};
  const double duration = motion.steps * motion.time_step;
  const MatrixXd basis = maneuver::natural_spline_basis(motion.problem.points, duration,
                                                        VectorXd::LinSpaced(motion.steps + 1, 0.0, duration));
  const MatrixXd points = algebra::least_squares(basis, moments);
  return {points.transpose().reshaped(), basis, difference(motion, basis * points)};
}

}  // namespace lamprey::evidence
