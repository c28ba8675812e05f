// What a start states of bodies, of joint angles and of how joints turn is what the swimmer begins with.
#include <gtest/gtest.h>

#include "file/legged.hpp"
#include "file/problem_file.hpp"
#include "integrator/step.hpp"
#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/tree_motion.hpp"
#include "model/input_error.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

maneuver::Problem read(const std::string& start) { return file::parse_problem(legged(start), "legged.toml").problem; }

TEST(ProblemStart, is_at_zero_angle_where_joints_allow_nothing_else) {
  for (const char* hull : {"", "rotation.hull = [0.2, -0.4, 1.0]\n"}) {
    const maneuver::Problem problem = read(hull);
    const model::System system(problem.swimmer);
    const integrator::State start = maneuver::start_state(system, problem.start);
    for (const model::Joint& joint : system.joints()) {
      if (joint.name == "arm" && *hull == '\0') {  // which allows the world's own directions
        EXPECT_EQ(start.rotation[2], Matrix3d::Identity());
        continue;
      }
      const Matrix3d Q = mechanics::child_to_parent(start.rotation, joint);
      EXPECT_LT(mechanics::joint_angles(joint, Q).norm(), 1e-14) << joint.name;
      EXPECT_LT((Q - mechanics::joint_rotation(joint, Vector3d::Zero())).norm(), 1e-14) << joint.name;
    }
  }
  const maneuver::Problem stated = read("rotation.hull = [0.0, 0.0, 0.4]\nrotation.arm = [0.0, 0.0, 0.2]\n");
  EXPECT_EQ(stated.start.rotation[2], Vector3d(0.0, 0.0, 0.2));
}

TEST(ProblemStart, turns_joints_by_the_angles_that_it_states) {
  const maneuver::Problem problem =
      read("rotation.hull = [0.2, -0.4, 1.0]\nangle.tip = -0.6\nangle.arm = [0.5, -0.8]\nangle.hip = 1.1\n");
  const model::System system(problem.swimmer);
  const integrator::State start = maneuver::start_state(system, problem.start);
  const std::map<std::string, Vector3d> stated = {
      {"tip", {-0.6, 0.0, 0.0}}, {"arm", {0.5, -0.8, 0.0}}, {"hip", {1.1, 0.0, 0.0}}, {"pod", Vector3d::Zero()}};
  for (const model::Joint& joint : system.joints())
    EXPECT_LT(
        (mechanics::joint_angles(joint, mechanics::child_to_parent(start.rotation, joint)) - stated.at(joint.name))
            .norm(),
        1e-14)
        << joint.name;
}

TEST(ProblemStart, has_joints_turn_while_the_whole_has_no_momentum) {
  const std::string turning = "angle.arm = [0.5, -0.8]\nangular_velocity.leg = [0.0, 0.0, 2.0]\n";
  const maneuver::Problem moving = read(turning), balanced = read(turning + "zero_momentum = true\n");
  const model::System system(moving.swimmer);
  EXPECT_TRUE(maneuver::has_momentum(system, moving.start));
  EXPECT_FALSE(maneuver::has_momentum(system, balanced.start));
  const auto rate = [&](const maneuver::Problem& problem, std::size_t parent, std::size_t child) {
    const Matrix3d Q = lie::exp(problem.start.rotation[parent]).transpose() * lie::exp(problem.start.rotation[child]);
    return Vector3d(problem.start.angular_velocity[child] - Q.transpose() * problem.start.angular_velocity[parent]);
  };
  for (const auto& [parent, child] : {std::pair(0, 3), std::pair(3, 1), std::pair(0, 2), std::pair(0, 4)})
    EXPECT_LT((rate(moving, model::at(parent), model::at(child)) - rate(balanced, model::at(parent), model::at(child)))
                  .norm(),
              1e-13);
  EXPECT_GT(rate(balanced, 0, 3).norm(), 1.9);
}

TEST(ProblemStart, turns_joints_at_the_rates_that_it_states) {
  const std::string bent = "rotation.hull = [0.2, -0.4, 1.0]\nangle.tip = -0.6\nangle.arm = [0.5, -0.8]\n";
  const maneuver::Problem problem = read(bent +
                                         "angular_velocity.hull = [0.3, 0.1, -0.2]\nangle_rate.arm = [0.7, -1.1]\n"
                                         "angle_rate.tip = 2.0\n");
  const model::System system(problem.swimmer);
  const std::map<std::string, Vector3d> stated = {{"tip", {2.0, 0.0, 0.0}}, {"arm", {0.7, -1.1, 0.0}}};
  constexpr double step = 1e-4;
  for (const model::Joint& joint : system.joints()) {
    const auto angles_at = [&](double t) {
      const auto turned = [&](int body) {
        const std::size_t i = model::at(body);
        return Matrix3d(lie::exp(problem.start.rotation[i]) * lie::exp(t * problem.start.angular_velocity[i]));
      };
      return mechanics::joint_angles(joint, turned(joint.parent).transpose() * turned(joint.child));
    };
    const auto own = stated.find(joint.name);
    const Vector3d expected = own != stated.end() ? own->second : Vector3d(Vector3d::Zero());
    EXPECT_LT(((angles_at(step) - angles_at(-step)) / (2.0 * step) - expected).norm(), 1e-6) << joint.name;
  }
}

TEST(ProblemStart, refuses_what_it_states_twice_or_of_other_joints) {
  for (const auto& [start, key, words] :
       {std::tuple("angle.hip = 0.1\nrotation.leg = [0.5, 0.0, 0.0]\n", "start.angle.hip",
                   "it beside start.rotation.leg"),
        std::tuple("angle.arm = 0.1\n", "start.angle.arm", "two numbers"),
        std::tuple("angle.pod = 0.1\n", "start.angle.pod", "angles of a fixed joint"),
        std::tuple("angle_rate.hip = 0.1\nangular_velocity.leg = [0.0, 0.0, 0.1]\n", "start.angle_rate.hip",
                   "it beside start.angular_velocity.leg"),
        std::tuple("angle_rate.pod = 0.1\n", "start.angle_rate.pod", "about the axes of a fixed joint"),
        std::tuple("angle.leg = 0.1\n", "start.angle.leg", "found"),
        std::tuple("angle.hip = 90.0\n", "start.angle.hip", "rad"),
        std::tuple("linear_velocity = [1.0, 0.0, 0.0]\nzero_momentum = true\n", "start.linear_velocity",
                   "beside zero_momentum")}) {
    try {
      read(start);
      ADD_FAILURE() << start;
    } catch (const model::InputError& error) {
      EXPECT_EQ(error.key, key);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
      EXPECT_GT(error.line, 0);
    }
  }
}

}  // namespace
}  // namespace lamprey::tests
