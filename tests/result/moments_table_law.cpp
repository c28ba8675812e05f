// Tables of moments: what is written is read back, by x, y and z as by the moments of motors, and marches the same motion.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "document/atomic_write.hpp"
#include "file/problem_file.hpp"
#include "model/input_error.hpp"
#include "result/controls_file.hpp"
#include "result/table_files.hpp"
#include "task/tasks.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

// Three bodies on a universal joint whose axes lie askew, and on a hinge.
file::ProblemFile fins() {
  return file::parse_problem(R"(
schema = 1
fluid.density = 1000.0
body = [{name = "hull", semi_axes = [0.2, 0.05, 0.06]}, {name = "fin", semi_axes = [0.1, 0.03, 0.05]},
        {name = "tail", semi_axes = [0.1, 0.03, 0.05]}]
time = {duration = 0.5, steps = 50}

[[joint]]
kind = "universal"
parent = "hull"
child = "fin"
parent_offset = [0.21, 0.0, 0.0]
child_offset = [-0.11, 0.0, 0.0]
axes = [[0.0, 0.6, 0.8], [0.0, 0.8, -0.6]]

[[joint]]
kind = "hinge"
parent = "hull"
child = "tail"
parent_offset = [-0.21, 0.0, 0.0]
child_offset = [0.11, 0.0, 0.0]
axis = [0.0, 1.0, 1.0]
)",
                             "fins.toml");
}

// Under moments of the motors that differ and rise and fall.
result::Results marched(const file::ProblemFile& problem) {
  task::MarchOptions options;
  options.control = [](double t) {
    const double first = 0.02 * std::sin(9.0 * t), second = 0.01 * std::cos(7.0 * t),
                 of_hinge = 0.03 * std::sin(11.0 * t);
    return std::vector<Vector3d>{first * Vector3d(0.0, 0.6, 0.8) + second * Vector3d(0.0, 0.8, -0.6),
                                 of_hinge * Vector3d(0.0, 1.0, 1.0).normalized()};
  };
  return task::march_task(problem, options, "");
}

std::string exported(const result::Results& results) {
  const auto folder = std::filesystem::temp_directory_path() / ("lamprey_moments_" + std::to_string(getpid()));
  document::write_files(folder.string(), {*result::moments_table(results, "x")});
  std::ifstream in(folder / "moments.csv");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::filesystem::remove_all(folder);
  return text;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

// The table's columns that a choice by their names keeps; t always.
template <class Choice>
std::string with_columns(const std::string& table, const Choice& chosen) {
  std::istringstream in(table);
  std::vector<std::size_t> kept;
  std::string text;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (kept.empty())
      for (std::size_t n = 0; n < cells.size(); ++n)
        if (n == 0 || chosen(cells[n])) kept.push_back(n);
    std::vector<std::string> own;
    for (const std::size_t n : kept) own.push_back(cells[n]);
    text += fmt::format("{}\n", fmt::join(own, ","));
  }
  return text;
}

bool of_motor(const std::string& name) {
  return name == "fin 1 (N m)" || name == "fin 2 (N m)" || name == "tail (N m)";
}

double turned_off(const result::Results& a, const result::Results& b) {
  double largest = std::abs(static_cast<double>(a.solution.time.size()) - static_cast<double>(b.solution.time.size()));
  for (std::size_t k = 0; k < std::min(a.solution.time.size(), b.solution.time.size()); ++k)
    for (std::size_t i = 0; i < a.problem.bodies.size(); ++i)
      largest = std::max(largest, (a.solution.rotation[k][i] - b.solution.rotation[k][i]).norm());
  return largest;
}

