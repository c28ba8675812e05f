// Change of energy against the work of controls and dampers: what the scheme makes of the energy balance.
#include <gtest/gtest.h>

#include "integrator/marching.hpp"
#include "mechanics/equations_of_motion.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using integrator::State;

// Power of controls and dampers, W, at a state.
double power(const model::System& system, const State& state, const mechanics::Moments& control) {
  const mechanics::Moments none(control.size(), Vector3d::Zero());
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  const VectorXd force = mechanics::generalized_force(system, state.rotation, control) -
                         mechanics::generalized_force(system, state.rotation, none) +
                         mechanics::damping_force(system, state.rotation, velocity);
  return force.dot(velocity);
}

// Largest |E − E_0 − W| at the ends of steps; W by the trapezoid rule over each stage, composed as the scheme is.
double imbalance(const Moving& swimmer, integrator::Scheme scheme, double duration, int steps,
                 const TimedControl& control) {
  const model::System& system = swimmer.system;
  const double h = duration / steps;
  integrator::March march(system, scheme);
  const auto& fractions = integrator::composition(scheme).fractions;
  State state = swimmer.start;
  const auto energy = [&] {
    return mechanics::energy(system, state.rotation, integrator::velocity_of_state(system, state));
  };
  const double first = energy();
  double work = 0.0, largest = 0.0;
  for (int step = 0; step < steps; ++step) {
    std::vector<mechanics::Moments> moments;
    for (double node : march.nodes()) moments.push_back(control(h * (step + node)));
    double before = power(system, state, moments[0]);
    std::size_t stage = 0;
    const auto report = march.advance(
        h, [&](int node) -> const mechanics::Moments& { return moments[model::at(node)]; }, state,
        [&](const mechanics::Interval&, const State& after) {
          const double now = power(system, after, moments[stage + 1]);
          work += 0.5 * h * fractions[stage] * (before + now);
          before = now;
          ++stage;
        });
    EXPECT_TRUE(report.converged);
    largest = std::max(largest, std::abs(energy() - first - work));
  }
  EXPECT_GT(std::abs(work), 0.1) << "the joints hardly worked";
  return largest;
}

class EnergyBalance : public ::testing::TestWithParam<integrator::Scheme> {};

TEST_P(EnergyBalance, of_the_controlled_chain_is_off_by_the_schemes_order) {
  Random random(11);
  const Moving chain = tumbling_chain();
  const Waves control(random, chain.system, 30.0);
  const int steps = order(GetParam()) == 6 ? 100 : order(GetParam()) == 4 ? 200 : 800;
  const double coarse = imbalance(chain, GetParam(), 1.0, steps, control);
  const double fine = imbalance(chain, GetParam(), 1.0, 2 * steps, control);
  EXPECT_NEAR(std::log2(coarse / fine), order(GetParam()), tolerance(order(GetParam()) == 6 ? 0.3 : 0.1))
      << coarse << " J, " << fine << " J";
}

TEST_P(EnergyBalance, of_swimmers_with_every_joint_springs_and_dampers_is_off_by_the_schemes_order) {
  for (unsigned seed : {301u, 302u, 306u, 308u}) {
    Random random(seed);
    const Moving swimmer = moving(random, random_swimmer(random, 5));
    const Waves control(random, swimmer.system, 1.0);
    const bool composed = order(GetParam()) > 2;
    double error = INFINITY, observed = 0.0;
    for (int steps = composed ? 7 : 200; steps <= (composed ? 112 : 800); steps *= 2) {
      const double finer = imbalance(swimmer, GetParam(), 0.5, steps, control);
      if (finer < 1e-10) break;  // J: from here on round-off has a say
      observed = std::log2(error / finer);
      error = finer;
    }
    EXPECT_NEAR(observed, order(GetParam()), tolerance(order(GetParam()) == 6 ? 0.3 : 0.1))
        << "seed " << seed << ", " << error << " J";
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, EnergyBalance, ::testing::ValuesIn(all_schemes), named_by_value);

}  // namespace
}  // namespace lamprey::tests
