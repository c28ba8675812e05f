// On grids that answer no body turns by more than a quarter in one step, however far the search would like it to.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "file/problem_file.hpp"
#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "search/method.hpp"
#include "shape/shape_program.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using shape::ShapeProgram;
using shape::Steps;

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

maneuver::Problem whipping_tail(int steps) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/whipping_tail.toml");
  problem.steps = steps;
  return problem;
}

struct Whipping {
  maneuver::Problem problem;
  model::System system;
  search::SolveOptions options;
  search::Budget budget;
  std::unique_ptr<search::Method> method;
  explicit Whipping(int steps)
      : problem(whipping_tail(steps)),
        system(problem.swimmer),
        budget(problem, options),
        method(search::newton_method(system, problem, options, budget)) {}
};

// Where no answer is found but such turns, one is found that keeps joints from them, and its reason says by what limit.
TEST(LongTurns, give_way_to_an_answer_of_slower_joints) {
  const Whipping whipping(100);
  const search::Found found = whipping.method->solve_starts(0, 1).front();
  ASSERT_TRUE(found.joint_rate);
  EXPECT_EQ(found.outcome.termination, optimizer::Termination::feasible);
  EXPECT_LE(largest_turn(found.path.rotation), 1.2 * *found.joint_rate * found.duration / 100);
  EXPECT_NE(found.outcome.reason.find("limits.angular_velocity = " + std::to_string(std::lround(*found.joint_rate))),
            std::string::npos)
      << found.outcome.reason;
  maneuver::Problem slow = whipping.problem;
  slow.limits.angular_velocity = found.joint_rate;
  slow.search.starts = 1;
  search::SolveOptions options;
  options.refinement = false;
  options.first = search::FirstMotion{found.path, found.duration, found.limit_multipliers, {}};
  const study::Answer answer = study::answer(whipping.system, slow, options);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_NEAR(answer.solution.cost, found.cost, 1e-6 * found.cost);
}

// More steps show what these keep from: their answer is one without that limit.
TEST(LongTurns, of_slower_joints_lead_to_an_answer_on_more_steps) {
  const search::Found slow = Whipping(100).method->solve_starts(0, 1).front();
  ASSERT_TRUE(slow.joint_rate);
  const search::Found found = Whipping(300).method->refine({&slow}).front();
  EXPECT_TRUE(found.converged()) << found.outcome.reason;
  EXPECT_FALSE(found.joint_rate);
  EXPECT_LT(largest_turn(found.path.rotation), 1.5);
}

// The front body's joint bends back and forth by a given angle.
TEST(LongTurns, are_motions_of_rough_steps_alone) {
  const maneuver::Problem problem = yaw(12);
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, problem.steps);
  const maneuver::ShapeCoordinates coordinates(system);
  const auto bends = [&](double angle, Steps use) {
    maneuver::NodePath path = guess::random_guess(system, maneuver, 1);
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
  shape::ShapeKernel kernel(system, maneuver.lagrangian, coordinates.shape);
  int far = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    maneuver::NodePath path = guess::random_guess(system, maneuver, seed);
    for (std::size_t k = 0; k < path.rotation.size(); ++k)  // three times the guess's turns, and a root that rests
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector3d turn = lie::log(path.rotation[0][i].transpose() * path.rotation[k][i]);
        path.rotation[k][i] = i == 0 ? Eigen::Matrix3d::Identity() : lie::exp(3.0 * turn);
        path.position[k].setZero();
      }
    std::vector<mechanics::Rotations> rotation = path.rotation;
    bool found = true;
    for (std::size_t k = 0; found && k + 1 < rotation.size(); ++k) {
      shape::ShapeStep step(system);
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
