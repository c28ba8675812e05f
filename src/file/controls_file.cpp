#include "file/controls_file.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <Eigen/QR>

#include "file/controls_header.hpp"
#include "file/solution_file.hpp"
#include "file/text_file.hpp"
#include "file/toml_document.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "maneuver/control_path.hpp"
#include "model/input_error.hpp"
#include "model/system.hpp"

namespace lamprey::file {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::InputError;

constexpr std::size_t controls_byte_limit = std::size_t{1} << 30;

std::optional<double> parsed(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct Cell {
  std::string_view text;
  int column;  // in the line, from 1
};

std::vector<Cell> cells_of(std::string_view line) {
  std::vector<Cell> cells;
  std::size_t start = 0;
  while (true) {
    const std::size_t comma = std::min(line.find(',', start), line.size());
    const std::string_view cell = line.substr(start, comma - start);
    const std::size_t blanks = std::min(cell.find_first_not_of(" \t\r"), cell.size());
    cells.push_back({trimmed(cell), static_cast<int>(start + blanks) + 1});
    if (comma == line.size()) return cells;
    start = comma + 1;
  }
}

class TableParser {
 public:
  TableParser(const std::string& path, const Joints& joints)
      : path_(path), joints_(joints), columns_(columns_in_order(joints)) {}

  ControlSamples parse(std::string_view text) {
    if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      const std::string_view content = trimmed(line);
      if (!content.empty() && content.front() != '#') read_row(cells_of(line));
    }
    if (samples_.time.size() < 2)
      refuse(1, "t", fmt::format("{} rows", samples_.time.size()), "at least two", "add rows");
    return samples_;
  }

 private:
  [[noreturn]] void refuse(int column, const std::string& key, const std::string& found, const std::string& allowed,
                           const std::string& cure) const {
    throw InputError(path_, std::max(line_, 1), column, key,
                     fmt::format("found {}; allowed: {}; {}", found, allowed, cure));
  }

  std::string column_name(std::size_t column) const {
    if (column == 0) return "t";
    return fmt::format("moment of {}", joints_[columns_[column - 1].joint].name);
  }

  void read_row(const std::vector<Cell>& cells) {
    if (cells.size() == 1 && cells.front().text.find(';') != std::string_view::npos)
      refuse(cells.front().column, "row", "semicolons between columns", "commas, and points in numbers",
             "replace them");
    if (std::exchange(header_possible_, false) && !parsed(cells.front().text))
      read_header(cells);
    else
      read_numbers(cells);
  }

  void require_columns(const std::vector<Cell>& cells, const std::string& key) const {
    if (cells.size() == 1 + columns_.size()) return;
    refuse(1, key, fmt::format("{} columns", cells.size()),
           fmt::format("{}: t, then {}", 1 + columns_.size(), named_ ? "those of the header" : "3 for each joint"),
           named_ ? "add or remove columns"
                  : "add or remove columns, or name them in a header, where hinges need one column only");
  }

  void read_header(const std::vector<Cell>& cells) {
    std::vector<std::string_view> names;
    for (const Cell& cell : cells) names.push_back(cell.text);
    const ControlsHeader header = read_controls_header(names, joints_);
    if (const auto& fault = header.fault)
      refuse(cells[fault->cell].column, "header", fault->found, fault->allowed, fault->cure);
    columns_ = header.columns;
    named_ = header.named;
    require_columns(cells, "header");
    if (!named_)
      samples_.remark = fmt::format("the header of {} names no joints of this problem: its columns are taken as {}",
                                    path_, controls_header_in_order(joints_));
  }

  void read_numbers(const std::vector<Cell>& cells) {
    require_columns(cells, "row");
    std::vector<double> numbers;
    for (const Cell& cell : cells) {
      const std::optional<double> value = parsed(cell.text);
      if (!value || !std::isfinite(*value))
        refuse(cell.column, column_name(numbers.size()), in_quotes(cell.text), "a finite number",
               "write it with a decimal point, as in -1.5e3");
      numbers.push_back(*value);
    }
    if (!samples_.time.empty() && !(numbers[0] > samples_.time.back()))
      refuse(cells[0].column, "t", fmt::format("{} after {}", numbers[0], samples_.time.back()), "times that rise (s)",
             "sort the rows and remove repeated times");
    samples_.time.push_back(numbers[0]);
    samples_.control.emplace_back(joints_.size());
    for (Vector3d& moment : samples_.control.back()) moment.setZero();
    for (std::size_t n = 1; n < numbers.size(); ++n)
      samples_.control.back()[columns_[n - 1].joint] += numbers[n] * columns_[n - 1].direction;
  }

  const std::string& path_;
  const Joints& joints_;
  std::vector<ControlsColumn> columns_;  // after the first
  bool named_ = false;                   // by a header
  int line_ = 0;
  bool header_possible_ = true;
  ControlSamples samples_;
};

// Of a universal joint: its second axis in the parent's frame.
Vector3d second_axis(const ResolvedJoint& joint, const std::vector<Matrix3d>& rotation) {
  return rotation[model::at(joint.parent)].transpose() *
         (rotation[model::at(joint.child)] * (*joint.axes)[1].stableNormalized());
}

// Moments as they stood, turned back to the joints' zero angle. A universal joint's second axis turns about its first
// one a: what of the moment is not along a is along that axis, and `rotation`, of a time near by, tells which way.
std::vector<Vector3d> at_zero_angle(const ResolvedProblem& problem, const std::vector<Matrix3d>& rotation,
                                    std::vector<Vector3d> moments) {
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    const ResolvedJoint& joint = problem.joints[j];
    if (joint.kind != JointKind::universal) continue;
    const Vector3d first = (*joint.axes)[0].stableNormalized();
    const Vector3d second = lie::exp(joint.reference_rotation) * (*joint.axes)[1].stableNormalized();
    const double along = first.dot(moments[j]);
    const Vector3d across = moments[j] - along * first;
    moments[j] = along * first + std::copysign(across.norm(), across.dot(second_axis(joint, rotation))) * second;
  }
  return moments;
}

