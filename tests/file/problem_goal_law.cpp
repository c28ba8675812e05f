// What a goal states of joints and shapes is what is asked of the swimmer's end.
#include <algorithm>

#include <gtest/gtest.h>

#include "file/legged.hpp"
#include "file/problem_file.hpp"
#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/tree_motion.hpp"
#include "model/input_error.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::string bent_start =
    "rotation.hull = [0.2, -0.4, 1.0]\nangle.tip = -0.6\nangle.arm = [0.5, -0.8]\nangle.hip = 1.1\n";

struct AskedEnd {
  maneuver::Problem problem;
  model::System system;
  maneuver::Maneuver maneuver;

  explicit AskedEnd(const std::string& goal)
      : problem(file::parse_problem(legged(bent_start, "[goal]\n" + goal), "legged.toml").problem),
        system(problem.swimmer),
        maneuver(maneuver::make_maneuver(system, problem, problem.steps)) {}

  std::optional<Vector3d> angles(const std::string& name) const {
    for (int j = 0; j < system.joint_count(); ++j)
      if (system.joint(j).name == name)
        if (const auto end = joint_at_end(system, maneuver, j)) return mechanics::joint_angles(system.joint(j), *end);
    return std::nullopt;
  }
  long attitudes() const {
    return std::count_if(maneuver.end_rotation.begin(), maneuver.end_rotation.end(),
                         [](const auto& end) { return end.has_value(); });
  }
};

TEST(ProblemGoal, of_angles_alone_leaves_other_joints_and_all_attitudes_free) {
  const AskedEnd end("angle.arm = [0.1, 0.2]\n");
  EXPECT_EQ(end.attitudes(), 0);
  EXPECT_LT((*end.angles("arm") - Vector3d(0.1, 0.2, 0.0)).norm(), 1e-14);
  EXPECT_FALSE(end.angles("hip"));
  EXPECT_FALSE(end.angles("tip"));
  EXPECT_FALSE(ends_in_first_shape(end.system, end.maneuver));
}

TEST(ProblemGoal, of_the_starts_shape_holds_all_joints_but_those_of_other_angles) {
  const AskedEnd end("shape = \"start\"\nangle.tip = 0.3\n");
  EXPECT_EQ(end.attitudes(), 0);
  EXPECT_NEAR((*end.angles("tip"))[0], 0.3, 1e-14);
  EXPECT_LT((*end.angles("arm") - Vector3d(0.5, -0.8, 0.0)).norm(), 1e-14);
  EXPECT_NEAR((*end.angles("hip"))[0], 1.1, 1e-14);
  EXPECT_FALSE(ends_in_first_shape(end.system, end.maneuver));
  const AskedEnd same("shape = \"start\"\n");
  EXPECT_TRUE(ends_in_first_shape(same.system, same.maneuver));
}

TEST(ProblemGoal, of_one_attitude_and_a_shape_tells_all_attitudes) {
  const AskedEnd end("shape = \"start\"\nangle.hip = 0.4\nrotation.tip = [0.1, 0.2, 0.3]\n");
  EXPECT_EQ(end.attitudes(), 5);
  EXPECT_NEAR((*end.angles("hip"))[0], 0.4, 1e-14);
  EXPECT_NEAR((*end.angles("tip"))[0], -0.6, 1e-14);
  EXPECT_LT((*end.maneuver.end_rotation[1] - lie::exp(Vector3d(0.1, 0.2, 0.3))).norm(), 1e-15);
}

// Bodies below a joint that ends otherwise go with it; the rest turns as a whole.
TEST(ProblemGoal, of_a_turn_and_angles_has_the_rest_keep_its_shape) {
  const AskedEnd end("turn = [0.0, 0.3, 0.0]\nangle.hip = 0.4\n");
  EXPECT_EQ(end.attitudes(), 5);
  EXPECT_LT((*end.maneuver.end_rotation[0] - lie::exp(Vector3d(0.0, 0.3, 0.0)) * end.maneuver.start.rotation[0]).norm(),
            1e-14);
  EXPECT_NEAR((*end.angles("hip"))[0], 0.4, 1e-14);
  EXPECT_NEAR((*end.angles("tip"))[0], -0.6, 1e-14);
  EXPECT_LT((*end.angles("arm") - Vector3d(0.5, -0.8, 0.0)).norm(), 1e-14);
}

TEST(ProblemGoal, refuses_shapes_beside_what_contradicts_them) {
  for (const auto& [goal, key, words] :
       {std::tuple("shape = \"start\"\nrotation.arm = \"free\"\n", "goal.shape", "with a free rotation"),
        std::tuple("shape = \"start\"\nrotation.hull = [0, 0, 0]\nrotation.tip = [0, 0, 0.1]\n", "goal.shape",
                   "rotations of more than one body"),
        std::tuple("shape = \"start\"\nturn = [0, 0, 1]\nrotation.tip = [0, 0, 0.1]\n", "goal.shape",
                   "with goal.turn and goal.rotation"),
        std::tuple("angle.hip = 0.1\nrotation.leg = [0.5, 0.0, 0.0]\n", "goal.angle.hip",
                   "it beside goal.rotation.leg"),
        std::tuple("angle.pod = 0.1\n", "goal.angle.pod", "angles of a fixed joint"),
        std::tuple("turn = [0, 0, 0.3]\nangle.hip = 0.1\nrotation.tip = [0.0, 0.0, 2.0]\n", "goal.rotation.tip",
                   "outside what the hinge joint \"tip\" allows")}) {
    try {
      file::parse_problem(legged(bent_start, std::string("[goal]\n") + goal), "legged.toml");
      ADD_FAILURE() << goal;
    } catch (const model::InputError& error) {
      EXPECT_EQ(error.key, key) << error.what();
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace lamprey::tests
