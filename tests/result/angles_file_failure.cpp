// Tables of joint angles: whose each column is, in which unit, and what is refused.
#include "result/angles_file.hpp"

#include <gtest/gtest.h>

#include "file/refusals.hpp"
#include "model/input_error.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using result::AngleSamples;
using result::parse_angles;

// A hinge, a universal, a ball and a fixed joint.
result::Joints one_of_each() {
  result::Joints joints(4);
  joints[0].name = "elbow", joints[0].kind = model::JointKind::hinge;
  joints[1].name = "fin", joints[1].kind = model::JointKind::universal;
  joints[2].name = "spine", joints[2].kind = model::JointKind::ball;
  joints[3].name = "collar", joints[3].kind = model::JointKind::fixed;
  return joints;
}

std::string refusal(const std::string& text, const result::Joints& joints = one_of_each()) {
  try {
    parse_angles(text, "a.csv", joints);
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(AnglesTable, holds_the_angles_of_each_joints_freedoms) {
  const AngleSamples samples = parse_angles("0,1,2,3,4,5,6\n2,0,0,0,0,0,0\n", "a.csv", one_of_each());
  EXPECT_EQ(samples.time, (std::vector<double>{0.0, 2.0}));
  EXPECT_EQ(samples.angle[0][0], Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(samples.angle[0][1], Eigen::Vector3d(2, 3, 0));
  EXPECT_EQ(samples.angle[0][2], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(samples.angle[0][3], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(samples.remark, "");
}

TEST(AnglesTable, a_header_says_whose_each_column_is_and_in_which_unit) {
  const AngleSamples samples = parse_angles(
      "t,fin 2 (deg),fin_1 (rad),spine z [rad],elbow (°),spine.x (rad),spine y (rad)\n0,90,2,3,-180,5,6\n"
      "1,0,0,0,0,0,0\n",
      "a.csv", one_of_each());
  const double half = 0.5 * M_PI;
  EXPECT_LE((samples.angle[0][0] - Eigen::Vector3d(-2.0 * half, 0, 0)).norm(), tolerance(1e-15) * 4.0);
  EXPECT_LE((samples.angle[0][1] - Eigen::Vector3d(2.0, half, 0)).norm(), tolerance(1e-15) * 4.0);
  EXPECT_EQ(samples.angle[0][2], Eigen::Vector3d(5, 6, 3));
  const AngleSamples unnamed = parse_angles(
      "t,a (deg),b (deg),c (deg),d (deg),e (deg),f (deg)\n0,180,2,3,4,5,6\n1,0,0,0,0,0,0\n", "a.csv", one_of_each());
  EXPECT_NEAR(unnamed.angle[0][0][0], M_PI, 1e-15) << "a unit holds without a name";
  EXPECT_EQ(
      unnamed.remark,
      "the header of a.csv names no joints of this problem: its columns are taken as t, elbow, fin 1, fin 2, spine x, "
      "...");
}

TEST(AnglesTable, that_cannot_be_meant_is_refused_at_its_column) {
  const std::string rows = "\n0,1,2,3,4,5,6\n1,0,0,0,0,0,0\n";
  expect_begins(refusal("t,elbow,fin 1,fin 2,spine x,spine y,spine w" + rows),
                "a.csv:1:37: header: found \"spine w\"; allowed: a joint in every column, as \"elbow\"");
  expect_begins(refusal("t,elbow_deg,b,c,d,e,f" + rows),
                "a.csv:1:3: header: found \"elbow_deg\"; allowed: a joint's angles as \"elbow\"");
  expect_begins(refusal("t,elbow,fin 1,fin 1,spine x,spine y,spine z" + rows),
                "a.csv:1:15: header: found \"fin 1\" a second time; allowed: the angles of each joint once");
  expect_begins(refusal("t,elbow,fin 1,fin 2,spine x,spine y" + rows),
                "a.csv:1:1: header: found no column \"spine z\"; allowed: the angles of each joint once");
  expect_begins(refusal("t,elbow (N m),fin 1,fin 2,spine x,spine y,spine z" + rows),
                "a.csv:1:3: header: found angles in \"N m\"; allowed: rad or deg; convert the column to radians");
  expect_begins(
      refusal("0,1,2\n1,0,0\n"),
      "a.csv:1:1: row: found 3 columns; allowed: 7: t, then those of each joint: 1 of a hinge, 2 of a universal");
  expect_begins(refusal("0,1,2,3,4,5,6\n1,0,nan,0,0,0,0\n"),
                "a.csv:2:5: angle of fin: found \"nan\"; allowed: a finite");
  expect_begins(refusal("0,1,2,3,4,5,6\n"), "a.csv:1:1: t: found 1 rows; allowed: at least two");
}

// Radians would be read where degrees are meant.
TEST(AnglesTable, with_units_for_some_columns_and_none_for_others_is_refused) {
  const std::string rows = "\n0,1,2,3,4,5,6\n1,0,0,0,0,0,0\n";
  const std::string allowed = "; allowed: a unit behind every column, or behind none where all are radians; ";
  EXPECT_EQ(refusal("t (s),elbow (deg),fin 1 (deg),fin 2,spine x,spine y,spine z" + rows),
            "a.csv:1:31: header: found \"fin 2\" without a unit beside \"elbow (deg)\"" + allowed +
                "write \"fin 2 (deg)\" or \"fin 2 (rad)\"");
  expect_begins(refusal("t,a,b,c,d,e,f [rad]" + rows),
                "a.csv:1:3: header: found \"a\" without a unit beside \"f [rad]\"" + allowed);
  EXPECT_EQ(refusal("t (s),elbow,fin 1,fin 2,spine x,spine y,spine z" + rows), "") << "that of time says nothing";
}

TEST(AnglesTable, of_a_swimmer_without_angles_has_no_columns) {
  result::Joints welded(1);
  welded[0].name = "weld", welded[0].kind = model::JointKind::fixed;
  expect_begins(refusal("t,weld\n0,1\n1,1\n", welded), "a.csv:1:1: header: found 2 columns; allowed: 1: t");
}

TEST(AnglesTable, beyond_a_joints_freedoms_is_refused) {
  const result::Joints joints = one_of_each();
  AngleSamples samples = parse_angles("0,1,2,3,4,5,6\n2,0,0,0,0,0,0\n", "a.csv", joints);
  EXPECT_NO_THROW(result::require_freedoms(samples, "a.csv", joints));
  const auto refused = [&](std::size_t joint, int component) {
    AngleSamples wrong = samples;
    wrong.angle[1][joint][component] = 0.25;
    try {
      result::require_freedoms(wrong, "angles", joints);
    } catch (const model::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  expect_begins(refused(0, 2),
                "angles: elbow: found [0, 0, 0.25] at 2 s; allowed: one angle of a hinge joint, zeros behind");
  expect_begins(refused(1, 2), "angles: fin: found [0, 0, 0.25] at 2 s; allowed: two angles of a universal joint");
  expect_begins(refused(3, 0), "angles: collar: found [0.25, 0, 0] at 2 s; allowed: no angle of a fixed joint");
  EXPECT_EQ(refused(2, 2), "");
}

TEST(AnglesTable, repeats_where_it_ends_as_it_begins) {
  result::Joints hinge(1);
  hinge[0].name = "elbow", hinge[0].kind = model::JointKind::hinge;
  AngleSamples samples = parse_angles("0,0.5\n1,-0.5\n2,0.5\n", "a.csv", hinge);
  result::repeat(3, "a.csv", hinge, samples);
  EXPECT_EQ(samples.time, (std::vector<double>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(samples.angle[5][0][0], -0.5);
  AngleSamples wheel = parse_angles("0,0.5\n1,3.2\n2,6.783185307179586\n", "a.csv", hinge);
  result::repeat(2, "a.csv", hinge, wheel);
  EXPECT_NEAR(wheel.angle[4][0][0], 0.5 + 4.0 * M_PI, 1e-12) << "whole turns go on";
  AngleSamples late = parse_angles("1,0.5\n2,-0.5\n3,0.5\n", "a.csv", hinge);
  EXPECT_THROW(result::repeat(2, "a.csv", hinge, late), model::InputError);
  AngleSamples open = parse_angles("0,0.5\n1,-0.5\n", "a.csv", hinge);
  EXPECT_NO_THROW(result::repeat(1, "a.csv", hinge, open));
  try {
    result::repeat(2, "a.csv", hinge, open);
    FAIL();
  } catch (const model::InputError& error) {
    expect_begins(error.what(), "a.csv: elbow: found 1 rad between its last and its first angle; allowed: none");
  }
}

}  // namespace
}  // namespace lamprey::tests
