#include <gtest/gtest.h>

#include "file/controls_file.hpp"
#include "file/io_error.hpp"
#include "file/solution_file.hpp"
#include "model/input_error.hpp"
#include "samples.hpp"

namespace lamprey {
namespace {

using file::parse_controls;

std::string refusal(const std::string& text, int joints) {
  try {
    parse_controls(text, "u.csv", joints);
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ControlsTable, a_table_with_header_comments_and_blank_lines_gives_its_numbers) {
  const auto samples = parse_controls(
      "\xEF\xBB\xBF# made up\r\nt, a, b, c, d, e, f\r\n0, 1, 2, 3, -4, 5e1, +6\r\n\n 0.5 ,7,8,9,10,11,12", "u.csv", 2);
  EXPECT_EQ(samples.source, file::ControlSource::table);
  EXPECT_EQ(samples.time, (std::vector<double>{0.0, 0.5}));
  ASSERT_EQ(samples.control.size(), 2U);
  EXPECT_EQ(samples.control[0][1], Eigen::Vector3d(-4.0, 50.0, 6.0));
  EXPECT_EQ(samples.control[1][0], Eigen::Vector3d(7.0, 8.0, 9.0));
}

TEST(ControlsTable, a_table_without_header_gives_its_first_row_too) {
  EXPECT_EQ(parse_controls("0,1,2,3\n1,4,5,6\n", "u.csv", 1).time.size(), 2U);
}

TEST(ControlsTable, what_is_wrong_is_told_with_line_and_column) {
  EXPECT_EQ(refusal("t,x,y,z\n0,1,2,3\n1,4,,6\n", 1).rfind("u.csv:3:5: joint 0 moment 1: found \"\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4, five,6\n", 1).rfind("u.csv:2:6: joint 0 moment 1: found \"five\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4,inf,6\n", 1).rfind("u.csv:2:5: joint 0 moment 1: found \"inf\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4,nan,6\n", 1).rfind("u.csv:2:5: ", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n0.0,4,5,6\n", 1).rfind("u.csv:2:1: t: found 0 after 0", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\nt,a,b,c\n", 1).rfind("u.csv:2:1: t: found \"t\"", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n1,4,5\n", 1).rfind("u.csv:2:1: row: found 3 columns; allowed: 4", 0), 0U);
  EXPECT_EQ(refusal("0,1,2,3\n", 1).rfind("u.csv:1:1: t: found 1 rows; allowed: at least two", 0), 0U);
  EXPECT_NE(refusal("", 1), "");
}

TEST(ControlsOfSolution, the_nodes_of_a_solution_are_the_samples) {
  const file::Results results = tests::sample_results(6);
  const auto samples = parse_controls(file::solution_text(results), "solution.json", 2);
  EXPECT_EQ(samples.source, file::ControlSource::spline);
  EXPECT_EQ(samples.points, 5);
  EXPECT_EQ(samples.time, results.solution.time);
  EXPECT_EQ(samples.control, results.solution.control);
  EXPECT_EQ(samples.scheme, maneuver::Scheme::paper);
}

TEST(ControlsOfSolution, a_solution_of_another_swimmer_is_refused) {
  EXPECT_NE(refusal(file::solution_text(tests::sample_results(6)), 3)
                .find("/problem/joints: found 2 joints; allowed: the problem's 3"),
            std::string::npos);
}

TEST(ControlsFile, a_missing_file_is_a_failure_of_reading) {
  EXPECT_THROW(file::read_controls("/no/such/file.csv", 1), file::IoError);
}

}  // namespace
}  // namespace lamprey
