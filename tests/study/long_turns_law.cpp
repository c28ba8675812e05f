// On grids that answer no body turns by more than a quarter in one step, however far the search would like it to.
#include <gtest/gtest.h>

#include <numbers>

#include "file/problem_file.hpp"
#include "lie/so3.hpp"
#include "maneuver/guess.hpp"
#include "maneuver/shape_program.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using maneuver::ShapeProgram;
using maneuver::Steps;

maneuver::Problem yaw(int steps) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/yaw.toml");
  problem.steps = steps;
  return problem;
}

double largest_turn(const std::vector<mechanics::Rotations>& rotation) {
  double largest = 0.0;
  for (std::size_t k = 0; k + 1 < rotation.size(); ++k)
    for (std::size_t i = 0; i < rotation[k].size(); ++i)
      largest = std::max(largest, lie::log(rotation[k][i].transpose() * rotation[k + 1][i]).norm());
  return largest;
}

// Coarse grids offer such turns at a lower cost: half a turn in a step carries no momentum.
TEST(LongTurns, are_no_answers) {
  const maneuver::Problem problem = yaw(100);
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
  EXPECT_LE(largest_turn(answer.solution.rotation), 0.5 * std::numbers::pi);
  EXPECT_NEAR(answer.solution.cost, 156686.17, 1e-6 * 156686.17);
  EXPECT_GE(answer.solution.search.solved, problem.search.starts - 2);
}

TEST(LongTurns, are_named_where_coarser_grids_are_asked_for) {
  maneuver::Problem problem = yaw(30);
  problem.search.starts = 4;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  ASSERT_GT(largest_turn(answer.solution.rotation), 0.5 * std::numbers::pi);
  EXPECT_NE(
      answer.solution.message.find("a quarter turn is the most that a step can show: time.steps = 30 may be too few"),
      std::string::npos)
      << answer.solution.message;
}

// The front body's joint bends back and forth by a given angle.
TEST(LongTurns, are_motions_of_rough_steps_alone) {
  const maneuver::Problem problem = yaw(12);
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, problem.steps);
  const maneuver::ShapeCoordinates coordinates(system);
  const auto bends = [&](double angle, Steps use) {
    maneuver::NodePath path = maneuver::random_guess(system, maneuver, 1);
    for (std::size_t k = 0; k < path.rotation.size(); ++k) {
      path.rotation[k].assign(path.rotation[k].size(), Eigen::Matrix3d::Identity());
      path.position[k].setZero();
      if (k % 2 == 1) path.rotation[k][1] = lie::exp(Eigen::Vector3d(0.0, 0.0, angle));
    }
    return ShapeProgram(system, maneuver, coordinates, {}, {}, use).go_to(path);
  };
  EXPECT_TRUE(bends(1.4, Steps::faithful));
  EXPECT_TRUE(bends(1.4, Steps::rough));
  EXPECT_FALSE(bends(2.2, Steps::faithful));
  EXPECT_TRUE(bends(2.2, Steps::rough));
}

// Where bodies turn far, rough steps find the root's motion that ShapeKernel finds from the same guess.
TEST(LongTurns, of_rough_steps_are_those_of_one_step_after_the_other) {
  const maneuver::Problem problem = yaw(12);
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, problem.steps);
  const maneuver::ShapeCoordinates coordinates(system);
  maneuver::ShapeKernel kernel(system, maneuver.lagrangian, coordinates.shape);
  int far = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    maneuver::NodePath path = maneuver::random_guess(system, maneuver, seed);
    for (std::size_t k = 0; k < path.rotation.size(); ++k)  // three times the guess's turns, and a root that rests
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector3d turn = lie::log(path.rotation[0][i].transpose() * path.rotation[k][i]);
        path.rotation[k][i] = i == 0 ? Eigen::Matrix3d::Identity() : lie::exp(3.0 * turn);
        path.position[k].setZero();
      }
    std::vector<mechanics::Rotations> rotation = path.rotation;
    bool found = true;
    for (std::size_t k = 0; found && k + 1 < rotation.size(); ++k) {
      maneuver::ShapeStep step(system);
      found = kernel.solve(maneuver.time_step(), rotation[k], path.rotation[k + 1], step);
      rotation[k + 1] = step.interval.next_rotation;
    }
    ShapeProgram program(system, maneuver, coordinates, {}, {}, Steps::rough);
    ASSERT_EQ(program.go_to(path), found) << seed;
    if (!found) continue;
    for (std::size_t k = 0; k < rotation.size(); ++k)
      for (std::size_t i = 0; i < rotation[k].size(); ++i)
        EXPECT_LE((program.path().rotation[k][i] - rotation[k][i]).norm(), 1e-9) << seed << ' ' << k << ' ' << i;
    far += largest_turn(rotation) > 0.5 * std::numbers::pi ? 1 : 0;
  }
  EXPECT_GE(far, 10);
}

}  // namespace
}  // namespace lamprey::tests
