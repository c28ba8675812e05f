// Goals that a motion is known to reach, because one was marched along given joint angles, are found, and at less than that motion
// costs: links in a row, hulls with paddles, stars on ball joints, with limits and without.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "chains.hpp"
#include "file/problem_file.hpp"
#include "guess/angle_march.hpp"
#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "maneuver/motion.hpp"
#include "search/stroke_searches.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Vectors;

struct Kind {
  const char* name;
  model::SwimmerDescription (*swimmer)(Random& random);
};

model::BodyDescription ellipsoid(const std::string& name, const Vector3d& semi_axes) {
  model::BodyDescription body;
  body.name = name;
  body.semi_axes = semi_axes;
  return body;
}

model::JointDescription joined(const std::string& parent, const std::string& child, const Vector3d& parent_offset,
                               const Vector3d& child_offset, model::JointKind kind) {
  model::JointDescription joint;
  joint.name = child;
  joint.kind = kind;
  joint.parent = parent;
  joint.child = child;
  joint.parent_offset = parent_offset;
  joint.child_offset = child_offset;
  if (kind == model::JointKind::hinge) joint.axis = Vector3d::UnitZ();
  return joint;
}

model::SwimmerDescription links(Random& random) {
  model::SwimmerDescription swimmer;
  swimmer.density = 1000.0;
  const double a = random.uniform(0.08, 0.2), b = a * random.uniform(0.1, 0.4), c = a * random.uniform(0.2, 0.6);
  for (int i = 0; i < 4; ++i) {
    swimmer.bodies.push_back(ellipsoid("link" + std::to_string(i), {a, b, c}));
    if (i > 0)
      swimmer.joints.push_back(joined("link" + std::to_string(i - 1), "link" + std::to_string(i), {-1.1 * a, 0, 0},
                                      {1.1 * a, 0, 0}, model::JointKind::hinge));
  }
  return swimmer;
}

model::SwimmerDescription paddles(Random& random) {
  model::SwimmerDescription swimmer;
  swimmer.density = 1000.0;
  const double length = random.uniform(0.3, 0.6), width = length * random.uniform(0.2, 0.35);
  swimmer.bodies.push_back(ellipsoid("hull", {length, width, width}));
  for (int i = 0; i < 4; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0, ahead = i < 2 ? 0.6 : -0.6;
    swimmer.bodies.push_back(
        ellipsoid("paddle" + std::to_string(i), {random.uniform(0.03, 0.06), 0.35 * length, 0.12 * length}));
    swimmer.joints.push_back(joined("hull", swimmer.bodies.back().name, {ahead * length, 1.05 * side * width, 0},
                                    {0, -0.37 * side * length, 0}, model::JointKind::hinge));
  }
  return swimmer;
}

model::SwimmerDescription star(Random& random) {
  model::SwimmerDescription swimmer;
  swimmer.density = 1000.0;
  swimmer.bodies.push_back(ellipsoid("core", {0.15, 0.15, 0.1}));
  for (int i = 0; i < 3; ++i) {
    const double turned = 2.0 * std::numbers::pi * i / 3.0;
    swimmer.bodies.push_back(ellipsoid("arm" + std::to_string(i), {0.2, random.uniform(0.04, 0.06), 0.08}));
    swimmer.joints.push_back(joined("core", swimmer.bodies.back().name,
                                    0.18 * Vector3d(std::cos(turned), std::sin(turned), 0), {-0.22, 0, 0},
                                    model::JointKind::ball));
    swimmer.joints.back().reference_rotation = {0, 0, turned};
  }
  return swimmer;
}

// Amplitudes and phases of the joints' angles.
std::vector<std::array<Vector3d, 2>> random_swings(Random& random, const model::System& system) {
  std::vector<std::array<Vector3d, 2>> swing;
  for (const model::Joint& joint : system.joints()) {
    swing.push_back({Vector3d::Zero(), random.vector(2.0)});
    for (int c = 0; c < system.body(joint.child).freedoms; ++c)
      swing.back()[0][c] = random.uniform(0.5, 1.0) * (joint.free() ? 0.6 : 1.0);
  }
  return swing;
}

// Each angle swings so often about zero, from rest to rest.
guess::JointAngles from_rest_to_rest(Random& random, const model::System& system, double duration) {
  const double cycles = random.integer(1, 3);
  const auto swing = random_swings(random, system);
  const auto turn = [=](double t) {
    const double s = std::clamp(t / duration, 0.0, 1.0);
    const double share = guess::blend(std::min(1.0, 4.0 * s)) * guess::blend(std::min(1.0, 4.0 - 4.0 * s));
    Vectors all;
    for (const auto& [amplitude, phase] : swing) {
      all.push_back(share * amplitude);
      for (int c = 0; c < 3; ++c) all.back()[c] *= std::sin(2.0 * std::numbers::pi * cycles * s + phase[c]);
    }
    return all;
  };
  return {turn, [n = swing.size()](double) { return Vectors(n, Vector3d::Zero()); }};  // at rest at both ends
}

