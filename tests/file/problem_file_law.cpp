#include <gtest/gtest.h>

#include <filesystem>

#include "document/text_file.hpp"
#include "file/problem_file.hpp"
#include "file/samples.hpp"

namespace lamprey {
namespace {

using Eigen::Vector3d;
using maneuver::Problem;

const Problem& every_key() {
  static const Problem problem = file::read_problem(tests::folder_of_tests() + "valid.toml");
  return problem;
}

// Exact: each number of the file is a decimal that both sides round alike.
void expect_vector(const Vector3d& found, double x, double y, double z) { EXPECT_EQ(found, Vector3d(x, y, z)); }

TEST(ProblemFile, head_and_bodies_hold_the_numbers_of_the_file) {
  const Problem& problem = every_key();
  EXPECT_EQ(problem.name, "Every key");
  EXPECT_EQ(problem.source, "made up");
  EXPECT_EQ(problem.swimmer.density, 0.01);
  ASSERT_EQ(problem.swimmer.bodies.size(), 4U);
  const model::BodyDescription& middle = problem.swimmer.bodies[0];
  EXPECT_EQ(middle.name, "middle");
  expect_vector(middle.semi_axes, 8.0, 1.5, 2.0);
  EXPECT_EQ(middle.mass, 1.0);
  EXPECT_EQ(*middle.body_inertia, Eigen::Matrix3d(Vector3d(1.25, 13.6, 13.25).asDiagonal()));
  EXPECT_EQ(*middle.mass_matrix, Eigen::Matrix3d(Vector3d(1.0659, 2.1696, 1.6641).asDiagonal()));
  Eigen::Matrix3d inertia;
  inertia << 1.3480, 0.1, 0.0, 0.1, 20.15, 0.2, 0.0, 0.2, 25.3276;
  EXPECT_EQ(*middle.inertia_matrix, inertia);
  Eigen::Matrix3d coupling;
  coupling << 0.0, 0.1, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0, -0.3;
  EXPECT_EQ(*middle.coupling_matrix, coupling);
  const model::BodyDescription& back = problem.swimmer.bodies[2];
  expect_vector(back.semi_axes, 5.0, 0.8, 1.5);
  EXPECT_FALSE(back.mass || back.body_inertia || back.mass_matrix || back.inertia_matrix);
}

TEST(ProblemFile, joints_hold_the_numbers_of_the_file) {
  const auto& joints = every_key().swimmer.joints;
  ASSERT_EQ(joints.size(), 3U);
  EXPECT_EQ(joints[0].name, "neck");
  EXPECT_EQ(joints[0].kind, model::JointKind::ball);
  EXPECT_EQ(joints[0].parent, "middle");
  EXPECT_EQ(joints[0].child, "front");
  expect_vector(joints[0].parent_offset, 8.8, 0.0, 0.0);
  expect_vector(joints[0].child_offset, -5.5, 0.0, 0.0);
  expect_vector(joints[0].reference_rotation, 0.0, 0.0, 0.1);
  ASSERT_EQ(joints[0].control_axes->size(), 2U);
  expect_vector((*joints[0].control_axes)[1], 0.0, 1.0, 1.0);
  EXPECT_EQ(joints[0].stiffness, 2.0);
  EXPECT_EQ(joints[0].damping, 0.5);
  EXPECT_TRUE(joints[0].actuated);
  EXPECT_EQ(joints[1].name, "back");
  EXPECT_EQ(joints[1].kind, model::JointKind::hinge);
  expect_vector(*joints[1].axis, 0.0, 0.0, 2.0);
  EXPECT_FALSE(joints[1].actuated);
  EXPECT_EQ(joints[2].kind, model::JointKind::universal);
  expect_vector((*joints[2].axes)[0], 0.0, 0.0, 1.0);
  expect_vector((*joints[2].axes)[1], 0.0, 1.0, 0.0);
}

TEST(ProblemFile, start_and_goal_hold_the_numbers_of_the_file) {
  const Problem& problem = every_key();
  expect_vector(problem.start.position, 1.0, 2.0, 3.0);
  ASSERT_EQ(problem.start.rotation.size(), 4U);
  expect_vector(problem.start.rotation[0], 0.0, 0.0, 0.25);
  expect_vector(problem.start.rotation[1], 0.0, 0.0, 0.0);
  expect_vector(problem.start.rotation[3], 0.0, 0.0, 0.75);
  ASSERT_EQ(problem.start.angular_velocity.size(), 4U);
  expect_vector(problem.start.angular_velocity[1], 0.1, 0.2, 0.3);
  expect_vector(problem.start.angular_velocity[0], 0.0, 0.0, 0.5);
  expect_vector(problem.start.angular_velocity[2], 0.0, 0.0, 0.75);
  expect_vector(problem.start.linear_velocity, 0.5, 0.0, 0.0);
  EXPECT_TRUE(problem.start.free_shape);
  ASSERT_TRUE(problem.goal);
  EXPECT_EQ(problem.goal->move[0], 2.0);
  EXPECT_FALSE(problem.goal->move[1]);
  EXPECT_EQ(problem.goal->move[2], -1.0);
  expect_vector(*problem.goal->turn, 0.0, 0.0, 0.5);
  ASSERT_EQ(problem.goal->rotation.size(), 2U);
  expect_vector(*problem.goal->rotation.at("middle"), 0.0, 0.0, 0.75);
  EXPECT_FALSE(problem.goal->rotation.at("front"));
  EXPECT_FALSE(problem.goal->rest);
  EXPECT_TRUE(problem.goal->periodic);
}

TEST(ProblemFile, the_other_sections_hold_the_numbers_of_the_file) {
  const Problem& problem = every_key();
  EXPECT_TRUE(problem.duration.free);
  EXPECT_EQ(problem.duration.min, 0.5);
  EXPECT_EQ(problem.duration.max, 2.5);
  EXPECT_EQ(problem.duration.value, 1.5);
  EXPECT_EQ(problem.steps, 100);
  EXPECT_EQ(problem.effort, 0.5);
  EXPECT_EQ(problem.rule, maneuver::CostRule::rectangle);
  EXPECT_EQ(problem.control, maneuver::ControlKind::spline);
  EXPECT_EQ(problem.points, 21);
  EXPECT_EQ(problem.scheme, maneuver::Scheme::midpoint);
  EXPECT_FALSE(problem.limits.torque);
  EXPECT_EQ(problem.limits.joint_torque.at("neck"), 1500.0);
  EXPECT_EQ(problem.limits.swing.at("neck"), 1.0);
  EXPECT_EQ(problem.limits.twist.at("neck"), 0.5);
  EXPECT_EQ(problem.limits.angle.at("back"), (maneuver::AngleBounds{{-0.5, 1.5}}));
  EXPECT_EQ(problem.limits.angle.at("tail"), (maneuver::AngleBounds{{-0.4, 0.4}, {-1.0, 0.5}}));
  EXPECT_EQ(problem.limits.clearance, 0.1);
  EXPECT_EQ(problem.limits.torque_component, 900.0);
  EXPECT_EQ(problem.limits.joint_angular_velocity.at("back"), 12.0);
  EXPECT_EQ(problem.limits.joint_angular_velocity_component.at("back"), 11.0);
  EXPECT_EQ(problem.limits.joint_angular_velocity_component.at("tail"), 9.0);
  ASSERT_EQ(problem.limits.spheres.size(), 1U);
  EXPECT_EQ(problem.limits.spheres[0].centre, Vector3d(4.0, 3.0, -1.0));
  EXPECT_EQ(problem.limits.spheres[0].radius, 0.75);
  ASSERT_EQ(problem.limits.half_spaces.size(), 1U);
  EXPECT_EQ(problem.limits.half_spaces[0].point, Vector3d(0.0, 0.0, -5.0));
  EXPECT_LT((problem.limits.half_spaces[0].normal - Vector3d(0.0, 0.5, 2.0).normalized()).norm(), 1e-15);
  EXPECT_EQ(problem.time_weight, 12.5);
  EXPECT_EQ(problem.cost_weights.work, 2.5);
  EXPECT_EQ(problem.cost_weights.power, 0.25);
  EXPECT_EQ(problem.cost_weights.smoothness, 0.125);
  EXPECT_EQ(problem.cost_weights.angular_velocity, 1.25);
  EXPECT_EQ(problem.cost_weights.transport, 3.5);
  EXPECT_EQ(problem.cost_weights.displacement, Vector3d(0.0, 1.5, 0.0));
  EXPECT_EQ(problem.search.starts, 16);
  EXPECT_EQ(problem.search.keep, 3);
  EXPECT_EQ(problem.search.seed, 7U);
  EXPECT_EQ(problem.search.method, maneuver::SearchMethod::shooting);
  EXPECT_EQ(problem.search.tolerance, 1e-7);
  EXPECT_EQ(problem.search.time_limit, 60.0);
}

TEST(ProblemFile, what_is_left_out_has_the_defaults_of_the_format) {
  const std::string text =
      "schema = 1\n[fluid]\ndensity = 1\n[[body]]\nname = \"a\"\nsemi_axes = [1, 2, 3]\n"
      "[[body]]\nname = \"b\"\nsemi_axes = [1, 2, 3]\n"
      "[[joint]]\nparent = \"a\"\nchild = \"b\"\nparent_offset = [1, 0, 0]\nchild_offset = [-1, 0, 0]\n"
      "[goal]\nmove = [1, \"free\", \"free\"]\n[time]\nduration = 2\nsteps = 10\n";
  const Problem problem = file::parse_problem(text, "some/where/swim.toml").problem;
  EXPECT_EQ(problem.name, "swim");
  EXPECT_EQ(problem.swimmer.joints[0].name, "b");
  EXPECT_EQ(problem.swimmer.joints[0].kind, model::JointKind::ball);
  EXPECT_TRUE(problem.swimmer.joints[0].actuated);
  EXPECT_FALSE(problem.swimmer.joints[0].control_axes);
  ASSERT_EQ(problem.start.rotation.size(), 2U);
  for (const Vector3d& v : {problem.start.rotation[1], problem.start.angular_velocity[1], problem.start.linear_velocity,
                            problem.start.position})
    expect_vector(v, 0.0, 0.0, 0.0);
  EXPECT_TRUE(problem.goal->rest);
  EXPECT_FALSE(problem.goal->periodic || problem.goal->turn || problem.goal->move[1]);
  EXPECT_FALSE(problem.duration.free);
  EXPECT_EQ(problem.time_step(), 0.2);
  EXPECT_EQ(problem.effort, 1.0);
  EXPECT_EQ(problem.cost_rule(), maneuver::CostRule::trapezoid);
  EXPECT_EQ(problem.control, maneuver::ControlKind::steps);
  EXPECT_EQ(problem.scheme, maneuver::Scheme::trapezoid);
  EXPECT_FALSE(problem.limits.any());
  EXPECT_EQ(problem.search.starts, 1);
  EXPECT_EQ(problem.search.seed, 1U);
  EXPECT_EQ(problem.search.tolerance, 1e-8);
  EXPECT_FALSE(problem.search.time_limit);
  EXPECT_FALSE(
      file::parse_problem(text.substr(0, text.find("[goal]")) + text.substr(text.find("[time]")), "x").problem.goal);
}

TEST(ProblemFile, a_file_with_byte_order_mark_and_carriage_returns_reads_the_same) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : tests::bytes_of(tests::folder_of_tests() + "valid.toml"))
    text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const auto file = file::parse_problem(text, "x");
  EXPECT_EQ(file.problem.steps, every_key().steps);
  EXPECT_EQ(file.positions.at("fluid.density").line, 7);
}

