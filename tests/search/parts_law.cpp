// A goal in equal parts: what is done once, as often as there are parts, is what the goal asks for.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "chains.hpp"
#include "file/problem_file.hpp"
#include "lie/so3.hpp"
#include "search/parts.hpp"
#include "search/smaller_problem.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<std::optional<double>, 3> nowhere = {};

maneuver::Problem asked(const Vector3d& turn, std::array<std::optional<double>, 3> move) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain();
  problem.start.rotation.assign(3, Vector3d::Zero());
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.duration.value = 6.0;
  problem.goal = maneuver::Goal();
  problem.goal->turn = turn;
  problem.goal->move = move;
  return problem;
}

// Where the root ends after so many of them, each seen from where the one before it ended; along free axes of each as given.
struct End {
  Matrix3d turn = Matrix3d::Identity();
  Vector3d move = Vector3d::Zero();
};

End done(const maneuver::Problem& part, int times, const Vector3d& where_free) {
  Vector3d once = where_free;
  for (int axis = 0; axis < 3; ++axis)
    if (const auto& along = part.goal->move[static_cast<std::size_t>(axis)]) once[axis] = *along;
  End end;
  for (int n = 0; n < times; ++n) {
    end.move += end.turn * once;
    end.turn = end.turn * lie::exp(*part.goal->turn);
  }
  return end;
}

TEST(PartsOfAGoal, done_one_after_the_other_are_all_of_it) {
  for (const int parts : {2, 3, 8, 16})
    for (const Vector3d& turn : {Vector3d(0.0, 0.0, 3.0), Vector3d(0.4, -1.2, 0.7), Vector3d(0.0, 0.0, 0.0)})
      for (const Vector3d& move : {Vector3d(2.0, -1.0, 0.5), Vector3d(0.0, 0.0, 0.0)}) {
        const maneuver::Problem whole = asked(turn, {move[0], move[1], move[2]});
        const maneuver::Problem part = search::part_of(whole, parts);
        const End end = done(part, parts, Vector3d::Zero());
        EXPECT_LT((end.turn - lie::exp(turn)).norm(), 1e-13);
        EXPECT_LT((end.move - move).norm(), 1e-12);
        EXPECT_DOUBLE_EQ(parts * part.duration.value, 6.0);
      }
}

// What is free in the whole is free in its parts where nothing turns; where it turns, some displacement along it serves.
TEST(PartsOfAGoal, leave_free_what_is_free) {
  const Vector3d elsewhere(0.0, 0.3, -0.2);
  const End straight =
      done(search::part_of(asked(Vector3d::Zero(), {2.0, std::nullopt, std::nullopt}), 4), 4, elsewhere);
  EXPECT_NEAR(straight.move[0], 2.0, 1e-15);
  EXPECT_NEAR(straight.move[1], 1.2, 1e-15);
  const maneuver::Problem turning =
      search::part_of(asked(Vector3d(0.0, 0.0, 1.5), {2.0, std::nullopt, std::nullopt}), 4);
  EXPECT_NEAR(done(turning, 4, elsewhere).move[0], 2.0, 1e-14);
  const maneuver::Problem in_place = search::part_of(asked(Vector3d(0.0, 0.0, 1.5), nowhere), 4);
  EXPECT_FALSE(in_place.goal->move[0] || in_place.goal->move[1] || in_place.goal->move[2]);
}

TEST(PartsOfAGoal, begin_and_end_at_rest_in_the_same_shape) {
  maneuver::Problem whole = asked(Vector3d(0.0, 0.0, 1.0), nowhere);
  EXPECT_TRUE(search::has_parts(whole));
  whole.goal->rest = false;
  EXPECT_FALSE(search::has_parts(whole));
  whole.goal->rest = true;
  whole.start.angular_velocity[1] = Vector3d(0.1, 0.0, 0.0);
  EXPECT_FALSE(search::has_parts(whole));
  whole.start.angular_velocity[1].setZero();
  whole.goal->rotation["front"] = Vector3d(0.0, 0.0, 1.0);
  EXPECT_FALSE(search::has_parts(whole));
  whole.goal->rotation.clear();
  whole.goal->turn.reset();
  whole.goal->move = {1.0, std::nullopt, std::nullopt};
  EXPECT_TRUE(search::part_of(whole, 2).goal->turn->isZero(0.0)) << "else shapes would be free at its end";
}

// Three links on hinges that turn by half a radian to either side, asked for more than a stroke wins.
TEST(SearchInParts, arrives_within_limits_and_costs_less_than_its_parts) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/three_links_in_1000_steps.toml");
  problem.steps = 200;
  problem.duration.value = 8.0;
  problem.start.free_shape = false;
  problem.goal = maneuver::Goal();
  problem.goal->turn = Vector3d(0.0, 0.0, 0.3);
  problem.limits = {};
  const model::System system(problem.swimmer);
  for (int j = 0; j < system.joint_count(); ++j) problem.limits.angle[system.joint(j).name] = {{-0.5, 0.5}};
  const search::SolveOptions options;
  const search::Budget budget(problem, options);
  const search::Grids grids(system, problem, options, budget);
  const search::Found eighth = search::solve_smaller(grids, search::part_of(problem, 8));
  ASSERT_TRUE(eighth.converged()) << eighth.outcome.reason;
  double cheapest = std::numeric_limits<double>::infinity();
  for (const search::Found& found : search::solve_in_parts(grids)) {
    if (!found.converged()) continue;
    cheapest = std::min(cheapest, found.cost);
    const Matrix3d turned = found.path.rotation.back()[0] * found.path.rotation.front()[0].transpose();
    EXPECT_LT((turned - lie::exp(*problem.goal->turn)).norm(), 1e-8);
    for (const mechanics::Rotations& R : found.path.rotation)
      for (const model::Joint& joint : system.joints())
        EXPECT_LT(lie::rotation_angle(mechanics::child_to_parent(R, joint)), 0.5 + 1e-8);
  }
  EXPECT_LT(cheapest, 0.9 * 8.0 * eighth.cost) << "began from eight of them, each at rest at both ends";
}

// A minimum with joints held to a rate is a way that was found, not an end: parts are tried beside it, and lead to one without that.
TEST(Parts, are_tried_where_first_guesses_lead_to_held_joints_alone) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/whipping_tail.toml");
  problem.start.free_shape = false;
  problem.goal = maneuver::Goal();
  problem.goal->turn = Vector3d(0.0, 0.0, 1.4);
  problem.search.starts = 2;
  problem.search.seed = 2;
  const model::System system(problem.swimmer);
  const search::SolveOptions options;
  const search::Budget budget(problem, options);
  const auto method = search::newton_method(system, problem, options, budget);
  const std::vector<search::Found> starts = method->solve_starts(0, 2);
  ASSERT_FALSE(search::any_converged(starts));
  ASSERT_TRUE(std::any_of(starts.begin(), starts.end(), [](const auto& found) { return found.held(); }));
  const maneuver::Solution solution = search::solve(system, problem, options).front();
  EXPECT_EQ(solution.status, maneuver::Status::optimal) << solution.message;
  EXPECT_FALSE(solution.solver.held_joint_rate);
}

}  // namespace
}  // namespace lamprey::tests
