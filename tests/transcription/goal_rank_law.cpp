#include "transcription/goal_rank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "chains.hpp"
#include "guess/guess.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Problem;
using transcription::GoalRow;

Problem maneuver_of_the_paper(bool planar) {
  Problem problem;
  problem.swimmer = paper_chain();
  if (planar)
    for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  problem.start.rotation = {Vector3d::Zero(), Vector3d::Zero(), Vector3d(0, 0, std::numbers::pi / 4)};
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.goal = maneuver::Goal();
  return problem;
}

Problem translation(bool planar) {
  Problem problem = maneuver_of_the_paper(planar);
  problem.goal->move[0] = 2.0;
  problem.goal->turn = Vector3d::Zero();
  return problem;
}

Problem rotation() {
  Problem problem = maneuver_of_the_paper(false);
  problem.goal->turn = Vector3d(std::numbers::pi, 0, 0);
  return problem;
}

std::vector<GoalRow> kept(const Problem& problem, int steps, std::uint64_t seed) {
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = make_maneuver(system, problem, steps);
  return transcription::independent_goal_rows(system, maneuver, guess::random_guess(system, maneuver, seed));
}

std::size_t count(const std::vector<GoalRow>& rows, GoalRow::Kind kind) {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [kind](const GoalRow& r) { return r.kind == kind; }));
}

class GoalRank : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(GoalRank, keeps_six_rows_of_the_translation_in_the_plane) {
  const std::vector<GoalRow> rows = kept(translation(true), 20, GetParam());
  EXPECT_EQ(rows.size(), 6U);
  EXPECT_EQ(count(rows, GoalRow::Kind::rotation), 3U);
  EXPECT_EQ(count(rows, GoalRow::Kind::position), 1U);
  for (const GoalRow& row : rows)
    EXPECT_TRUE(row.kind == GoalRow::Kind::position || row.component == 2) << "only turns about e_3 can be moved";
}

TEST_P(GoalRank, keeps_sixteen_rows_of_the_translation_in_space) {
  EXPECT_EQ(kept(translation(false), 20, GetParam()).size(), 16U);
}

TEST_P(GoalRank, keeps_fifteen_rows_of_the_rotation) { EXPECT_EQ(kept(rotation(), 20, GetParam()).size(), 15U); }

TEST_P(GoalRank, knows_that_in_the_plane_nothing_moves_out_of_it) {
  Problem problem = translation(true);
  problem.goal->move = {std::nullopt, 1.0, 0.0};
  const std::vector<GoalRow> rows = kept(problem, 20, GetParam());
  EXPECT_EQ(rows.size(), 6U);
  for (const GoalRow& row : rows)
    EXPECT_TRUE(row.kind != GoalRow::Kind::position || row.component == 1) << "e_3 is out of the plane";
}

TEST_P(GoalRank, finds_the_mass_centre_fixed_in_a_vacuum) {
  Problem problem = rotation();  // end rotations free of the fluid's help: 9 of turning and 6 of rest stay independent
  problem.swimmer.density = 0.0;
  for (model::BodyDescription& body : problem.swimmer.bodies) {
    body.mass = body.mass_matrix->diagonal().mean();
    body.mass_matrix = *body.mass * Matrix3d::Identity();
    body.body_inertia = body.inertia_matrix;
  }
  EXPECT_EQ(kept(problem, 20, GetParam()).size(), 15U);
  const model::System system(problem.swimmer);
  maneuver::Maneuver maneuver = make_maneuver(system, problem, 20);
  maneuver.end_position = {0.0, 0.0, 0.0};  // follows from the end rotations
  EXPECT_EQ(transcription::stated_goal_rows(system, maneuver).size(), 18U);
  EXPECT_EQ(
      transcription::independent_goal_rows(system, maneuver, guess::random_guess(system, maneuver, GetParam())).size(),
      15U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, GoalRank, ::testing::Values(1, 2, 3, 11, 12345), named_by_value);

TEST(GoalRank, does_not_depend_on_resolution_scheme_or_control_kind) {
  for (auto scheme : {integrator::Scheme::paper, integrator::Scheme::trapezoid})
    for (int steps : {12, 40}) {
      Problem problem = translation(false);
      problem.scheme = scheme;
      problem.control = maneuver::ControlKind::spline;
      problem.points = 10;
      EXPECT_EQ(kept(problem, steps, 1).size(), 16U) << steps << " steps";
    }
}

TEST(GoalRank, keeps_fewer_rows_when_less_is_asked) {
  Problem problem = translation(false);
  problem.goal->turn.reset();
  problem.goal->rotation["front"] = Vector3d(0.1, 0.2, 0.3);
  problem.goal->rest = false;
  const std::vector<GoalRow> rows = kept(problem, 20, 1);
  EXPECT_EQ(rows.size(), 4U);
  EXPECT_EQ(count(rows, GoalRow::Kind::rest), 0U);
}

}  // namespace
}  // namespace lamprey::tests
