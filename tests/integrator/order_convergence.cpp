#include <gtest/gtest.h>

#include "integrator/golden_trajectories.hpp"
#include "integrator/marching.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using integrator::Scheme;

// ‖R − R_ref‖ over all bodies after marching to the golden state's time.
double error_at_end(const model::System& system, Scheme scheme, const GoldenTrajectory& golden, int steps) {
  const GoldenState& end = golden.states.back();
  const auto& from = golden.start.state;
  const auto start = integrator::state_of_velocity(system, from.rotation, from.position, from.velocity);
  return rotation_distance(marched(system, scheme, end.time / steps, steps, start, golden.control).rotation,
                           end.state.rotation);
}

struct StepRange {
  Scheme scheme;
  std::vector<int> steps;  // over 1 s, halvings
  double allowed;          // deviation from the scheme's order
};

const std::vector<StepRange> ranges = {{Scheme::paper, {100, 200, 400, 800, 1600}, 0.1},
                                       {Scheme::trapezoid, {100, 200, 400, 800, 1600}, 0.1},
                                       {Scheme::midpoint, {100, 200, 400, 800, 1600}, 0.1},
                                       {Scheme::order4, {100, 200, 400, 800, 1600}, 0.1},
                                       {Scheme::order6, {40, 80, 160, 320}, 0.3}};

class Order : public ::testing::TestWithParam<StepRange> {};

// Read from the last halving whose error is far above that of the golden states.
TEST_P(Order, shows_against_trajectories_of_another_program_free_controlled_and_planar) {
  const StepRange range = GetParam();
  const model::System system(paper_chain());
  const auto trajectories = golden_trajectories();
  ASSERT_EQ(trajectories.size(), 3u);
  for (const auto& golden : trajectories) {
    double error = INFINITY, observed = 0.0;
    for (int steps : range.steps) {
      const double finer = error_at_end(system, range.scheme, golden, steps);
      if (finer < 20.0 * golden.estimated_error) break;
      EXPECT_LT(finer, error) << golden.name << ", " << steps << " steps";
      observed = std::log2(error / finer);
      error = finer;
    }
    ASSERT_TRUE(std::isfinite(observed)) << golden.name << ": two errors are needed";
    EXPECT_NEAR(observed, order(range.scheme), tolerance(range.allowed)) << golden.name << ", error " << error;
  }
}

// What order6 leaves at 0.000625 s is round-off, so it serves as the reference below the golden states' own error.
TEST(OrderSix, shows_from_a_step_of_10_ms_until_round_off) {
  const model::System system(paper_chain());
  for (const auto& golden : golden_trajectories()) {
    const auto& from = golden.start.state;
    const auto start = integrator::state_of_velocity(system, from.rotation, from.position, from.velocity);
    const auto at_end = [&](int steps) {
      return marched(system, Scheme::order6, 1.0 / steps, steps, start, golden.control).rotation;
    };
    const auto reference = at_end(1600);
    EXPECT_LE(rotation_distance(reference, golden.states.back().state.rotation), tolerance(1e-10)) << golden.name;
    const double coarse = rotation_distance(at_end(100), reference);
    const double fine = rotation_distance(at_end(200), reference);
    EXPECT_NEAR(std::log2(coarse / fine), 6.0, tolerance(0.3)) << golden.name << ", " << coarse << ", " << fine;
    EXPECT_LE(rotation_distance(at_end(800), reference), tolerance(1e-10)) << golden.name;
  }
}

// Springs, dampers, coupled inertia, every kind of joint, under control, against Runge–Kutta on the continuous equations.
TEST_P(Order, shows_on_swimmers_with_every_joint_against_runge_kutta) {
  const StepRange range = GetParam();
  constexpr double duration = 0.5;
  for (unsigned seed : {201u, 202u, 203u, 204u}) {
    Random random(seed);
    const Moving swimmer = moving(random, random_swimmer(random, 3 + static_cast<int>(seed % 4)));
    const Waves control(random, swimmer.system, 1.0);
    integrator::ReferenceState reference{swimmer.start.rotation, swimmer.start.position,
                                         integrator::velocity_of_state(swimmer.system, swimmer.start)};
    ASSERT_TRUE(integrator::ReferenceIntegrator(swimmer.system, control, 1e-14).advance(0.0, duration, reference));
    const bool composed = order(range.scheme) > 2;
    double error = INFINITY, observed = 0.0;
    for (int steps = composed ? 7 : 200; steps <= (composed ? 112 : 800); steps *= 2) {
      const auto end = marched(swimmer.system, range.scheme, duration / steps, steps, swimmer.start, control);
      const double finer = rotation_distance(end.rotation, reference.rotation);
      if (finer < 1e-11) break;  // from here on round-off has a say
      observed = std::log2(error / finer);
      error = finer;
      EXPECT_LE((end.position - reference.position).norm(), 10.0 * finer);
    }
    EXPECT_NEAR(observed, order(range.scheme), tolerance(range.allowed)) << "seed " << seed << ", error " << error;
    EXPECT_GT(rotation_distance(swimmer.start.rotation, reference.rotation), 0.1) << "nothing moved";
  }
}

std::string name_of_range(const ::testing::TestParamInfo<StepRange>& range) { return scheme_name(range.param.scheme); }

INSTANTIATE_TEST_SUITE_P(Schemes, Order, ::testing::ValuesIn(ranges), name_of_range);

}  // namespace
}  // namespace lamprey::tests