TEST(ProblemFile, a_free_turn_may_be_written_or_left_out) {
  std::string text = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  const std::string turn = "turn = [0.0, 0.0, 0.5]";
  text.replace(text.find(turn), turn.size(), "turn = \"free\"");
  EXPECT_FALSE(file::parse_problem(text, "x").problem.goal->turn);
  const std::string own = tests::bytes_of(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  const std::string waypoint = "[[waypoint]]\ntime = 0.5\nmove = [0.1, \"free\", \"free\"]\nturn = \"free\"\n";
  const Problem passing = file::parse_problem(own + waypoint, "x").problem;
  ASSERT_EQ(passing.waypoints.size(), 1U);
  EXPECT_FALSE(passing.waypoints.front().turn);
}

TEST(ProblemFile, a_chain_of_a_thousand_bodies_is_read_whatever_the_order_of_its_joints) {
  std::string text = "schema = 1\n[fluid]\ndensity = 1\n[time]\nduration = 1\nsteps = 1\n";
  for (int i = 0; i < 1000; ++i) text += "[[body]]\nname = \"b" + std::to_string(i) + "\"\nsemi_axes = [1, 1, 1]\n";
  for (int i = 999; i > 0; --i)
    text += "[[joint]]\nparent = \"b" + std::to_string(i - 1) + "\"\nchild = \"b" + std::to_string(i) +
            "\"\nparent_offset = [1, 0, 0]\nchild_offset = [-1, 0, 0]\n";
  EXPECT_EQ(file::parse_problem(text, "x").problem.swimmer.joints.size(), 999U);
}

TEST(ProblemFile, the_digest_is_that_of_the_standard) {
  EXPECT_EQ(document::sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(document::sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// The tail has no angular velocity of its own and a joint that leads it; a ball joint's child would be at rest.
TEST(ProblemFile, a_led_body_without_an_angular_velocity_moves_with_its_parent) {
  std::string text = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  EXPECT_LE((every_key().start.angular_velocity[3] - Vector3d(0.0, 0.0, 0.75)).norm(), 1e-15);
  text.replace(text.find("rotation.tail = [0.0, 0.0, 0.75]"), 32, "rotation.tail = [0.0, 0.5, 0.0]");
  text.replace(text.find("rotation.back = [0.0, 0.0, 0.75]"), 32, "rotation.back = [0.0, 0.0, 0.0]");
  text.replace(text.find("rotation.middle = [0.0, 0.0, 0.25]"), 34, "rotation.middle = [0.0, 0.0, 0.0]");
  text.replace(text.find("rotation.middle = [0.0, 0.0, 0.75]"), 34, "rotation.middle = [0.0, 0.0, 0.5]");
  const Problem turned = file::parse_problem(text, "x").problem;
  const Vector3d seen(-0.75 * std::sin(0.5), 0.0, 0.75 * std::cos(0.5));
  EXPECT_LE((turned.start.angular_velocity[3] - seen).norm(), 1e-15);
  text.replace(text.find("kind = \"universal\""), 18, "kind = \"ball\"");
  text.replace(text.find("axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]\n\n[start]"), 42, "");
  text.replace(text.find(", tail = 9.0"), 12, "");
  text.erase(text.find("angle.tail"), text.find("clearance =") - text.find("angle.tail"));
  expect_vector(file::parse_problem(text, "x").problem.start.angular_velocity[3], 0.0, 0.0, 0.0);
}

TEST(ProblemFile, every_example_is_read_and_supported) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::string(LAMPREY_SOURCE_DIR) + "/examples")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().string());
    ++count;
    const file::ProblemFile example = file::read_problem_file(entry.path().string());
    if (example.problem.goal) {
      EXPECT_NO_THROW(file::require_supported(example, file::Purpose::solve));
    }
  }
  EXPECT_GE(count, 11);
}

}  // namespace
}  // namespace lamprey
