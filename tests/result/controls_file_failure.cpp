#include <numbers>

#include <gtest/gtest.h>

#include "document/io_error.hpp"
#include "file/samples.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"
#include "result/controls_file.hpp"
#include "result/solution_file.hpp"

namespace lamprey {
namespace {

using result::parse_controls;

result::Joints balls(std::size_t count) {
  result::Joints joints(count);
  for (model::JointDescription& joint : joints) joint.kind = model::JointKind::ball;
  return joints;
}

// Those of a result's own swimmer.
result::Joints joints_of(const result::Results& results) {
  result::Joints joints(results.problem.joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    joints[j].name = results.problem.joints[j].name;
    joints[j].kind = results.problem.joints[j].kind;
  }
  return joints;
}

std::string refusal(const std::string& text, const result::Joints& joints) {
  try {
    parse_controls(text, "u.csv", joints);
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ControlsTable, a_table_with_header_comments_and_blank_lines_gives_its_numbers) {
  const auto samples = parse_controls(
      "\xEF\xBB\xBF# made up\r\nt, a, b, c, d, e, f\r\n0, 1, 2, 3, -4, 5e1, +6\r\n\n 0.5 ,7,8,9,10,11,12", "u.csv",
      balls(2));
  EXPECT_EQ(samples.source, result::ControlSource::table);
  EXPECT_EQ(samples.time, (std::vector<double>{0.0, 0.5}));
  ASSERT_EQ(samples.control.size(), 2U);
  EXPECT_EQ(samples.control[0][1], Eigen::Vector3d(-4.0, 50.0, 6.0));
  EXPECT_EQ(samples.control[1][0], Eigen::Vector3d(7.0, 8.0, 9.0));
}

TEST(ControlsTable, a_table_without_header_gives_its_first_row_too) {
  EXPECT_EQ(parse_controls("0,1,2,3\n1,4,5,6\n", "u.csv", balls(1)).time.size(), 2U);
}

result::Joints named(const std::vector<std::string>& names) {
  result::Joints joints = balls(names.size());
  for (std::size_t j = 0; j < names.size(); ++j) joints[j].name = names[j];
  return joints;
}

TEST(ControlsTable, a_header_that_names_joints_says_whose_each_column_is) {
  const result::Joints joints = named({"fin", "fin_x"});
  const std::string rows = "\n0,1,2,3,4,5,6\n1,7,8,9,10,11,12\n";
  for (const char* header :
       {"t,fin_x y,fin z,fin x,fin_x z,fin y,fin_x x", "\"t\",\"fin_x.y\",fin.z,fin.x,fin_x.z,fin.y,fin_x.x",
        "t (s),fin_x_y (N m),fin_z [N m],fin: x,fin_x: z (Nm),fin y,fin_x - x"}) {
    const auto samples = parse_controls(header + rows, "u.csv", joints);
    EXPECT_EQ(samples.control[0][0], Eigen::Vector3d(3.0, 5.0, 2.0)) << header;
    EXPECT_EQ(samples.control[1][1], Eigen::Vector3d(12.0, 7.0, 10.0)) << header;
    EXPECT_EQ(samples.remark, "");
  }
  const auto single = parse_controls("t,z,x,y\n0,1,2,3\n1,4,5,6\n", "u.csv", named({"spine"}));
  EXPECT_EQ(single.control[0][0], Eigen::Vector3d(2.0, 3.0, 1.0));
}

TEST(ControlsTable, a_hinge_by_its_name_alone_is_its_moment_along_its_axis) {
  result::Joints joints = named({"elbow", "elbow2", "tail"});
  joints[0].kind = joints[1].kind = model::JointKind::hinge;
  joints[0].axis = {0.0, 0.0, 2.0};
  joints[0].reference_rotation = {0.5 * std::numbers::pi, 0.0, 0.0};
  joints[1].axis = {0.0, 1.0, 0.0};
  const std::string rows = "\n0,1,2,3,4,5\n1,6,7,8,9,10\n";
  const auto samples = parse_controls("t,tail z,elbow2 (N m),elbow,tail x,tail y" + rows, "u.csv", joints);
  EXPECT_LE((samples.control[0][0] - Eigen::Vector3d(0.0, -3.0, 0.0)).norm(), 1e-15)
      << "the axis in the parent's frame";
  EXPECT_EQ(samples.control[0][1], Eigen::Vector3d(0.0, 2.0, 0.0));
  EXPECT_EQ(samples.control[1][2], Eigen::Vector3d(9.0, 10.0, 6.0));
  EXPECT_EQ(samples.remark, "");
  joints[1].actuated = false;  // which a table needs no column for
  const auto driven = parse_controls("t,elbow,tail x,tail y,tail z\n0,1,2,3,4\n1,5,6,7,8\n", "u.csv", joints);
  EXPECT_EQ(driven.control[1][1], Eigen::Vector3d::Zero());
  EXPECT_EQ(driven.control[1][2], Eigen::Vector3d(6.0, 7.0, 8.0));
  joints[1].actuated = true;
  EXPECT_EQ(refusal("t,tail,tail y,tail z,elbow,elbow2" + rows, joints).rfind("u.csv:1:3: header: found \"tail\"", 0),
            0U)
      << "no hinge";
  EXPECT_EQ(refusal("t,elbow,elbow x,elbow2,tail x,tail y" + rows, joints)
                .rfind("u.csv:1:9: header: found \"elbow x\" beside another column of that hinge", 0),
            0U);
  EXPECT_EQ(
      refusal("t,elbow,tail x,tail y,tail z" + rows, joints)
          .rfind("u.csv:1:1: header: found no column \"elbow2 x\"; allowed: each joint's x, y and z once, or of a "
                 "hinge its name alone",
                 0),
      0U);
  EXPECT_EQ(refusal("t,elbow,elbow2,tail x,tail y,tail z\n0,1,2,3,4,5\n1,2\n", joints)
                .rfind("u.csv:3:1: row: found 2 columns; allowed: 6: t, then those of the header", 0),
            0U);
}

TEST(ControlsTable, a_header_of_other_names_is_remarked_on) {
  const std::string rows = "\n0,1,2,3,4,5,6\n1,7,8,9,10,11,12\n";
  const auto samples = parse_controls("t,u1,u2,u3,u4,u5,u6" + rows, "u.csv", named({"fin", "tail"}));
  EXPECT_EQ(samples.control[0][1], Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(samples.remark,
            "the header of u.csv names no joints of this problem: its columns are taken as t, fin x, fin y, fin z, "
            "tail x, ...");
  EXPECT_EQ(parse_controls(rows, "u.csv", named({"fin", "tail"})).remark, "");
}

TEST(ControlsTable, a_header_that_cannot_be_meant_is_refused_at_its_column) {
  const result::Joints joints = named({"fin", "tail"});
  const std::string rows = "\n0,1,2,3,4,5,6\n1,7,8,9,10,11,12\n";
  const auto refused = [&](const std::string& header) { return refusal(header + rows, joints); };
  EXPECT_EQ(refused("t,fin x,fin y,fin z,tail x,tail y,tial z"),
            "u.csv:1:35: header: found \"tial z\"; allowed: a joint in every column, as \"fin x\"; name this "
            "column too, or none");
  EXPECT_EQ(
      refused("t,fin x,fin y,fin z,tail x,tail y,tail y").rfind("u.csv:1:35: header: found \"tail y\" a second", 0),
      0U);
  EXPECT_EQ(refused("t,fin x,fin y,fin z,tail x,tail y").rfind("u.csv:1:1: header: found no column \"tail z\"", 0), 0U);
  EXPECT_EQ(refused("t,a,b").rfind("u.csv:1:1: header: found 3 columns; allowed: 7", 0), 0U);
  const std::string of_another = refused("t (s),head x (N m),head y (N m),head z (N m),head (N m),left fin_1");
  EXPECT_TRUE(
      of_another.ends_with("the header names \"head\", \"left fin\", and no joint of this problem: \"fin\", "
                           "\"tail\"; is it the table of another swimmer? else name these"))
      << of_another;
  EXPECT_EQ(
      refused("t (ms),fin x,fin y,fin z,tail x,tail y,tail z").rfind("u.csv:1:1: header: found times in \"ms\"", 0),
      0U);
  EXPECT_EQ(refused("t,a,b (N mm),c,d,e,f").rfind("u.csv:1:5: header: found moments in \"N mm\"; allowed: N m", 0), 0U);
}

TEST(ControlsTable, semicolons_are_told) {
  EXPECT_EQ(refusal("t;x;y;z\n0;1;2;3\n", balls(1))
                .rfind("u.csv:1:1: row: found semicolons between columns; allowed: commas", 0),
            0U);
}

TEST(ControlsTable, parts_of_moments_that_joints_cannot_exert_are_told) {
  std::vector<result::ResolvedJoint> joints(2);
  joints[0].name = "fin";
  joints[0].control_axes = {Eigen::Vector3d(0.0, 0.0, 2.0)};
  joints[1].name = "wing";
  joints[1].control_axes = {Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(1.0, 1.0, 0.0)};
  result::ControlSamples samples;
  samples.time = {0.0, 0.5};
  samples.control = {{{0.0, 0.0, 3.0}, {1.0, -2.0, 0.0}}, {{0.0, 0.0, 1.0}, {0.5, 0.0, 0.0}}};
  EXPECT_EQ(result::left_out(samples, joints), "");
  samples.control[1][1].z() = 0.25;
  samples.control[0][0].x() = 0.1;
  EXPECT_NE(result::left_out(samples, joints).find("at most 0.25 N m of joint wing, at 0.5 s"), std::string::npos)
      << result::left_out(samples, joints);
  joints[1].control_axes.clear();
  EXPECT_NE(result::left_out(samples, joints).find("at most 2.24 N m of joint wing, at 0 s"), std::string::npos)
      << result::left_out(samples, joints);
}

TEST(ControlsTable, of_a_single_body_reaches_nowhere) {
  result::ControlSamples samples;
  samples.time = {0.0, 1.0};
  samples.control.assign(2, {});
  const result::Reach reach = result::reach_of_table(samples);
  EXPECT_EQ(reach.rows, 0.0);
  EXPECT_EQ(reach.between, 0.0);
}

TEST(ControlsTable, what_is_wrong_is_told_with_line_and_column) {
  EXPECT_EQ(refusal("t,x,y,z\n0,1,2,3\n1,4,,6\n", named({"fin"})).rfind("u.csv:3:5: moment of fin: found \"\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4, five,6\n", named({"fin"})).rfind("u.csv:2:6: moment of fin: found \"five\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4,inf,6\n", named({"fin"})).rfind("u.csv:2:5: moment of fin: found \"inf\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4,nan,6\n", balls(1)).rfind("u.csv:2:5: ", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n0.0,4,5,6\n", balls(1)).rfind("u.csv:2:1: t: found 0 after 0", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\nt,a,b,c\n", balls(1)).rfind("u.csv:2:1: t: found \"t\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4,5\n", balls(1)).rfind("u.csv:2:1: row: found 3 columns; allowed: 4", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n", balls(1)).rfind("u.csv:1:1: t: found 1 rows; allowed: at least two", 0), 0U);
  EXPECT_NE(refusal("", balls(1)), "");
}

TEST(ControlsOfSolution, the_nodes_of_a_solution_are_the_samples) {
  const result::Results results = tests::sample_results(6);
  const auto samples = parse_controls(result::solution_text(results), "solution.json", joints_of(results));
  EXPECT_EQ(samples.source, result::ControlSource::spline);
  EXPECT_EQ(samples.points, 5);
  EXPECT_EQ(samples.time, results.solution.time);
  EXPECT_EQ(samples.control, results.solution.control);
  EXPECT_EQ(samples.scheme, maneuver::Scheme::paper);
}

// The joint stands at angles (0.7, −0.4) about e_3 of the parent and e_2 of the child.
result::Results bent_universal(const Eigen::Vector3d& moment) {
  result::Results results = tests::sample_results(1);
  result::ResolvedJoint& joint = results.problem.joints[1];
  joint.kind = model::JointKind::universal;
  joint.reference_rotation = {0.0, 0.0, 0.3};
  joint.axes = {Eigen::Vector3d(0.0, 0.0, 2.0), Eigen::Vector3d(0.0, 1.0, 0.0)};
  results.problem.control = maneuver::ControlKind::steps;
  for (int k = 0; k < 2; ++k) {
    auto& rotation = results.solution.rotation[static_cast<std::size_t>(k)];
    rotation[0] = lie::exp({0.4, -0.1, 0.2});
    rotation[2] =
        rotation[0] * lie::exp({0.0, 0.0, 0.7}) * lie::exp(joint.reference_rotation) * lie::exp({0.0, -0.4, 0.0});
    results.solution.control[static_cast<std::size_t>(k)][1] = moment;
  }
  return results;
}

TEST(ControlsOfSolution, moments_of_a_universal_joint_are_turned_back_to_its_zero_angle) {
  const Eigen::Vector3d second_now = lie::exp({0.0, 0.0, 1.0}) * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d second_at_zero = lie::exp({0.0, 0.0, 0.3}) * Eigen::Vector3d::UnitY();
  for (const double along_second : {-5.0, 1e-9, 5.0}) {
    const Eigen::Vector3d moment = 3.0 * Eigen::Vector3d::UnitZ() + along_second * second_now;
    result::Results results = bent_universal(moment);
    const auto nodes = parse_controls(result::solution_text(results), "s.json", joints_of(results));
    const Eigen::Vector3d expected = 3.0 * Eigen::Vector3d::UnitZ() + along_second * second_at_zero;
    EXPECT_EQ(nodes.source, result::ControlSource::steps);
    EXPECT_LE((nodes.control[1][1] - expected).norm(), 1e-14);
    EXPECT_EQ(nodes.control[1][0], results.solution.control[1][0]);
    const double end = results.solution.time[1];
    results.solution.stage_time = {{0.0, 0.7 * end, 0.3 * end, end}};
    results.solution.control_stages = {{4, results.solution.control[1]}};
    const auto stages = parse_controls(result::solution_text(results), "s.json", joints_of(results));
    EXPECT_EQ(stages.source, result::ControlSource::stages);
    EXPECT_EQ(stages.stages, 4U);
    EXPECT_EQ(stages.time, results.solution.stage_time[0]);
    EXPECT_LE((stages.control[2][1] - expected).norm(), 1e-14);
  }
}

TEST(ControlsOfSolution, a_solution_of_another_swimmer_is_refused) {
  const result::Results results = tests::sample_results(6);
  const std::string text = result::solution_text(results);
  EXPECT_EQ(refusal(text, joints_of(results)), "");
  EXPECT_NE(refusal(text, balls(3)).find("/problem/joints: found 2 joints; allowed: the problem's 3"),
            std::string::npos);
  result::Joints other = joints_of(results);
  other[1].name = "fin";
  EXPECT_NE(refusal(text, other).find("/problem/joints/1: found the ball joint \"" + results.problem.joints[1].name),
            std::string::npos)
      << refusal(text, other);
  other = joints_of(results);
  other[0].kind = model::JointKind::hinge;
  EXPECT_NE(refusal(text, other).find("allowed: the problem's hinge joint"), std::string::npos) << refusal(text, other);
}

TEST(ControlsFile, a_missing_file_is_a_failure_of_reading) {
  EXPECT_THROW(result::read_controls("/no/such/file.csv", balls(1)), document::IoError);
}

}  // namespace
}  // namespace lamprey
