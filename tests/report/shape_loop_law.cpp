// The loop of shapes of a report: what its volumes foretell is what the swimmer moved.
#include "report/shape_loop.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "file/problem_file.hpp"
#include "report/page_data.hpp"
#include "task/tasks.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using Eigen::Vector3d;
using Angles = std::vector<Vector3d>;

constexpr double rate = 2.0 * M_PI;  // rad/s: once round in the file's second

result::Results swum(const std::function<Angles(double)>& angles, const Vector3d& spin = Vector3d::Zero()) {
  file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/three_links.toml");
  problem.problem.start.angular_velocity.assign(3, spin);
  task::MarchOptions options;
  options.angle = angles;
  return task::march_task(problem, options, "test");
}

Angles round(double t) {
  return {Vector3d(0.3 + 0.9 * std::cos(rate * t), 0, 0), Vector3d(-0.2 + 0.8 * std::sin(rate * t), 0, 0)};
}

TEST(ShapeLoop, foretells_what_the_swimmer_moved) {
  const result::Results results = swum(&round);
  ASSERT_EQ(results.solution.status, maneuver::Status::simulated) << results.solution.message;
  const std::optional<report::ShapeLoop> loop = report::shape_loop(results);
  ASSERT_TRUE(loop && loop->displacement);
  EXPECT_EQ(loop->variable[0], "head");
  EXPECT_EQ(loop->variable[1], "tail");
  EXPECT_FALSE(loop->modes);
  EXPECT_EQ(loop->heights.normal, 2);
  const auto& [by_volume, moved] = *loop->displacement;
  EXPECT_GT(moved.head<2>().norm(), 0.01);
  EXPECT_LE((by_volume - moved).norm(), 2e-3 * moved.norm()) << by_volume.transpose() << " | " << moved.transpose();
}

TEST(ShapeLoop, of_the_forward_gait_foretells_its_two_metres) {
  const file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/gait.toml");
  search::SolveOptions options;
  options.refinement = false;
  const std::optional<report::ShapeLoop> loop = report::shape_loop(task::solve_task(problem, options, "test"));
  ASSERT_TRUE(loop && loop->displacement);
  EXPECT_NEAR(loop->displacement->by_volume[0], 1.999, 1e-3);
  EXPECT_NEAR(loop->displacement->moved[0], 2.0, 1e-3);
}

TEST(ShapeLoop, counts_no_displacement_where_the_shape_stays_open_or_momentum_carries_on) {
  const std::optional<report::ShapeLoop> open = report::shape_loop(swum([](double t) { return round(0.7 * t); }));
  ASSERT_TRUE(open);
  EXPECT_FALSE(open->displacement);
  EXPECT_EQ(open->lacking, "the shape does not end as it began");
  const std::optional<report::ShapeLoop> spinning = report::shape_loop(swum(&round, Vector3d(0, 0, 0.5)));
  ASSERT_TRUE(spinning);
  EXPECT_FALSE(spinning->displacement);
  EXPECT_EQ(spinning->lacking, "total momentum carries the swimmer on");
}

TEST(ShapeLoop, is_of_two_angles_at_least) {
  EXPECT_FALSE(report::shape_loop(swum([](double t) {
    Angles angles = round(t);
    angles[1].setZero();
    return angles;
  })));
  // nor does one count that is bent and stays so, but as where the others move
  EXPECT_FALSE(report::shape_loop(swum([](double t) { return Angles{round(t)[0], Vector3d(0.5, 0, 0)}; })));
  result::Results results = swum(&round);
  results.solution.joint_angle.clear();  // as of a file without
  EXPECT_FALSE(report::shape_loop(results));
}

// Wherever the swimmer lies and however it is headed at first.
TEST(ShapeLoop, is_seen_from_the_swimmer) {
  const std::optional<report::ShapeLoop> plain = report::shape_loop(swum(&round));
  file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/three_links.toml");
  problem.problem.start.position = Vector3d(3.0, -2.0, 1.0);
  problem.problem.start.rotation.assign(3, Vector3d(0.4, -1.1, 2.0));
  task::MarchOptions options;
  options.angle = &round;
  const std::optional<report::ShapeLoop> turned = report::shape_loop(task::march_task(problem, options, "test"));
  ASSERT_TRUE(plain && turned && plain->displacement && turned->displacement);
  EXPECT_LE((plain->displacement->moved - turned->displacement->moved).norm(), 1e-9);
}

// Of many loops there is a sum of volumes, and no twist once the root has turned by half a turn or more, also by more than one.
TEST(ShapeLoop, has_no_twist_of_far_turns) {
  file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/three_links.toml");
  problem.problem.steps = 60;
  const auto cycles = [&](int count) {
    task::MarchOptions options;
    result::AngleSamples samples;
    for (int k = 0; k <= 60; ++k) {
      samples.time.push_back(k / 60.0);
      samples.angle.push_back({Vector3d(1.5 + 0.9 * std::cos(rate * k / 60.0), 0, 0),
                               Vector3d(-1.5 + 0.9 * std::sin(rate * k / 60.0), 0, 0)});
    }
    options.angles = samples;
    options.cycles = count;
    return report::shape_loop(task::march_task(problem, options, "test"));
  };
  const auto once = cycles(1), thrice = cycles(3);
  ASSERT_TRUE(once && thrice && once->displacement && thrice->displacement);
  EXPECT_LE((3.0 * once->displacement->by_volume - thrice->displacement->by_volume).norm(), 1e-9);
  const double turn = std::abs(once->displacement->moved[2]);
  EXPECT_GT(turn, 0.1);
  EXPECT_NEAR(std::abs(thrice->displacement->moved[2]), 3.0 * turn, 1e-9);
  const auto far = cycles(static_cast<int>(std::ceil(1.4 * M_PI / turn)));
  ASSERT_TRUE(far);
  EXPECT_EQ(far->lacking, "the swimmer turns too far for one twist");
}