// Once round a loop.
guess::JointAngles round_a_loop(Random& random, const model::System& system, double duration) {
  const auto swing = random_swings(random, system);
  const double rate = 2.0 * std::numbers::pi / duration;
  const auto each = [swing](double angle, double scale) {
    Vectors all;
    for (const auto& [amplitude, phase] : swing) {
      all.push_back(scale * amplitude);
      for (int c = 0; c < 3; ++c) all.back()[c] *= std::sin(angle + phase[c]);
    }
    return all;
  };
  return {[=](double t) { return each(rate * t, 1.0); },
          [=](double t) { return each(rate * t + 0.5 * std::numbers::pi, rate); }};
}

class ReachableGoals : public testing::TestWithParam<Kind> {};

// A swimmer at rest with its joints at their zero angles.
maneuver::Problem problem_of(const model::SwimmerDescription& swimmer, double duration) {
  maneuver::Problem problem;
  problem.swimmer = swimmer;
  problem.steps = 100;
  problem.duration.value = duration;
  for (const model::BodyDescription& body : swimmer.bodies) {
    problem.start.rotation.emplace_back(Vector3d::Zero());
    problem.start.angular_velocity.emplace_back(Vector3d::Zero());
    for (const model::JointDescription& joint : swimmer.joints)
      if (joint.child == body.name) problem.start.rotation.back() = joint.reference_rotation;
  }
  problem.search.starts = 2;
  return problem;
}

void limit_joints(maneuver::Problem& problem) {
  for (const model::JointDescription& joint : problem.swimmer.joints)
    if (joint.kind == model::JointKind::hinge)
      problem.limits.angle[joint.name] = {{-1.2, 1.2}};
    else
      problem.limits.swing[joint.name] = problem.limits.twist[joint.name] = 1.2;
}

// What a known motion reaches is the goal.
void expect_found(const maneuver::Problem& asked, const guess::JointAngles& angles, bool gait) {
  maneuver::Problem problem = asked;
  const model::System system(problem.swimmer);
  const maneuver::Solution known = guess::march_along(system, problem, angles);
  ASSERT_EQ(known.status, maneuver::Status::simulated) << known.message;
  const double effort = maneuver::cost_of(
      maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, problem.time_step(), problem.steps), known.control);
  problem.goal = maneuver::Goal();
  for (int c = 0; c < 3; ++c) problem.goal->move[model::at(c)] = known.position.back()[c] - known.position.front()[c];
  problem.goal->turn = lie::log(known.rotation.back()[0] * known.rotation.front()[0].transpose());
  problem.goal->periodic = problem.start.free_shape = gait;
  problem.goal->rest = !gait;
  for (const bool limited : {false, true}) {
    if (limited) limit_joints(problem);
    const study::Answer answer = study::answer(system, problem, {});
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << limited << ": " << answer.solution.message;
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << limited << ": " << answer.solution.message;
    EXPECT_LE(answer.certificate.goal_error, 1e-9);
    EXPECT_LT(answer.solution.cost, effort);
  }
}

TEST_P(ReachableGoals, are_found_at_less_than_a_motion_that_is_known) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    Random random(100 + seed);
    const model::SwimmerDescription swimmer = GetParam().swimmer(random);
    const maneuver::Problem problem = problem_of(swimmer, random.uniform(1.0, 5.0));
    expect_found(problem, from_rest_to_rest(random, model::System(swimmer), problem.duration.value), false);
  }
}

TEST_P(ReachableGoals, of_gaits_are_found_at_less_than_a_loop_that_is_known) {
  Random random(202);
  const model::SwimmerDescription swimmer = GetParam().swimmer(random);
  const maneuver::Problem problem = problem_of(swimmer, random.uniform(1.0, 5.0));
  expect_found(problem, round_a_loop(random, model::System(swimmer), problem.duration.value), true);
}

INSTANTIATE_TEST_SUITE_P(Swimmers, ReachableGoals,
                         testing::Values(Kind{"links", links}, Kind{"paddles", paddles}, Kind{"star", star}),
                         [](const auto& the) { return the.param.name; });

// Three strokes of a gait, the first growing out of rest and the last going back to it, are near a motion that meets the goal within
// the limits.
TEST(GaitsOfManyStrokes, grow_out_of_rest_and_go_back_to_it) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/sideways_by_two_fins.toml");
  problem.steps = 59;  // enough for three strokes, too few for five
  problem.duration.value *= 3.0 / 16.0;
  problem.goal->move[1] = 0.036;
  const model::System system(problem.swimmer);
  const search::SolveOptions options;
  const search::Budget budget(problem, options);
  const search::Grids grids(system, problem, options, budget);
  const std::vector<search::Found> found = search::solve_gaits_from_rest(grids);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found.front().converged()) << found.front().outcome.reason;
  problem.goal->rotation["bow"] = Vector3d::Zero();  // a gait does not know it
  EXPECT_TRUE(search::solve_gaits_from_rest(search::Grids(system, problem, options, budget)).empty());
}

// What one stroke within limits does not reach is reached by several cycles of a smaller gait.
TEST(GaitsOfManyStrokes, are_found_where_single_ones_break_limits) {
  for (const auto& [bend, move] : {std::pair(0.2, 0.1), std::pair(0.5, 0.2)}) {
    maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/ellipses.toml");
    problem.search.starts = 2;
    for (auto& [joint, bounds] : problem.limits.angle) bounds = {{-bend, bend}};
    problem.goal->move[0] = move;
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    EXPECT_GT(answer.solution.search.strokes, 0) << "a start alone arrived: no test of strokes";
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  }
}

}  // namespace
}  // namespace lamprey::tests
