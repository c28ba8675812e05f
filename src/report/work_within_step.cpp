#include "report/work_within_step.hpp"

#include "algebra/row_space.hpp"
#include "maneuver/step_polynomial.hpp"
#include "report/joint_rates.hpp"
#include "shape/node_work.hpp"

namespace lamprey::report {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int parts = 16;  // of a step, in each of which the power is linear

// Of each component of a joint's moment, [terms][3] N m.
MatrixXd polynomial_of_moment(const result::Results& results, std::size_t k, std::size_t joint) {
  const int terms = maneuver::polynomial_terms(results.problem.scheme);
  const std::vector<double> fractions = maneuver::stage_fractions(results.problem.scheme);
  const auto nodes = static_cast<Eigen::Index>(fractions.size());
  MatrixXd basis(nodes, terms), samples(nodes, 3);
  for (Eigen::Index s = 0; s < nodes; ++s) {
    const auto stage = static_cast<std::size_t>(s);
    basis.row(s) = maneuver::legendre(fractions[stage], terms).transpose();
    samples.row(s) = results.solution.control_stages[k][stage][joint].transpose();
  }
  return algebra::least_squares(basis, samples);
}

// rad/s, on the average over step k: rates that do not keep their direction turn by more than their integral, in a product of rotations
// (Magnus' second term).
Vector3d mean_rate(const result::Results& results, std::size_t k, const Vector3d& first, const Vector3d& last,
                   const result::ResolvedJoint& joint) {
  return step_rate(results, k, joint) - results.problem.time_step / 12.0 * last.cross(first);
}

}  // namespace

bool tells_stages(const result::Results& results) {
  if (integrator::single_step(results.problem.scheme)) return false;
  const std::size_t steps = results.solution.time.size() - 1;
  if (results.solution.control_stages.size() != steps) return false;
  const std::size_t nodes = maneuver::stage_fractions(results.problem.scheme).size();
  for (const auto& step : results.solution.control_stages)
    if (step.size() != nodes) return false;
  return true;
}

double work_within_step(const result::Results& results, std::size_t k, std::size_t joint, std::optional<int> axis) {
  const result::ResolvedJoint& turned = results.problem.joints[joint];
  const MatrixXd moment = polynomial_of_moment(results, k, joint);
  const Vector3d first = joint_rate(results, k, turned), last = joint_rate(results, k + 1, turned);
  const Vector3d mean = mean_rate(results, k, first, last, turned);
  const Matrix3d axes = axes_at(results, k, turned), next_axes = axes_at(results, k + 1, turned);
  const auto power = [&](double s) {
    const Vector3d u = moment.transpose() * maneuver::legendre(s, static_cast<int>(moment.rows()));
    const Vector3d rate = first + s * (6.0 * mean - 4.0 * first - 2.0 * last + s * 3.0 * (first + last - 2.0 * mean));
    if (!axis) return u.dot(rate);
    const Vector3d along = ((1.0 - s) * axes.col(*axis) + s * next_axes.col(*axis)).normalized();
    return along.dot(u) * along.dot(rate);
  };
  double sum = 0.0, before = power(0.0);
  for (int part = 1; part <= parts; ++part) {
    const double after = power(static_cast<double>(part) / parts);
    sum += shape::mean_work({0.5 * (before + after), 0.5 * (after - before)});
    before = after;
  }
  return sum / parts * results.problem.time_step;
}

}  // namespace lamprey::report
