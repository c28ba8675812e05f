#include <gtest/gtest.h>

#include "chains.hpp"
#include "integrator/scheme.hpp"
#include "integrator/step.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using integrator::State;

class Conservation : public ::testing::TestWithParam<integrator::Scheme> {};

struct Drift {
  double linear, angular, rotation;
};

// Largest change of total momentum over the march, relative to the largest momentum of a body.
Drift march(const model::System& system, integrator::Scheme scheme, double h, int steps, State state, double torque) {
  integrator::StepWorkspace work(system);
  const auto control = [&](int k) {
    mechanics::Moments u(static_cast<std::size_t>(system.joint_count()));
    for (std::size_t j = 0; j < u.size(); ++j)
      u[j] = torque * Vector3d(0.02 * std::sin(9.0 * k * h), std::cos(7.0 * k * h + double(j)), std::sin(5.0 * k * h));
    return u;
  };
  const auto start = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
  double scale = 0.0;
  Drift drift{0.0, 0.0, 0.0};
  for (int k = 0; k < steps; ++k) {
    const auto report = advance(system, lagrangian_of(scheme), h, control(k), control(k + 1), state, work);
    EXPECT_TRUE(report.converged) << "step " << k << " residual " << report.residual;
    if (!report.converged) break;
    const auto total = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
    drift.linear = std::max(drift.linear, (total.linear - start.linear).lpNorm<Eigen::Infinity>());
    drift.angular = std::max(drift.angular, (total.angular - start.angular).lpNorm<Eigen::Infinity>());
    for (const auto& R : state.rotation)
      drift.rotation = std::max(drift.rotation, (R.transpose() * R - Matrix3d::Identity()).lpNorm<Eigen::Infinity>());
    for (const auto& p : work.momenta.subtree_linear) scale = std::max(scale, p.lpNorm<Eigen::Infinity>());
    scale = std::max(scale, state.momentum.lpNorm<Eigen::Infinity>());
  }
  return {drift.linear / scale, drift.angular / scale, drift.rotation};
}

TEST_P(Conservation, total_momentum_stays_under_control_for_1000_steps) {
  const model::System system(paper_chain());
  Random random(5);
  VectorXd velocity = VectorXd::Zero(12);
  velocity << 0.6, -0.9, 1.2, 2.5, 1, -1.5, -2, 1.5, 1, 0.5, 0.2, -0.1;
  const State start = integrator::state_of_velocity(system, mechanics::Rotations(3, Matrix3d::Identity()),
                                                    Vector3d(0.3, -0.2, 0.1), velocity);
  const Drift drift = march(system, GetParam(), 1e-3, 1000, start, 100.0);
  EXPECT_LE(drift.linear, tolerance(1e-12));
  EXPECT_LE(drift.angular, tolerance(1e-12));
  EXPECT_LE(drift.rotation, tolerance(1e-14));
}

TEST_P(Conservation, total_momentum_stays_on_random_trees) {
  Random random(6);
  for (int bodies : {1, 2, 4, 7}) {
    const model::System system(random_tree(random, bodies));
    VectorXd velocity(system.velocity_count());
    for (double& v : velocity) v = random.normal();
    const mechanics::Rotations rotation = random_rotations(random, system);
    const State start = integrator::state_of_velocity(system, rotation, random.vector(), velocity);
    const Drift drift = march(system, GetParam(), 5e-3, 400, start, 1.0);
    EXPECT_LE(drift.linear, tolerance(1e-12)) << bodies << " bodies";
    EXPECT_LE(drift.angular, tolerance(1e-12)) << bodies << " bodies";
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Conservation,
                         ::testing::Values(integrator::Scheme::paper, integrator::Scheme::trapezoid));

}  // namespace
}  // namespace lamprey::tests
