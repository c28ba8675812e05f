#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "mechanics/continuous.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;

TEST(MomentumRate, matches_central_differences_at_second_order) {
  Random random(61);
  for (int bodies : {1, 2, 3, 5, 8}) {
    const model::System system(random_swimmer(random, bodies));
    const mechanics::Rotations R = random_rotations(random, system);
    VectorXd velocity(system.velocity_count());
    for (double& entry : velocity) entry = random.normal();
    const mechanics::Freedoms turn = random_freedoms(random, system, 1.0);
    expect_second_order_differences(
        [&](double t) {
          mechanics::Freedoms part = turn;
          for (Vector3d& entry : part) entry *= t;
          return mechanics::generalized_momentum(system, turned(system, R, part), velocity);
        },
        mechanics::generalized_momentum_rate(system, R, velocity, turn), 1e-9);
  }
}

}  // namespace
}  // namespace lamprey::tests
