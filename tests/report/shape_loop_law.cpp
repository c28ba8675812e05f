// The loop of shapes of a report: what its volumes foretell is what the swimmer moved.
#include "report/shape_loop.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "file/tasks.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using Eigen::Vector3d;
using Angles = std::vector<Vector3d>;

constexpr double rate = 2.0 * M_PI;  // rad/s: once round in the file's second

file::Results swum(const std::function<Angles(double)>& angles, const Vector3d& spin = Vector3d::Zero()) {
  file::ProblemFile problem = file::read_problem_file(LAMPREY_SOURCE_DIR "/examples/three_links.toml");
  problem.problem.start.angular_velocity.assign(3, spin);
  file::MarchOptions options;
  options.angle = angles;
  return file::march_task(problem, options, "test");
}

Angles round(double t) {
  return {Vector3d(0.3 + 0.9 * std::cos(rate * t), 0, 0), Vector3d(-0.2 + 0.8 * std::sin(rate * t), 0, 0)};
}

TEST(ShapeLoop, foretells_what_the_swimmer_moved) {
  const file::Results results = swum(&round);
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
  file::Results results = swum(&round);
  results.solution.joint_angle.clear();  // as of a file without
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
  const file::Results results = swum([](double t) {
    return Angles{Vector3d(2.9 + 0.5 * std::cos(rate * t), 0, 0), Vector3d(0.5 * std::sin(rate * t), 0, 0)};
  });
  ASSERT_EQ(results.solution.status, maneuver::Status::simulated) << results.solution.message;
  file::Results wrapped = results;
  for (auto& node : wrapped.solution.joint_angle) node[0][0] = std::remainder(node[0][0], 2.0 * M_PI);
  const std::optional<report::ShapeLoop> loop = report::shape_loop(results), same = report::shape_loop(wrapped);
  ASSERT_TRUE(loop && same && loop->displacement && same->displacement);
  EXPECT_LE((loop->displacement->by_volume - same->displacement->by_volume).norm(), 1e-12);
  EXPECT_LE((loop->displacement->by_volume - loop->displacement->moved).norm(),
            2e-3 * loop->displacement->moved.norm());
}

}  // namespace
}  // namespace lamprey
