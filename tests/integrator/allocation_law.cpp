// Counts the heap: operator new, Eigen and the standard library all end in malloc, which this executable takes over.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>

#include "chains.hpp"
#include "integrator/scheme.hpp"
#include "integrator/step.hpp"

namespace {

std::atomic<long> allocations{0};

}  // namespace

#ifdef __SANITIZE_ADDRESS__  // the sanitizer owns malloc and tells of each call
extern "C" void __sanitizer_malloc_hook(const volatile void*, std::size_t) { ++allocations; }
#else
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

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

INSTANTIATE_TEST_SUITE_P(Schemes, Allocation, ::testing::Values(Scheme::paper, Scheme::trapezoid, Scheme::midpoint));

}  // namespace
}  // namespace lamprey::tests
