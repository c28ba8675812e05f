// A stored motion as the first guess of a search.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "lie/so3.hpp"
#include "marched_answers.hpp"
#include "mechanics/tree_motion.hpp"
#include "search/method.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

// Half a turn of the paper's chain, whose random first guesses end at many different minima.
maneuver::Problem turning(double angle) {
  maneuver::Problem problem = chain_problem(50, 1.0);
  problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  problem.goal->turn = Vector3d(angle, 0, 0);
  problem.search.starts = 1;
  return problem;
}

study::Answer answered(const maneuver::Problem& problem, const std::optional<search::FirstMotion>& first,
                       search::Backend solver = search::Backend::newton) {
  search::SolveOptions options;
  options.solver = solver;
  options.first = first;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

const study::Answer& turned() {
  static const study::Answer answer = answered(turning(2.0), std::nullopt);
  return answer;
}

search::FirstMotion first(const maneuver::Problem& problem) {
  return search::first_motion(model::System(problem.swimmer), problem, turned().solution);
}

TEST(FirstMotion, of_an_answer_stays_there) {
  ASSERT_EQ(turned().certificate.verdict, certificate::Verdict::proved);
  const maneuver::Problem problem = turning(2.0);
  for (search::Backend solver : {search::Backend::newton, search::Backend::ipopt}) {
    const study::Answer again = answered(problem, first(problem), solver);
    EXPECT_NEAR(again.solution.cost, turned().solution.cost, tolerance(1e-8) * turned().solution.cost);
    EXPECT_LE(again.solution.solver.iterations, 10);
  }
}

TEST(FirstMotion, tells_what_joints_of_another_kind_leave_out) {
  const search::FirstMotion same = first(turning(2.0));
  EXPECT_LE(same.left_out, 1e-12);
  maneuver::Problem hinged = turning(2.0);
  hinged.swimmer.joints[1].kind = model::JointKind::hinge;
  hinged.swimmer.joints[1].axis = {0.0, 0.0, 1.0};
  const search::FirstMotion other = first(hinged);
  EXPECT_EQ(other.left_out_by, 1);
  const auto& stored = turned().solution.rotation;
  double most = 0.0;  // of the swing out of the hinge's plane, which is no more than what the joint turns
  for (const auto& R : stored) most = std::max(most, lie::rotation_angle(R[0].transpose() * R[2]));
  EXPECT_GT(other.left_out, 0.1 * most);
  EXPECT_LE(other.left_out, most);
}

// Without what its limits are worth, a search would begin far within them and end elsewhere.
TEST(FirstMotion, of_an_answer_within_limits_stays_there) {
  maneuver::Problem problem = turning(1.0);
  problem.limits.swing = {{"front", 0.7}, {"back", 0.9}};
  problem.limits.angular_velocity = 12.0;
  const study::Answer within = answered(problem, std::nullopt);
  ASSERT_EQ(within.certificate.verdict, certificate::Verdict::proved) << within.solution.message;
  ASSERT_FALSE(within.solution.limit_multipliers.empty());
  const model::System system(problem.swimmer);
  const study::Answer again = answered(problem, search::first_motion(system, problem, within.solution));
  EXPECT_NEAR(again.solution.cost, within.solution.cost, tolerance(1e-7) * within.solution.cost);
  EXPECT_LT(again.solution.solver.iterations, within.solution.solver.iterations);
}

// On coarser steps, or with lighter weights at the kinks, a search would begin beside it and end elsewhere.
TEST(FirstMotion, of_an_answer_for_work_stays_there) {
  maneuver::Problem problem = turning(2.0);
  problem.steps = 100;
  problem.cost_weights.work = 100.0;
  const study::Answer for_work = answered(problem, std::nullopt);
  ASSERT_EQ(for_work.certificate.verdict, certificate::Verdict::proved) << for_work.solution.message;
  const model::System system(problem.swimmer);
  const study::Answer again = answered(problem, search::first_motion(system, problem, for_work.solution));
  EXPECT_NEAR(again.solution.cost, for_work.solution.cost, tolerance(1e-7) * for_work.solution.cost);
  EXPECT_LE(again.solution.solver.iterations, 20);
}

// What a search falls back on that does not arrive.
TEST(FirstMotion, is_held_as_it_is_where_it_has_all_steps) {
  maneuver::Problem problem = turning(2.0);
  problem.cost_weights.work = 100.0;
  search::SolveOptions options;
  options.first = first(problem);
  const model::System system(problem.swimmer);
  const maneuver::Solution& stored = turned().solution;
  const auto held = [&] {
    const search::Budget budget(problem, options);
    return search::newton_method(system, problem, options, budget)->as_begun();
  };
  const std::optional<search::Found> begun = held();
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun->outcome.termination, optimizer::Termination::feasible);
  ASSERT_TRUE(begun->cost_parts);
  EXPECT_NEAR(begun->cost_parts->effort, stored.cost, tolerance(1e-9) * stored.cost);
  ASSERT_EQ(begun->path.rotation.size(), stored.rotation.size());
  for (std::size_t k = 0; k < stored.rotation.size(); ++k)
    for (std::size_t i = 0; i < stored.rotation[k].size(); ++i)
      EXPECT_LE((begun->path.rotation[k][i] - stored.rotation[k][i]).norm(), tolerance(1e-10));
  problem.steps *= 2;
  EXPECT_FALSE(held());
  problem.steps /= 2;
  options.first.reset();
  EXPECT_FALSE(held());
}

