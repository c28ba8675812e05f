#include <gtest/gtest.h>

#include "integrator/golden_trajectories.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

double largest_difference(const integrator::ReferenceState& a, const integrator::ReferenceState& b) {
  double largest = std::max((a.position - b.position).lpNorm<Eigen::Infinity>(),
                            (a.velocity - b.velocity).lpNorm<Eigen::Infinity>());
  for (std::size_t i = 0; i < a.rotation.size(); ++i)
    largest = std::max(largest, (a.rotation[i] - b.rotation[i]).lpNorm<Eigen::Infinity>());
  return largest;
}

TEST(ReferenceIntegrator, reproduces_trajectories_of_another_program) {
  const model::System system(paper_chain());
  const auto trajectories = golden_trajectories();
  ASSERT_EQ(trajectories.size(), 3u);
  for (const GoldenTrajectory& golden : trajectories) {
    integrator::ReferenceState state = golden.start.state;
    integrator::ReferenceIntegrator reference(system, golden.control, 1e-13);
    double time = golden.start.time;
    for (const GoldenState& expected : golden.states) {
      ASSERT_TRUE(reference.advance(time, expected.time, state)) << golden.name;
      time = expected.time;
      EXPECT_LE(largest_difference(state, expected.state), tolerance(1e-9)) << golden.name << " at " << time << " s";
    }
    EXPECT_GT(largest_difference(state, golden.start.state), 0.1) << golden.name << " must have moved";
  }
}

TEST(ReferenceIntegrator, a_finer_tolerance_comes_nearer) {
  const model::System system(paper_chain());
  const GoldenTrajectory golden = golden_trajectories()[1];
  double previous = 1.0;
  for (double accuracy : {1e-5, 1e-7, 1e-9, 1e-11}) {
    integrator::ReferenceState state = golden.start.state;
    integrator::ReferenceIntegrator reference(system, golden.control, accuracy);
    ASSERT_TRUE(reference.advance(0.0, golden.states.back().time, state));
    const double error = largest_difference(state, golden.states.back().state);
    EXPECT_LT(error, 0.3 * previous) << accuracy;
    previous = error;
  }
}

TEST(ReferenceIntegrator, reports_moments_that_are_not_finite_and_keeps_the_state) {
  const model::System system(paper_chain());
  const GoldenTrajectory golden = golden_trajectories()[0];
  integrator::ReferenceState state = golden.start.state;
  integrator::ReferenceIntegrator reference(
      system, [](double t) { return mechanics::Moments(2, Vector3d::Constant(t > 0.05 ? NAN : 1.0)); }, 1e-12);
  EXPECT_FALSE(reference.advance(0.0, 0.1, state));
  EXPECT_EQ(largest_difference(state, golden.start.state), 0.0);
}

}  // namespace
}  // namespace lamprey::tests
