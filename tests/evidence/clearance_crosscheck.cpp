#include "evidence/clearance.hpp"

#include <gtest/gtest.h>

#include "fluid/gap.hpp"
#include "marched_answers.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using evidence::Clearance;

// Every pair at every time, nothing put aside.
Clearance of_all_pairs(const evidence::StoredMotion& motion) {
  const model::System& system = motion.system;
  Clearance least;
  least.gap = INFINITY;
  for (int k = 0; k < motion.steps; ++k) {
    const evidence::StepPath path(motion, k);
    for (int part = 0; part <= 10; ++part) {
      const auto placed = path.at(0.1 * part);
      for (int i = 0; i < system.body_count(); ++i)
        for (int j = i + 1; j < system.body_count(); ++j) {
          const auto a = model::at(i), b = model::at(j);
          const double gap = fluid::gap({system.body(i).semi_axes, system.body(j).semi_axes, placed.rotation[a],
                                         placed.rotation[b], placed.position[b] - placed.position[a]})
                                 .value;
          if (gap < least.gap) least = {gap, motion.solution.time[model::at(k)] + 0.1 * part * motion.time_step, i, j};
        }
    }
  }
  return least;
}

void expect_same(const maneuver::Problem& problem, const maneuver::Solution& solution) {
  const model::System system(problem.swimmer);
  const evidence::StoredMotion motion(system, problem, solution);
  const Clearance all = of_all_pairs(motion);
  const auto found = evidence::clearance(motion);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gap, all.gap, tolerance(1e-13));
  EXPECT_EQ(found->first, all.first);
  EXPECT_EQ(found->second, all.second);
  EXPECT_NEAR(found->time, all.time, tolerance(1e-12));
}

TEST(ClearanceCrosscheck, is_that_of_all_pairs_at_all_times_for_trees_in_motion) {
  for (const unsigned seed : {3U, 4U, 5U, 6U}) {
    SCOPED_TRACE(seed);
    const MarchedAnswer answer = any_tree(seed, integrator::Scheme::trapezoid, 15);
    ASSERT_EQ(answer.solution.status, maneuver::Status::simulated) << answer.solution.message;
    expect_same(answer.problem, answer.solution);
  }
}

// A chain that coils from straight until it overlaps: pairs far down the chain take over from the neighbours.
TEST(ClearanceCrosscheck, is_that_of_all_pairs_at_all_times_for_a_chain_that_coils_up) {
  maneuver::Problem problem;
  model::SwimmerDescription& swimmer = problem.swimmer;
  swimmer.density = 1000.0;
  const int bodies = 12;
  for (int i = 0; i < bodies; ++i) {
    swimmer.bodies.emplace_back();
    swimmer.bodies.back().name = std::to_string(i);
    swimmer.bodies.back().semi_axes = {0.5, 0.1 + 0.01 * i, 0.2};
    if (i == 0) continue;
    model::JointDescription joint;
    joint.name = joint.child = std::to_string(i);
    joint.parent = std::to_string(i - 1);
    joint.parent_offset = {0.55, 0.0, 0.0};
    joint.child_offset = {-0.55, 0.0, 0.0};
    swimmer.joints.push_back(joint);
  }
  problem.start.rotation.assign(bodies, Vector3d::Zero());
  problem.start.angular_velocity.assign(bodies, Vector3d::Zero());
  problem.steps = 12;
  maneuver::Solution solution;
  for (int k = 0; k <= problem.steps; ++k) {
    const double bend = 0.07 * k;
    solution.time.push_back(k / 12.0);
    solution.position.emplace_back(0.1 * k, -0.2 * k, 0.0);
    solution.control.emplace_back(bodies - 1, Vector3d::Zero());
    solution.rotation.push_back({lie::exp({0.1 * k, 0.2, 0.0})});
    for (int i = 1; i < bodies; ++i)
      solution.rotation.back().push_back(solution.rotation.back().back() * lie::exp({0.01, 0.15 * bend, bend}));
  }
  expect_same(problem, solution);
  const model::System system(swimmer);
  const auto nearest = evidence::clearance(evidence::StoredMotion(system, problem, solution));
  EXPECT_LT(nearest->gap, 0.0);
  EXPECT_GT(nearest->second - nearest->first, 3);
}

}  // namespace
}  // namespace lamprey::tests