void take_nodes(const Results& results, ControlSamples& samples) {
  samples.time = results.solution.time;
  for (std::size_t k = 0; k < samples.time.size(); ++k)
    samples.control.push_back(
        at_zero_angle(results.problem, results.solution.rotation[k], results.solution.control[k]));
}

void take_stages(const Results& results, ControlSamples& samples) {
  const maneuver::Solution& solution = results.solution;
  samples.stages = solution.stage_time.front().size();
  for (std::size_t k = 0; k < solution.stage_time.size(); ++k) {
    const double middle = 0.5 * (solution.time[k] + solution.time[k + 1]);
    for (std::size_t s = 0; s < samples.stages; ++s) {
      const double t = solution.stage_time[k][s];
      samples.time.push_back(t);
      samples.control.push_back(
          at_zero_angle(results.problem, solution.rotation[t < middle ? k : k + 1], solution.control_stages[k][s]));
    }
  }
}

maneuver::Start first_node(const maneuver::Solution& solution) {
  maneuver::Start first;
  first.position = solution.position.front();
  for (const Eigen::Matrix3d& R : solution.rotation.front()) first.rotation.push_back(lie::log(R));
  first.angular_velocity = solution.angular_velocity.front();
  first.linear_velocity = solution.rotation.front()[0] * solution.linear_velocity.front();
  return first;
}

// Masses and offsets may differ: a disturbed swimmer follows the same moments.
void require_same_joints(const std::vector<ResolvedJoint>& found, const Joints& joints, const std::string& path) {
  const char* cure = "choose the controls of the same swimmer";
  if (found.size() != joints.size())
    throw InputError(path, "/problem/joints",
                     fmt::format("found {} joints; allowed: the problem's {}; {}", found.size(), joints.size(), cure));
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (found[j].name != joints[j].name || found[j].kind != joints[j].kind)
      throw InputError(path, fmt::format("/problem/joints/{}", j),
                       fmt::format("found the {} joint {}; allowed: the problem's {} joint {}; {}", word(found[j].kind),
                                   in_quotes(found[j].name), word(joints[j].kind), in_quotes(joints[j].name), cure));
}

}  // namespace

