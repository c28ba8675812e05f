#include <gtest/gtest.h>

#include "integrator/golden_trajectories.hpp"
#include "integrator/scheme.hpp"
#include "integrator/step.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using integrator::Scheme;

// ‖R − R_ref‖ over all bodies after marching to the golden state's time.
double error_at_end(const model::System& system, Scheme scheme, const GoldenTrajectory& golden, int steps) {
  const GoldenState& end = golden.states.back();
  const double h = end.time / steps;
  const auto& start = golden.start.state;
  integrator::State state = integrator::state_of_velocity(system, start.rotation, start.position, start.velocity);
  integrator::StepWorkspace work(system);
  for (int k = 0; k < steps; ++k) {
    const auto report =
        advance(system, lagrangian_of(scheme), h, golden.control(k * h), golden.control((k + 1) * h), state, work);
    EXPECT_TRUE(report.converged) << "step " << k;
  }
  double squares = 0.0;
  for (std::size_t i = 0; i < 3; ++i) squares += (state.rotation[i] - end.state.rotation[i]).squaredNorm();
  return std::sqrt(squares);
}

// Order from the last halving of the step; every halving must already lessen the error.
double observed_order(Scheme scheme, const GoldenTrajectory& golden) {
  const model::System system(paper_chain());
  double error = INFINITY, order = 0.0;
  for (int steps : {100, 200, 400, 800, 1600}) {
    const double finer = error_at_end(system, scheme, golden, steps);
    EXPECT_LT(finer, error) << golden.name << ", " << steps << " steps";
    order = std::log2(error / finer);
    ::testing::Test::RecordProperty(golden.name + "_" + std::to_string(steps), std::to_string(finer));
    error = finer;
  }
  return order;
}

TEST(Order, is_1_for_the_paper_scheme) {
  const auto trajectories = golden_trajectories();
  ASSERT_EQ(trajectories.size(), 3u);
  for (const auto& golden : trajectories)
    EXPECT_NEAR(observed_order(Scheme::paper, golden), 1.0, tolerance(0.1)) << golden.name;
}

TEST(Order, is_2_for_the_trapezoid_scheme) {
  const auto trajectories = golden_trajectories();
  ASSERT_EQ(trajectories.size(), 3u);
  for (const auto& golden : trajectories)
    EXPECT_NEAR(observed_order(Scheme::trapezoid, golden), 2.0, tolerance(0.05)) << golden.name;
}

}  // namespace
}  // namespace lamprey::tests
