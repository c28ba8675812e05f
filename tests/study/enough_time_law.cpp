// In what time a motion would do that its motors are too weak or too slow for.
#include "study/enough_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "file/problem_file.hpp"
#include "search/solve.hpp"
#include "search/solver.hpp"

namespace lamprey::tests {
namespace {

struct Turned {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/yaw.toml");
  model::System system{problem.swimmer};
  maneuver::Solution solution;
  Turned() {
    problem.steps = 60;
    problem.search.starts = 1;
    solution = search::solve(system, problem, search::SolveOptions()).front();
    EXPECT_EQ(solution.status, maneuver::Status::optimal) << solution.message;
  }
  double duration() const { return solution.time.back(); }
};

double largest_moment(const maneuver::Solution& solution) {
  double largest = 0.0;
  for (const auto& moments : solution.control)
    for (const Eigen::Vector3d& moment : moments) largest = std::max(largest, moment.norm());
  return largest;
}

// The motion of least effort is the same in any time: so is what it asks for in the time that is enough.
TEST(EnoughTime, is_that_in_which_moments_come_down_to_their_limit) {
  Turned turned;
  const double limit = 0.3 * largest_moment(turned.solution);
  search::Solver solver(turned.system, turned.problem, turned.solution);
  turned.problem.limits.torque = limit;
  const auto enough = study::enough_time(turned.system, turned.problem, turned.solution);
  ASSERT_TRUE(enough);
  EXPECT_NEAR(*enough, turned.duration() / std::sqrt(0.3), 1e-9 * turned.duration());
  solver.set_duration(*enough);
  ASSERT_EQ(solver.solve().termination, optimizer::Termination::converged);
  EXPECT_NEAR(largest_moment(solver.solution()), limit, 1e-6 * limit);
}

TEST(EnoughTime, is_that_in_which_rates_come_down_to_their_limit) {
  Turned turned;
  turned.problem.limits.angular_velocity = 1e-3;  // rad/s
  const auto slow = study::enough_time(turned.system, turned.problem, turned.solution);
  turned.problem.limits.angular_velocity = 1e-4;
  const auto slower = study::enough_time(turned.system, turned.problem, turned.solution);
  ASSERT_TRUE(slow && slower);
  EXPECT_NEAR(*slower / *slow, 10.0, 1e-9);
  search::Solver solver(turned.system, turned.problem, turned.solution);
  turned.problem.limits.angular_velocity.reset();
  solver.set_duration(*slow);
  ASSERT_EQ(solver.solve().termination, optimizer::Termination::converged);
  turned.problem.limits.angular_velocity = 1.001e-3;
  EXPECT_FALSE(study::enough_time(turned.system, turned.problem, solver.solution())) << "kept already";
}

TEST(EnoughTime, is_none_where_time_does_not_help) {
  Turned turned;
  EXPECT_FALSE(study::enough_time(turned.system, turned.problem, turned.solution)) << "nothing is limited";
  turned.problem.limits.torque = 0.3 * largest_moment(turned.solution);
  ASSERT_TRUE(study::enough_time(turned.system, turned.problem, turned.solution));
  const auto expect_none = [&](const maneuver::Problem& problem, const char* why) {
    EXPECT_FALSE(study::enough_time(model::System(problem.swimmer), problem, turned.solution)) << why;
  };
  maneuver::Problem other = turned.problem;
  other.limits.swing["front"] = 1e-2;
  expect_none(other, "a joint swings too far at any speed");
  EXPECT_TRUE(study::enough_time(turned.system, other, turned.solution, true)) << "roughly";
  other = turned.problem;
  other.swimmer.joints.front().damping = 1.0;
  expect_none(other, "a damper has a time of its own");
  other = turned.problem;
  other.start.linear_velocity[0] = 1.0;
  expect_none(other, "it drifts meanwhile");
}

}  // namespace
}  // namespace lamprey::tests