ControlSamples controls_of_results(const Results& results, const std::string& path, const Joints& joints) {
  require_same_joints(results.problem.joints, joints, path);
  if (results.solution.time.size() < 2)
    throw InputError(path, "/time", "found no motion; allowed: at least two nodes; choose a file with a trajectory");
  for (std::size_t k = 1; k < results.solution.time.size(); ++k)
    if (!(results.solution.time[k] > results.solution.time[k - 1]))
      throw InputError(path, fmt::format("/time/{}", k),
                       fmt::format("found {} after {}; allowed: times that rise (s); mend this field",
                                   results.solution.time[k], results.solution.time[k - 1]));
  ControlSamples samples;
  const bool spline = results.problem.control == maneuver::ControlKind::spline;
  const bool stages = !spline && !results.solution.control_stages.empty();
  samples.source = spline ? ControlSource::spline : stages ? ControlSource::stages : ControlSource::steps;
  if (stages)
    take_stages(results, samples);
  else
    take_nodes(results, samples);
  samples.points = results.problem.points;
  samples.scheme = results.problem.scheme;
  samples.first = first_node(results.solution);
  samples.gait = results.problem.goal && results.problem.goal->periodic;
  return samples;
}

ControlSamples parse_controls(const std::string& bytes, const std::string& path, const Joints& joints) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && bytes[first] == '{')
    return controls_of_results(parse_solution(bytes, path), path, joints);
  return TableParser(path, joints).parse(bytes);
}

void repeat(int cycles, ControlSamples& gait) {
  const std::vector<double> time = gait.time;
  const auto control = gait.control;
  const double period = time.back() - time.front();
  for (int cycle = 1; cycle < cycles; ++cycle) {
    for (std::size_t j = 0; j < control.front().size(); ++j)
      gait.control.back()[j] = 0.5 * (control.back()[j] + control.front()[j]);
    for (std::size_t k = 1; k < time.size(); ++k) {
      gait.time.push_back(time[k] + cycle * period);
      gait.control.push_back(control[k]);
    }
  }
}

Reach reach_of_table(const ControlSamples& samples) {
  constexpr int looks = 8;  // from row to row
  const auto rows = static_cast<Eigen::Index>(samples.time.size());
  const auto joints = static_cast<Eigen::Index>(samples.control.front().size());
  Eigen::MatrixXd values(3 * joints, rows);
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index j = 0; j < joints; ++j)
      values.col(r).segment<3>(3 * j) = samples.control[static_cast<std::size_t>(r)][static_cast<std::size_t>(j)];
  const maneuver::ControlPath path(maneuver::Interpolation::not_a_knot_cubic,
                                   Eigen::Map<const Eigen::VectorXd>(samples.time.data(), rows), values);
  Reach reach{values.cwiseAbs().maxCoeff(), 0.0};
  for (std::size_t r = 0; r + 1 < samples.time.size(); ++r)
    for (int look = 0; look <= looks; ++look) {
      const double share = static_cast<double>(look) / looks;
      const double time = (1.0 - share) * samples.time[r] + share * samples.time[r + 1];
      reach.between = std::max(reach.between, path.value(time).cwiseAbs().maxCoeff());
    }
  return reach;
}

namespace {

// Of a moment on the parent with the joint at its zero angle.
Vector3d beyond_axes(const ResolvedJoint& joint, const Vector3d& moment) {
  if (joint.control_axes.empty()) return moment;
  Eigen::MatrixXd axes(3, static_cast<Eigen::Index>(joint.control_axes.size()));
  for (std::size_t a = 0; a < joint.control_axes.size(); ++a)
    axes.col(static_cast<Eigen::Index>(a)) = joint.control_axes[a];
  return moment - axes * axes.completeOrthogonalDecomposition().solve(moment);
}

}  // namespace

std::string left_out(const ControlSamples& samples, const std::vector<ResolvedJoint>& joints) {
  constexpr double worth_telling = 1e-6;  // of the largest moment
  double largest = 0.0, most = 0.0, time = 0.0;
  std::size_t joint = 0;
  for (std::size_t r = 0; r < samples.control.size(); ++r)
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const double beyond = beyond_axes(joints[j], samples.control[r][j]).norm();
      largest = std::max(largest, samples.control[r][j].norm());
      if (beyond <= most) continue;
      most = beyond, time = samples.time[r], joint = j;
    }
  if (!(most > worth_telling * largest)) return "";
  return fmt::format(
      "Parts of the moments are nothing that their joints can exert, and were left out: at most {:.3g} N m of "
      "joint {}, at {:.3g} s. Moments are read in the parent's frame with the joint at its zero angle.",
      most, joints[joint].name, time);
}

ControlSamples read_controls(const std::string& path, const Joints& joints) {
  return parse_controls(read_bytes(path, controls_byte_limit), path, joints);
}

}  // namespace lamprey::file
