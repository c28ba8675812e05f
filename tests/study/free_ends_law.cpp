// Goals that leave joints free at the end, from a straight shape, in which what they move is of second order: the conditions are counted,
// and the search begins, where they are bent.
#include <gtest/gtest.h>

#include <cmath>

#include "guess/guess.hpp"
#include "search/grids.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

// So many ellipsoids in a row on hinges about e_3, straight at the start.
maneuver::Problem straight_row(int bodies, double density) {
  maneuver::Problem problem;
  problem.swimmer.density = density;
  for (int i = 0; i < bodies; ++i) {
    model::BodyDescription body;
    body.name = "b" + std::to_string(i);
    body.semi_axes = {0.2, 0.08, 0.1};
    body.mass = 3.0;
    problem.swimmer.bodies.push_back(body);
    if (i == 0) continue;
    model::JointDescription joint;
    joint.name = "j" + std::to_string(i);
    joint.parent = "b" + std::to_string(i - 1);
    joint.child = body.name;
    joint.kind = model::JointKind::hinge;
    joint.axis = Vector3d::UnitZ();
    joint.parent_offset = {-0.22, 0.0, 0.0};
    joint.child_offset = {0.22, 0.0, 0.0};
    problem.swimmer.joints.push_back(joint);
  }
  problem.start.rotation.assign(static_cast<std::size_t>(bodies), Vector3d::Zero());
  problem.start.angular_velocity = problem.start.rotation;
  problem.goal.emplace();
  problem.duration.value = 3.0;
  problem.steps = 60;
  problem.search.starts = 3;
  return problem;
}

study::Answer answer_of_row(const maneuver::Problem& problem) {
  return study::answer(model::System(problem.swimmer), problem, {});
}

// In a vacuum where a body ends follows from how all of them are bent.
TEST(FreeEnds, of_a_row_in_a_vacuum_are_reached_by_bending_it) {
  maneuver::Problem problem = straight_row(3, 0.0);
  problem.goal->move = {-0.03, 0.0, std::nullopt};
  problem.goal->rotation["b0"] = Vector3d::Zero();
  const study::Answer answer = answer_of_row(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  for (const certificate::GridCost& grid : answer.certificate.refinement.value_or(certificate::Refinement()).grids)
    EXPECT_NEAR(grid.cost / answer.solution.cost, 1.0, 0.1) << grid.steps;
}

TEST(FreeEnds, of_a_single_hinge_are_reached_by_bending_it) {
  maneuver::Problem problem = straight_row(2, 1000.0);
  problem.goal->move = {-0.02, std::nullopt, std::nullopt};
  for (const bool limited : {false, true}) {
    if (limited) problem.limits.angle["j1"] = {{-2.0, 2.0}};
    const study::Answer answer = answer_of_row(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  }
}

// What does follow from the rest is dropped wherever it is counted.
TEST(FreeEnds, in_a_vacuum_keep_the_mass_centre_of_all) {
  maneuver::Problem problem = straight_row(3, 0.0);
  problem.goal->rotation["b0"] = Vector3d::Zero();
  problem.goal->angle["j1"] = {0.5};
  problem.goal->angle["j2"] = {-0.3};
  const double moved = (0.66 * std::cos(0.5) + 0.22 * std::cos(0.2) - 0.88) / 3.0;
  problem.goal->move = {moved, std::nullopt, std::nullopt};
  const model::System system(problem.swimmer);
  EXPECT_EQ(search::Reached(system, problem).rows.size(), 3U);
  const study::Answer answer = answer_of_row(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.goal_error, 1e-12);
}

// Guesses end bent where the goal says nothing, and as it says elsewhere; those of gaits end in their first shape.
TEST(FreeEnds, of_first_guesses_are_bent_where_the_goal_leaves_them_so) {
  maneuver::Problem problem = straight_row(3, 1000.0);
  const model::System system(problem.swimmer);
  const auto bend = [&](std::size_t child) {
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 20);
    const mechanics::Rotations end = guess::random_guess(system, maneuver, 5).rotation.back();
    return lie::rotation_angle(end[child - 1].transpose() * end[child]);
  };
  problem.goal->move = {0.1, std::nullopt, std::nullopt};
  EXPECT_GT(bend(1), 0.01);
  EXPECT_GT(bend(2), 0.01);
  problem.goal->angle["j1"] = {0.3};
  EXPECT_NEAR(bend(1), 0.3, 1e-12);
  EXPECT_GT(bend(2), 0.01);
  problem.goal->angle.clear();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->periodic = true;
  EXPECT_NEAR(bend(1), 0.0, 1e-12);
}

}  // namespace
}  // namespace lamprey::tests
