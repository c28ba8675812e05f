// No step of an integrator asks for memory.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "counted_allocations.hpp"
#include "integrator/scheme.hpp"
#include "integrator/step.hpp"
#include "mechanics/equations_of_motion.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using integrator::Scheme;

class Allocation : public ::testing::TestWithParam<Scheme> {};

TEST(AllocationCounter, sees_vectors_and_matrices) {
  const long before = allocations;
  std::vector<double> numbers(100);
  volatile const double* kept = numbers.data();
  EXPECT_GT(allocations, before) << kept;
  const long between = allocations;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(7, 7);
  kept = matrix.data();
  EXPECT_GT(allocations, between) << kept;
}

// The first step of a march too, where nothing is known to predict from, and steps from rest.
TEST_P(Allocation, none_happens_inside_a_step) {
  Random random(23);
  for (int bodies : {1, 2, 6, 20}) {
    const model::System system(random_tree(random, bodies));
    Eigen::VectorXd velocity(system.velocity_count());
    for (double& v : velocity) v = random.normal();
    mechanics::Rotations rotation;
    for (int i = 0; i < bodies; ++i) rotation.push_back(random.rotation());
    integrator::State state = integrator::state_of_velocity(system, rotation, random.vector(), velocity);
    mechanics::Moments now, next;
    for (int j = 0; j < system.joint_count(); ++j) now.push_back(random.vector()), next.push_back(random.vector());
    integrator::StepWorkspace work(system);
    const auto lagrangian = lagrangian_of(GetParam());
    int iterations = 0;
    for (int k = 0; k < 20; ++k) {
      const long before = allocations;
      const integrator::StepReport report = advance(system, lagrangian, 1e-2, now, next, state, work);
      EXPECT_EQ(allocations - before, 0) << bodies << " bodies, step " << k;
      EXPECT_TRUE(report.converged);
      iterations += report.iterations;
      now.swap(next);
    }
    EXPECT_GT(iterations, 20) << "Newton had nothing to do";
  }
}

// 𝕀 ξ̇ + bias = U + damping, each evaluation knowing nothing of the one before.
TEST(EquationsOfMotion, balance_inertia_and_forces_time_after_time_and_ask_for_no_memory) {
  Random random(29);
  for (int bodies : {1, 2, 6, 20}) {
    const model::System system(random_swimmer(random, bodies));
    mechanics::EquationsOfMotion equations(system);
    for (int time = 0; time < 3; ++time) {
      Eigen::VectorXd velocity(system.velocity_count());
      for (double& v : velocity) v = random.normal();
      const mechanics::Rotations rotation = random_rotations(random, system);
      const mechanics::Moments control = random_moments(random, system, 1.0);
      const long before = allocations;
      equations.evaluate(rotation, velocity, control);
      EXPECT_EQ(allocations - before, 0) << bodies << " bodies";
      const Eigen::VectorXd bias = mechanics::bias(system, rotation, velocity);
      const Eigen::VectorXd force = mechanics::generalized_force(system, rotation, control) +
                                    mechanics::damping_force(system, rotation, velocity);
      const Eigen::VectorXd left =
          mechanics::generalized_inertia(system, rotation) * equations.acceleration() + bias - force;
      EXPECT_LE(left.norm(), tolerance(1e-10) * (bias.norm() + force.norm())) << bodies << " bodies";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Allocation, ::testing::Values(Scheme::paper, Scheme::trapezoid, Scheme::midpoint),
                         named_by_value);

}  // namespace
}  // namespace lamprey::tests
