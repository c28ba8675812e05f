// What is asked of a gait beside its goal: its first shape is an unknown.
#include <gtest/gtest.h>

#include "evidence/bounds.hpp"
#include "file/problem_file.hpp"
#include "maneuver/limit_rows.hpp"
#include "search/solve.hpp"
#include "shape/gait_cycles.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem gait(double first_guess) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/gait.toml");
  problem.steps = 40;
  problem.search.starts = 1;
  problem.start.rotation.back().z() += first_guess;
  return problem;
}

maneuver::Solution solved(const maneuver::Problem& problem) {
  return search::solve(model::System(problem.swimmer), problem, search::SolveOptions()).front();
}

double bent(const model::System& system, const maneuver::Solution& solution, std::size_t node) {
  const model::Joint& joint = system.joint(1);
  return lie::rotation_angle(mechanics::child_to_parent(solution.rotation[node], joint));
}

// A first guess of the shape says nothing of where bodies are later.
TEST(GaitTerms, waypoints_turn_the_root_alone_where_the_first_shape_is_free) {
  maneuver::Problem problem = gait(0.0);
  ASSERT_TRUE(problem.start.free_shape);
  const model::System system(problem.swimmer);
  problem.waypoints.push_back(
      {.time = 0.5 * problem.duration.value, .move = {}, .turn = Eigen::Vector3d(0.0, 0.0, 0.1), .rotation = {}});
  const auto turned = [&] {
    std::size_t rows = 0;
    for (const maneuver::LimitRow& row : maneuver::limit_rows(system, problem))
      rows += row.kind == maneuver::LimitRow::Kind::pass_turn ? 1 : 0;
    return rows;
  };
  EXPECT_EQ(turned(), 3U);
  const maneuver::Solution one = solved(problem);
  ASSERT_EQ(one.status, maneuver::Status::optimal) << one.message;
  const std::size_t middle = one.rotation.size() / 2;
  EXPECT_LT((lie::log(one.rotation[middle][0]) - Eigen::Vector3d(0.0, 0.0, 0.1)).norm(), tolerance(1e-9));
  EXPECT_GT(std::abs(bent(system, one, middle) - lie::log(lie::exp(problem.start.rotation.back())).norm()), 1e-3)
      << "bent as the first guess";
  problem.waypoints[0].rotation[system.body(1).name] = Eigen::Vector3d(0.0, 0.0, 0.2);
  EXPECT_EQ(turned(), 6U) << "what is said of a body is said of it";
  problem.start.free_shape = false;
  EXPECT_EQ(turned(), 3U * static_cast<std::size_t>(system.body_count()));
}

// At node 0 most limits do not apply, so that a seam pulls as a cycle's end does.
TEST(GaitTerms, repeated_limits_pull_at_the_seams_as_at_a_cycles_end) {
  shape::LimitMultipliers gait;
  gait.value = Eigen::MatrixXd::Random(3, 5).cwiseAbs();
  gait.value.col(0).setZero();
  const shape::LimitMultipliers twice = shape::repeated(gait, 2);
  ASSERT_EQ(twice.value.cols(), 9);
  EXPECT_EQ(twice.value.leftCols(5), gait.value);
  EXPECT_EQ(twice.value.rightCols(4), gait.value.rightCols(4));
}

}  // namespace
}  // namespace lamprey::tests
