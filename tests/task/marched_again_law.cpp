// A motion marched again under its own moments is that motion, also where impulses leave no step a guide to the next.
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "model/input_error.hpp"
#include "result/controls_file.hpp"
#include "task/tasks.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

file::ProblemFile three_links() {
  file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/three_links.toml");
  problem.problem.steps = 12;
  return problem;
}

// From rest, straight, the hinges jump from node to node.
result::Results jumping(const file::ProblemFile& problem, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> jump(0.0, 0.5);
  std::vector<std::vector<Vector3d>> table{{Vector3d::Zero(), Vector3d::Zero()}};
  for (int k = 0; k < problem.problem.steps; ++k)
    table.push_back({Vector3d(jump(random), 0, 0), Vector3d(jump(random), 0, 0)});
  task::MarchOptions options;
  result::AngleSamples samples;
  for (std::size_t k = 0; k < table.size(); ++k)
    samples.time.push_back(static_cast<double>(k) * problem.problem.time_step());
  samples.angle = table;
  options.angles = samples;
  return task::march_task(problem, options, "");
}

task::MarchOptions under(const result::Results& results, const file::ProblemFile& problem) {
  task::MarchOptions options;
  options.controls = result::controls_of_results(results, "x", problem.problem.swimmer.joints);
  return options;
}

double off(const result::Results& a, const result::Results& b) {
  if (b.solution.status != maneuver::Status::simulated || a.solution.time.size() != b.solution.time.size()) return 1.0;
  double largest = 0.0;
  for (std::size_t k = 0; k < a.solution.time.size(); ++k) {
    largest = std::max(largest, (a.solution.position[k] - b.solution.position[k]).norm());
    for (std::size_t i = 0; i < 3; ++i)
      largest = std::max(largest, (a.solution.rotation[k][i] - b.solution.rotation[k][i]).norm());
  }
  return largest;
}

TEST(MarchedAgain, by_its_own_moments_is_the_same_motion) {
  file::ProblemFile problem = three_links();
  int marched = 0, lost = 0;  // without the motion
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const result::Results first = jumping(problem, seed);
    if (first.solution.status != maneuver::Status::simulated) continue;
    // the march along angles begins with their rates
    problem.problem.start.angular_velocity = first.solution.angular_velocity.front();
    problem.problem.start.linear_velocity = first.solution.rotation.front()[0] * first.solution.linear_velocity.front();
    task::MarchOptions options = under(first, problem);
    EXPECT_LE(off(first, task::march_task(problem, options, "")), 1e-9) << seed;
    options.controls->motion = {};
    lost += off(first, task::march_task(problem, options, "")) > 1e-9 ? 1 : 0;
    ++marched;
  }
  EXPECT_GE(marched, 4);
  EXPECT_GE(lost, 1) << "the moments ask for no more than any march finds";
}

TEST(MarchedAgain, takes_no_steps_from_motions_of_others) {
  const file::ProblemFile problem = three_links();
  unsigned seed = 1;
  result::Results first = jumping(problem, seed);
  while (first.solution.status != maneuver::Status::simulated && seed < 20) first = jumping(problem, ++seed);
  const auto has_motion = [&](const result::Results& results) {
    return !under(results, problem).controls->motion.position.empty();
  };
  ASSERT_TRUE(has_motion(first));
  result::Results divided = first;  // whose nodes are not a step apart
  divided.solution.divided.steps = 1;
  EXPECT_FALSE(has_motion(divided));
  result::Results reference = first;
  reference.solution.marched_by = "another integrator";
  EXPECT_FALSE(has_motion(reference));
  // one body more than the swimmer has, and other links: as without the motion
  task::MarchOptions plain = under(first, problem), larger = plain, other = plain, shorter = plain;
  plain.controls->motion = {};
  for (auto& node : larger.controls->motion.rotation) node.emplace_back(Eigen::Matrix3d::Identity());
  std::swap(other.controls->links[0], other.controls->links[1]);
  shorter.steps = 24;
  task::MarchOptions shorter_plain = shorter;
  shorter_plain.controls->motion = {};
  const auto message = [&](const task::MarchOptions& options) {
    return task::march_task(problem, options, "").solution.message;
  };
  EXPECT_EQ(message(larger), message(plain));
  EXPECT_EQ(message(other), message(plain));
  EXPECT_EQ(message(shorter), message(shorter_plain));
}

// Cycle after cycle of a gait the stored steps serve again.
TEST(MarchedAgain, goes_through_a_gait_again_and_again) {
  file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/ellipses.toml");
  problem.problem.search.starts = 1;
  search::SolveOptions options;
  options.refinement = false;
  const result::Results gait = task::solve_task(problem, options, "");
  ASSERT_EQ(gait.solution.status, maneuver::Status::optimal) << gait.solution.message;
  task::MarchOptions known = under(gait, problem);
  known.cycles = 3;
  task::MarchOptions guessed = known;
  guessed.controls->motion = {};
  const result::Results marched = task::march_task(problem, known, "");
  ASSERT_EQ(marched.solution.status, maneuver::Status::simulated) << marched.solution.message;
  EXPECT_LE(off(marched, task::march_task(problem, guessed, "")), 1e-8);
}

// A servo turns the trunk, the tail on its spring and damper goes as it goes: as under the moments that come out.
TEST(MarchedAgain, along_the_angles_of_motors_alone) {
  const file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/compliant_tail.toml");
  std::string table = "t,trunk (rad)\n";
  for (int k = 0; k <= 40; ++k) {
    const double t = 0.02 * k;
    table += fmt::format("{},{:.12f}\n", t, 0.4 * std::sin(7.0 * t) * std::sin(7.0 * t));
  }
  task::MarchOptions options;
  options.angles = result::parse_angles(table, "servo.csv", problem.problem.swimmer.joints);
  EXPECT_EQ(options.angles->passive, (std::vector<bool>{false, true}));
  options.steps = 80;
  const result::Results along = task::march_task(problem, options, "");
  ASSERT_EQ(along.solution.status, maneuver::Status::simulated) << along.solution.message;
  double bent = 0.0, tail = 0.0, trunk = 0.0;
  for (std::size_t k = 0; k < along.solution.time.size(); ++k) {
    const double t = along.solution.time[k];
    EXPECT_NEAR(along.solution.joint_angle[k][0][0], 0.4 * std::sin(7.0 * t) * std::sin(7.0 * t), 1e-4);
    bent = std::max(bent, std::abs(along.solution.joint_angle[k][1][0]));
    trunk = std::max(trunk, along.solution.control[k][0].norm());
    tail = std::max(tail, along.solution.control[k][1].norm());
  }
  EXPECT_GT(bent, 0.05);
  EXPECT_EQ(tail, 0.0);
  EXPECT_GT(trunk, 0.01);
  task::MarchOptions again = under(along, problem);
  again.controls->motion = {};
  again.steps = 80;
  again.duration = along.solution.time.back();
  EXPECT_LE(off(along, task::march_task(problem, again, "")), 1e-9);
}

TEST(MarchedAgain, asks_for_the_angles_of_motors) {
  const file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/compliant_tail.toml");
  EXPECT_THROW(result::parse_angles("t,tail\n0,0\n1,0.1\n", "x", problem.problem.swimmer.joints), model::InputError);
  const result::AngleSamples both =
      result::parse_angles("t,trunk,tail\n0,0,0\n1,0,0\n", "x", problem.problem.swimmer.joints);
  EXPECT_EQ(both.passive, (std::vector<bool>{false, false}));
}

}  // namespace
}  // namespace lamprey::tests
