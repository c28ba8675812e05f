#include <gtest/gtest.h>

#include "integrator/free_motion.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

class Conservation : public ::testing::TestWithParam<integrator::Scheme> {};

TEST_P(Conservation, total_momentum_stays_under_control_for_1000_steps) {
  Random random(5);
  const Moving chain = tumbling_chain();
  const Drift drift = drift_of_march(chain, GetParam(), 1e-3, 1000, Waves(random, chain.system, 100.0));
  EXPECT_LE(drift.linear, tolerance(1e-12));
  EXPECT_LE(drift.angular, tolerance(1e-12));
  EXPECT_LE(drift.rotation, tolerance(1e-14));
  EXPECT_GT(drift.angular, 0.0) << "nothing moved";
}

TEST_P(Conservation, total_momentum_stays_on_random_trees) {
  Random random(6);
  for (int bodies : {1, 2, 4, 7}) {
    const Moving swimmer = moving(random, random_tree(random, bodies));
    const Drift drift = drift_of_march(swimmer, GetParam(), 5e-3, 400, Waves(random, swimmer.system, 1.0));
    EXPECT_LE(drift.linear, tolerance(1e-12)) << bodies << " bodies";
    EXPECT_LE(drift.angular, tolerance(1e-12)) << bodies << " bodies";
  }
}

TEST_P(Conservation, total_momentum_stays_with_every_joint_spring_damper_and_coupled_inertia) {
  Random random(7);
  for (int bodies : {2, 3, 5, 8, 12, 20}) {
    const Moving swimmer = moving(random, random_swimmer(random, bodies));
    const Drift drift = drift_of_march(swimmer, GetParam(), 5e-3, 200, Waves(random, swimmer.system, 1.0));
    EXPECT_LE(drift.linear, tolerance(1e-12)) << bodies << " bodies";
    EXPECT_LE(drift.angular, tolerance(1e-12)) << bodies << " bodies";
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Conservation, ::testing::ValuesIn(all_schemes), named_by_value);

}  // namespace
}  // namespace lamprey::tests
