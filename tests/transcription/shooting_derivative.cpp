#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "printed.hpp"
#include "transcription/shooting.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

maneuver::Maneuver spline_maneuver(const model::System& system, mechanics::DiscreteLagrangian lagrangian) {
  maneuver::Maneuver maneuver;
  mechanics::Rotations rotation(3, Matrix3d::Identity());
  rotation[2] = lie::exp(Vector3d(0, 0, 0.785));
  maneuver.start = integrator::state_of_velocity(system, rotation, Vector3d::Zero(), VectorXd::Zero(12));
  for (int i = 0; i < 3; ++i)
    maneuver.end_rotation.push_back(lie::exp(Vector3d(0.3, 0.2, -0.1)) * rotation[std::size_t(i)]);
  maneuver.end_position = {2.0, std::nullopt, std::nullopt};
  maneuver.lagrangian = lagrangian;
  maneuver.duration = 0.2;
  maneuver.steps = 20;
  maneuver.spline_points = 5;
  maneuver.node_weight = maneuver::node_weights(maneuver::CostRule::rectangle, 1.0, 0.01, 20);
  return maneuver;
}

// The same end of its joints, at any attitude.
void ask_for_joints(const model::System& system, maneuver::Maneuver& maneuver) {
  for (const model::Joint& joint : system.joints())
    maneuver.end_joint.emplace_back(lie::exp(Vector3d(0.2, -0.1, 0.3)) *
                                    mechanics::child_to_parent(maneuver.start.rotation, joint));
  maneuver.end_rotation.assign(maneuver.end_rotation.size(), std::nullopt);
}

class ShootingDerivatives : public ::testing::TestWithParam<mechanics::DiscreteLagrangian> {};

TEST_P(ShootingDerivatives, adjoint_gradients_match_central_differences_at_second_order) {
  const model::System system(paper_chain());
  for (const bool joints : {false, true}) {
    maneuver::Maneuver maneuver = spline_maneuver(system, GetParam());
    if (joints) ask_for_joints(system, maneuver);
    transcription::Shooting program(system, maneuver, transcription::stated_goal_rows(system, maneuver));
    Random random(4);
    VectorXd x(program.variable_count()), direction(program.variable_count());
    const double size = std::pow(maneuver.duration, 2);  // of moments, in the program's units for so short a time
    for (double& v : x) v = 0.2 * size * random.normal();
    for (double& v : direction) v = size * random.normal();
    VectorXd values, gradient(x.size());
    program.jacobian(x, values);
    program.gradient(x, gradient);
    const Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> jacobian(
        values.data(), program.constraint_count(), program.variable_count());
    VectorXd expected(program.constraint_count() + 1);
    expected << jacobian * direction, gradient.dot(direction);
    const auto along = [&](double t) {
      VectorXd all(program.constraint_count() + 1), c(program.constraint_count());
      program.constraints(x + t * direction, c);
      all << c, program.objective(x + t * direction);
      return all;
    };
    expect_second_order_differences(along, expected, 1e-9, 0.002);
  }
}

INSTANTIATE_TEST_SUITE_P(Lagrangians, ShootingDerivatives,
                         ::testing::Values(mechanics::DiscreteLagrangian::paper,
                                           mechanics::DiscreteLagrangian::trapezoid),
                         named_by_value);

}  // namespace
}  // namespace lamprey::tests
