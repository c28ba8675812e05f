// Marches whose files tell of steps that were none, of moments that their joints cannot exert, or of too little.
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "file/words.hpp"
#include "task/stored_statements.hpp"
#include "task/tasks.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using maneuver::Scheme;
using result::Results;

// N m, at the front joint.
using Moment = std::function<double(double time)>;

// Three bodies whose joints bend in a plane, under moments that change between the nodes.
Results marched(
    Scheme scheme, const Moment& front = [](double t) { return 30.0 * std::sin(5.0 * t); }) {
  file::ProblemFile file = file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  task::MarchOptions options;
  options.scheme = scheme;
  options.steps = 40;
  options.control = [front](double t) {
    return std::vector<Vector3d>{Vector3d(0.0, 0.0, front(t)), Vector3d(0.0, 0.0, -20.0)};
  };
  return task::march_task(file, options, "");
}

struct ForgedMarches : testing::TestWithParam<Scheme> {
  // Why the march is none, once changed; empty where it is one.
  static std::string fault(const std::function<void(Results&)>& change) {
    Results results = marched(GetParam());
    change(results);
    return task::certified(results).solution.message;
  }
};

void expect_true(const Results& march) {
  const Results again = task::certified(march);
  EXPECT_EQ(again.solution.status, maneuver::Status::simulated);
  EXPECT_EQ(again.solution.message, "");
  EXPECT_LE(again.certificate->equation_residual, 1e-11);
  EXPECT_LE(again.certificate->control_error, 1e-12);
  EXPECT_LE(again.certificate->velocity_error, 1e-9);
}

TEST_P(ForgedMarches, as_they_were_marched_are_true) { expect_true(marched(GetParam())); }

// At a node as well as within a step.
TEST_P(ForgedMarches, under_moments_that_jump_are_true) {
  for (const double when : {0.5, 0.513})
    expect_true(marched(GetParam(), [when](double t) { return t < when ? 30.0 : -30.0; }));
}

TEST_P(ForgedMarches, of_places_that_no_step_leads_to_are_told) {
  EXPECT_NE(fault([](Results& r) { r.solution.position[7] += Vector3d(1e-6, 0.0, 0.0); }).find("discrete equations"),
            std::string::npos);
  const std::string stands = fault([](Results& r) {  // each node another swimmer at rest, at no momentum
    for (auto* vectors :
         {&r.solution.linear_velocity, &r.solution.linear_momentum.total, &r.solution.linear_momentum.bodies,
          &r.solution.linear_momentum.fluid, &r.solution.angular_momentum.total, &r.solution.angular_momentum.bodies,
          &r.solution.angular_momentum.fluid})
      for (Vector3d& v : *vectors) v.setZero();
    for (auto& node : r.solution.angular_velocity)
      for (Vector3d& v : node) v.setZero();
    for (std::size_t k = 1; k < r.solution.position.size(); ++k) r.solution.position[k].setRandom();
  });
  EXPECT_NE(stands.find("discrete equations"), std::string::npos) << stands;
}

TEST_P(ForgedMarches, by_moments_that_joints_cannot_exert_are_told) {
  const std::string aside = fault([](Results& r) {
    for (std::size_t k = 0; k < r.solution.control.size(); ++k) r.solution.control[k][0].x() += 1e-3;
    for (auto& step : r.solution.control_stages)
      for (auto& node : step) node[0].x() += 1e-3;
  });
  EXPECT_NE(aside, "");
  Results confined = marched(GetParam());
  confined.problem.joints[1].control_axes.clear();  // a passive joint, and moments on it
  confined.problem.joints[1].actuated = false;
  const std::string passive = task::certified(confined).solution.message;
  EXPECT_NE(passive.find("outside what the joints can exert"), std::string::npos) << passive;
}

INSTANTIATE_TEST_SUITE_P(Schemes, ForgedMarches,
                         testing::Values(Scheme::paper, Scheme::trapezoid, Scheme::midpoint, Scheme::order4,
                                         Scheme::order6),
                         [](const auto& is) { return std::string(file::word(is.param)); });

// Of marches by the reference integrator, and of steps that were divided, files tell the nodes alone.
TEST(ForgedMarch, whose_steps_are_not_told_must_be_within_what_its_moments_do) {
  file::ProblemFile file = file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  task::MarchOptions options;
  options.steps = 40;
  options.control = [](double t) {
    return std::vector<Vector3d>{Vector3d(0.0, 0.0, t < 0.513 ? 30.0 : -30.0), Vector3d(0.0, 0.0, -20.0)};
  };
  options.reference = true;
  const Results reference = task::march_task(file, options, "");
  ASSERT_FALSE(reference.solution.marched_by.empty());
  Results renamed = marched(Scheme::trapezoid);
  renamed.solution.divided.steps = 1;
  for (const Results& march : {reference, renamed}) {
    const Results again = task::certified(march);
    EXPECT_EQ(again.solution.message, "");
    EXPECT_LE(again.certificate->beyond_moments, 1.0);
    Results moved = march;
    for (std::size_t k = 20; k < moved.solution.position.size(); ++k) moved.solution.position[k].x() += 50.0;
    EXPECT_NE(task::certified(moved).solution.message, "") << "elsewhere from the middle on";
    Results turned = march;
    for (auto& velocities : turned.solution.angular_velocity)
      for (Vector3d& velocity : velocities) velocity *= -1.0;
    EXPECT_NE(task::certified(turned).solution.message, "");
  }
}

TEST(ForgedMarch, above_order_2_without_what_their_steps_are_made_of_are_told) {
  Results results = marched(Scheme::order4);
  results.solution.control_stages.clear();
  results.solution.stage_time.clear();
  const Results again = task::certified(results);
  EXPECT_NE(again.solution.message.find("the files lack control_stages"), std::string::npos) << again.solution.message;
}

std::string false_field(Results results, const std::function<void(Results&)>& change) {
  const Results found = task::certified(results);
  change(results);
  const auto claims = task::false_statements(results, found, false);
  return claims.empty() ? "" : claims.front().field;
}

// A whole turn is in no rotation: at one node, or at all of them.
TEST(ForgedMarch, by_whole_turns_of_a_joint_are_told) {
  const Results results = marched(Scheme::order4);
  EXPECT_EQ(false_field(results, [](Results&) {}), "");
  const auto whole_turn = [](Vector3d& turn) { turn += 2.0 * std::numbers::pi * turn.normalized(); };
  EXPECT_EQ(false_field(results, [&](Results& r) { whole_turn(r.solution.joint_angle[9][0]); }),
            "joint_angle[9][0][2]");
  EXPECT_EQ(false_field(results,
                        [&](Results& r) {
                          for (auto& node : r.solution.joint_angle) whole_turn(node[1]);
                        }),
            "joint_angle[0][1][2]");
}

TEST(ForgedMarch, with_parts_of_a_cost_are_told) {
  EXPECT_EQ(false_field(marched(Scheme::trapezoid), [](Results& r) { r.solution.cost_parts.emplace(); }), "cost_parts");
}

}  // namespace
}  // namespace lamprey::tests