TEST(MomentsTable, marches_the_same_motion_by_axes_and_by_motors) {
  const file::ProblemFile problem = fins();
  const result::Results first = marched(problem);
  ASSERT_EQ(first.solution.status, maneuver::Status::simulated) << first.solution.message;
  const auto& joints = problem.problem.swimmer.joints;
  const std::string all = exported(first);
  const auto moved = (first.solution.rotation.back()[1] - first.solution.rotation.front()[1]).norm();
  EXPECT_GT(moved, 0.1) << "the axes have turned";
  for (const std::string& table :
       {all, with_columns(all, of_motor), with_columns(all, [](const std::string& name) { return !of_motor(name); })}) {
    task::MarchOptions options;
    options.controls = result::parse_controls(table, "u.csv", joints);
    EXPECT_EQ(options.controls->remark, "");
    options.controls->source = result::ControlSource::lines;
    EXPECT_LE(turned_off(first, task::march_task(problem, options, "")), tolerance(1e-9));
  }
  const std::string motors = with_columns(all, of_motor);
  EXPECT_EQ(cells_of(motors.substr(0, motors.find('\n'))).size(), 4U) << "t and a column for each motor";
}

// The table's first line says how moments run between its rows: in other steps, too, they are those of solution.json.
TEST(MomentsTable, marches_as_the_motion_it_was_written_from_in_steps_of_any_length) {
  file::ProblemFile problem = fins();
  const result::Results first = marched(problem);
  const auto& joints = problem.problem.swimmer.joints;
  const std::string table = exported(first);
  problem.problem.steps *= 3;
  const auto by = [&](const result::ControlSamples& samples) {
    task::MarchOptions options;
    options.controls = samples;
    return task::march_task(problem, options, "");
  };
  const result::Results stored = by(result::controls_of_results(first, "x", joints));
  const result::ControlSamples samples = result::parse_controls(table, "u.csv", joints);
  EXPECT_EQ(samples.source, result::ControlSource::lines);
  EXPECT_LE(turned_off(stored, by(samples)), tolerance(1e-9));
  const std::string other_words = "# linear between rows\n" + table.substr(table.find('\n') + 1);
  const result::ControlSamples cubic = result::parse_controls(other_words, "u.csv", joints);
  EXPECT_EQ(cubic.source, result::ControlSource::table);
  EXPECT_GT(turned_off(stored, by(cubic)), 1e-7);
}

TEST(MomentsTable, gives_motors_what_acts_along_their_axes) {
  const file::ProblemFile problem = fins();
  const auto samples = result::parse_controls(with_columns(exported(marched(problem)), of_motor), "u.csv",
                                              problem.problem.swimmer.joints);
  for (std::size_t k = 0; k < samples.time.size(); ++k) {
    const double t = samples.time[k];
    EXPECT_NEAR(samples.control[k][0].dot(Vector3d(0.0, 0.6, 0.8)), 0.02 * std::sin(9.0 * t), tolerance(1e-12));
    EXPECT_NEAR(samples.control[k][0].dot(Vector3d(0.0, 0.8, -0.6)), 0.01 * std::cos(7.0 * t), tolerance(1e-12));
    EXPECT_NEAR(samples.control[k][1].norm(), std::abs(0.03 * std::sin(11.0 * t)), tolerance(1e-12));
  }
}

TEST(MomentsTable, that_says_two_things_at_once_is_refused) {
  const auto joints = fins().problem.swimmer.joints;
  const std::string heads = "t,fin x,fin y,fin z,fin 1,fin 2,tail\n0,0,0.6,0.8,";
  const std::string end = ",0\n1,0,0,0,0,0,0\n";
  EXPECT_NO_THROW(result::parse_controls(heads + "1,0" + end, "u.csv", joints));
  EXPECT_THROW(result::parse_controls(heads + "1,0.5" + end, "u.csv", joints), model::InputError);
  EXPECT_THROW(result::parse_controls(heads + "-1,0" + end, "u.csv", joints), model::InputError);
  for (const char* lacking : {"t,fin 1,tail\n0,1,2\n1,1,2\n", "t,fin x,fin 1,fin 2,tail\n0,1,2,3,4\n1,1,2,3,4\n",
                              "t,fin x,fin y,fin z,fin 1,tail\n0,0,0,0,0,0\n1,0,0,0,0,0\n"})
    EXPECT_THROW(result::parse_controls(lacking, "u.csv", joints), model::InputError) << lacking;
}

}  // namespace
}  // namespace lamprey::tests