TEST(FirstMotion, follows_a_minimum_as_the_goal_moves) {
  maneuver::Solution last = turned().solution;
  for (double angle : {2.05, 2.1, 2.15}) {
    const maneuver::Problem problem = turning(angle);
    const model::System system(problem.swimmer);
    const study::Answer next = answered(problem, search::first_motion(system, problem, last));
    EXPECT_EQ(next.certificate.verdict, certificate::Verdict::proved) << next.solution.message;
    EXPECT_GT(next.solution.cost, last.cost);
    EXPECT_LT(next.solution.cost, 1.1 * last.cost);
    last = next.solution;
  }
}

TEST(FirstMotion, serves_other_steps_and_schemes) {
  maneuver::Problem problem = turning(2.0);
  problem.steps = 90;
  EXPECT_NEAR(answered(problem, first(problem)).solution.cost, turned().solution.cost, 0.05 * turned().solution.cost);
  problem.scheme = maneuver::Scheme::order4;
  problem.steps = 20;
  EXPECT_NEAR(answered(problem, first(problem)).solution.cost, turned().solution.cost, 0.05 * turned().solution.cost);
}

TEST(FirstMotion, begins_as_the_problem_does) {
  maneuver::Problem problem = turning(2.0);
  const Matrix3d heading = lie::exp(Vector3d(0.3, -0.4, 0.5));
  for (Vector3d& rotation : problem.start.rotation) rotation = lie::log(heading * lie::exp(rotation));
  problem.start.position = {1.0, 2.0, 3.0};
  const maneuver::Solution& stored = turned().solution;
  const search::FirstMotion moved = first(problem);
  ASSERT_EQ(moved.path.rotation.size(), stored.rotation.size());
  for (std::size_t k = 0; k < stored.rotation.size(); ++k) {
    for (std::size_t i = 0; i < stored.rotation[k].size(); ++i)
      EXPECT_LE((moved.path.rotation[k][i] - heading * stored.rotation[k][i]).norm(), tolerance(1e-12));
    EXPECT_LE(
        (moved.path.position[k] - problem.start.position - heading * (stored.position[k] - stored.position[0])).norm(),
        tolerance(1e-12));
  }
  problem.start.rotation[1] = lie::log(heading * lie::exp(Vector3d(0.0, 0.0, 0.4)));  // another first shape
  const search::FirstMotion bent = first(problem);
  EXPECT_LE((bent.path.rotation.front()[1] - lie::exp(problem.start.rotation[1])).norm(), tolerance(1e-12));
  EXPECT_LE((bent.path.rotation.back()[1] - moved.path.rotation.back()[1]).norm(), tolerance(1e-12));
}

TEST(FirstMotion, turns_about_the_axes_that_the_joints_have) {
  maneuver::Problem problem = turning(2.0);
  problem.swimmer.joints[0].kind = model::JointKind::hinge;
  problem.swimmer.joints[0].axis = Vector3d(0.0, 0.6, 0.8);
  const model::System system(problem.swimmer);
  const model::Joint& hinge = system.joint(0);
  for (const mechanics::Rotations& R : search::first_motion(system, problem, turned().solution).path.rotation) {
    const Matrix3d Q = mechanics::child_to_parent(R, hinge);
    EXPECT_LE((Q - mechanics::joint_rotation(hinge, mechanics::joint_angles(hinge, Q))).norm(), tolerance(1e-12));
  }
}

TEST(FirstMotion, brings_its_duration_where_that_is_free) {
  maneuver::Problem problem = turning(2.0);
  EXPECT_EQ(first(problem).duration, 1.0);
  problem.duration = {.free = true, .value = 2.0, .min = 0.5, .max = 4.0};
  EXPECT_EQ(first(problem).duration, 1.0);
  problem.duration.min = 1.5;
  EXPECT_EQ(first(problem).duration, 1.5);
}

}  // namespace
}  // namespace lamprey::tests