// Angles beyond all sense, or none, are no picture.
TEST(ShapeLoop, is_none_of_numbers_without_sense) {
  result::Results results = swum(&round);
  for (const double number : {1e16, 1e300, std::nan("")}) {
    result::Results broken = results;
    for (auto& node : broken.solution.joint_angle) node[0][0] += number;
    EXPECT_FALSE(report::shape_loop(broken)) << number;
  }
  for (auto& node : results.solution.joint_angle) node[0] = Vector3d(0, 0, node[0][0]);  // where a hinge has no angle
  EXPECT_FALSE(report::shape_loop(results));
}

// What it moved is said alike wherever in the loop it began.
TEST(ShapeLoop, does_not_depend_on_where_it_begins) {
  const std::optional<report::ShapeLoop> loop = report::shape_loop(swum(&round));
  const std::optional<report::ShapeLoop> later = report::shape_loop(swum([](double t) { return round(t + 0.3); }));
  ASSERT_TRUE(loop && later && loop->displacement && later->displacement);
  EXPECT_LE((loop->displacement->moved - later->displacement->moved).norm(), 1e-3 * loop->displacement->moved.norm());
}

// Angles of a joint that turns right round are stored within half a turn.
TEST(ShapeLoop, goes_on_over_whole_turns) {
  const result::Results results = swum([](double t) {
    return Angles{Vector3d(2.9 + 0.5 * std::cos(rate * t), 0, 0), Vector3d(0.5 * std::sin(rate * t), 0, 0)};
  });
  ASSERT_EQ(results.solution.status, maneuver::Status::simulated) << results.solution.message;
  result::Results wrapped = results;
  for (auto& node : wrapped.solution.joint_angle) node[0][0] = std::remainder(node[0][0], 2.0 * M_PI);
  const std::optional<report::ShapeLoop> loop = report::shape_loop(results), same = report::shape_loop(wrapped);
  ASSERT_TRUE(loop && same && loop->displacement && same->displacement);
  EXPECT_LE((loop->displacement->by_volume - same->displacement->by_volume).norm(), 1e-12);
  EXPECT_LE((loop->displacement->by_volume - loop->displacement->moved).norm(),
            2e-3 * loop->displacement->moved.norm());
}

// A hinge that goes once right round ends where it began, but the loop of shapes goes round no area.
TEST(ShapeLoop, that_goes_right_round_bounds_no_area) {
  const auto once = [](double t) { return Angles{Vector3d(rate * t, 0, 0), Vector3d(0.5 * std::sin(rate * t), 0, 0)}; };
  const std::optional<report::ShapeLoop> whole = report::shape_loop(swum(once));
  ASSERT_TRUE(whole);
  EXPECT_FALSE(whole->displacement);
  EXPECT_EQ(whole->lacking, "the shape ends as it began, but head goes right round, and such a loop bounds no area");
  const std::optional<report::ShapeLoop> part =
      report::shape_loop(swum([&](double t) { return once(0.9 * t); }));  // the tail's angle is another at the end
  ASSERT_TRUE(part);
  EXPECT_EQ(part->lacking, "the shape does not end as it began");
}

TEST(ShapeLoop, stands_in_the_page_row_by_row_of_the_first_variable) {
  const result::Results results = swum(&round);
  const std::optional<report::ShapeLoop> loop = report::shape_loop(results);
  const auto heights = nlohmann::json::parse(report::page_data({&results}))["runs"][0]["heights"];
  ASSERT_TRUE(loop);
  const auto n = static_cast<Eigen::Index>(loop->heights.at[0].size());
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_EQ(heights["height"][k].size(), static_cast<std::size_t>(n * n));
    for (const auto& [i, j] :
         {std::pair(Eigen::Index{2}, Eigen::Index{11}), std::pair(Eigen::Index{20}, Eigen::Index{5})})
      EXPECT_NEAR(heights["height"][k][static_cast<std::size_t>(i * n + j)].get<double>(),
                  loop->heights.height[k](i, j), 1e-6 * loop->heights.height[k].cwiseAbs().maxCoeff());
  }
  EXPECT_NEAR(heights["at"][0][3].get<double>(), loop->heights.at[0][3], 1e-6);
  EXPECT_NEAR(heights["run"][1][7].get<double>(), loop->run[1][7], 1e-6);
  EXPECT_NEAR(heights["by_volume"][0].get<double>(), loop->displacement->by_volume[0], 1e-6);
  EXPECT_EQ(heights["variable"][1], "tail");
}

}  // namespace
}  // namespace lamprey
