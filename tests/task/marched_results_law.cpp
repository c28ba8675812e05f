// What a march has reached can be read back, however it ended and however few its nodes are.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "result/solution_file.hpp"
#include "task/tasks.hpp"

namespace lamprey::tests {
namespace {

file::ProblemFile spline_problem() {
  return file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/paper_scheme/rotation.toml");
}

void expect_read_back(const result::Results& results) {
  const std::string text = result::solution_text(results);
  const result::Results back = result::parse_solution(text, "x");
  EXPECT_EQ(result::solution_text(back), text);
  EXPECT_EQ(back.problem.steps + 1, static_cast<int>(back.solution.time.size()));
}

TEST(MarchedResults, with_fewer_nodes_than_the_splines_points_are_read_back) {
  task::MarchOptions options;
  options.steps = 5;
  const result::Results results = task::march_task(spline_problem(), options, "");
  EXPECT_EQ(results.solution.status, maneuver::Status::simulated);
  expect_read_back(results);
}

TEST(MarchedResults, of_an_interrupted_march_are_read_back) {
  for (int most : {0, 1, 7}) {
    int asked = 0;
    task::MarchOptions options;
    options.interrupted = [&] { return asked++ >= most; };
    const result::Results results = task::march_task(spline_problem(), options, "");
    EXPECT_EQ(results.solution.status, maneuver::Status::interrupted);
    expect_read_back(results);
  }
}

TEST(MarchedResults, of_a_free_duration_say_which_was_taken) {
  const file::ProblemFile problem =
      file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/free_time.toml");
  task::MarchOptions options;
  options.steps = 5;
  const auto tells = [&] {
    return task::march_task(problem, options, "").solution.message.find("The duration is free") != std::string::npos;
  };
  EXPECT_TRUE(tells());
  options.duration = 1.0;
  EXPECT_FALSE(tells());
}

// Tables of angles in degrees, or of another first shape, are asked about.
TEST(MarchedResults, of_angles_tell_far_turns_and_another_start) {
  const file::ProblemFile problem =
      file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/three_links.toml");
  const auto message = [&](double begin, double end) {
    task::MarchOptions options;
    options.steps = 40;
    options.angle = [=](double t) {
      const double s = t / 1.0;
      return std::vector<Eigen::Vector3d>(2, Eigen::Vector3d(begin + (end - begin) * s * s, 0.0, 0.0));
    };
    return task::march_task(problem, options, "").solution.message;
  };
  EXPECT_EQ(message(0.0, 0.3).find("meant in radians"), std::string::npos) << message(0.0, 0.3);
  EXPECT_EQ(message(0.0, 0.3).find("beside the problem's start"), std::string::npos) << message(0.0, 0.3);
  EXPECT_NE(message(0.0, 30.0).find("are they meant in radians?"), std::string::npos) << message(0.0, 30.0);
  EXPECT_NE(message(0.4, 0.5).find("0.4 rad beside the problem's start"), std::string::npos) << message(0.4, 0.5);
}

// Angles of a motion lead to where it goes; a shorter one, or none, ends beside the goal by as much as it says.
TEST(MarchedResults, say_how_far_beside_the_goal_they_end_and_what_they_leave_out) {
  file::ProblemFile problem = file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/yaw.toml");
  problem.problem.goal->periodic = problem.problem.start.free_shape = false;
  problem.problem.goal->rest = true;
  problem.problem.goal->turn = Eigen::Vector3d(0.0, 0.0, 0.25);
  problem.problem.goal->move = {0.3, std::nullopt, 0.4};
  task::MarchOptions options;
  const auto message = [&] { return task::march_task(problem, options, "").solution.message; };
  const auto contains = [](const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
  };
  EXPECT_TRUE(contains(message(), "It ends 0.25 rad (")) << message();
  EXPECT_TRUE(contains(message(), ") and 0.5 m beside the goal."));
  problem.problem.goal->move = {};
  EXPECT_TRUE(contains(message(), ") beside the goal.")) << message();
  const double duration = problem.problem.duration.value;
  result::ControlSamples moments;
  const std::size_t joints = problem.problem.swimmer.joints.size();
  for (const double share : {0.0, 0.5, 1.0}) {
    moments.time.push_back(share * duration);
    moments.control.emplace_back(joints, Eigen::Vector3d::Zero());
  }
  options.controls = moments;
  EXPECT_FALSE(contains(message(), "The moments go on"));
  options.controls->time.back() *= 1.5;
  EXPECT_TRUE(contains(message(), "The moments go on until")) << message();
  options.controls.reset();
  result::AngleSamples angles;
  for (const double share : {0.0, 0.2, 0.5}) {
    angles.time.push_back(share * duration);
    angles.angle.emplace_back(joints, Eigen::Vector3d::Zero());
  }
  options.angles = angles;
  EXPECT_TRUE(contains(message(), "and so does this march; the file's duration is")) << message();
  problem.problem.goal->periodic = true;
  EXPECT_FALSE(contains(message(), "beside the goal"));
}

}  // namespace
}  // namespace lamprey::tests
