#include "result/table_files.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "integrator/scheme.hpp"
#include "result/angles_file.hpp"
#include "result/controls_file.hpp"
#include "result/resolve.hpp"

namespace lamprey::result {

namespace {

// Nothing where names are such that nobody could read them back, as with commas in them.
std::string header(TableKind kind, const std::vector<NamedColumn>& columns, const Joints& joints) {
  std::vector<std::string> cells = {"t"};
  for (const NamedColumn& column : columns)
    cells.push_back(column.name + (kind == TableKind::angles ? " (rad)" : " (N m)"));
  const TableHeader read = read_table_header(kind, {cells.begin(), cells.end()}, joints);
  const bool plain = std::none_of(cells.begin(), cells.end(), [](const std::string& cell) {
    return cell.find_first_of(",;\"\r\n#") != std::string::npos;
  });
  return plain && read.named && !read.fault ? fmt::format("{}\n", fmt::join(cells, ",")) : "";
}

std::string table_text(TableKind kind, const Joints& joints, const std::string& remark, const std::vector<double>& time,
                       const std::vector<std::vector<Eigen::Vector3d>>& value) {
  std::vector<NamedColumn> columns = columns_to_write(kind, joints);
  const std::string names = header(kind, columns, joints);
  if (names.empty()) std::erase_if(columns, [](const NamedColumn& one) { return one.column.again; });
  std::string text = "# " + remark + "\n" + names;
  for (std::size_t k = 0; k < time.size(); ++k) {
    text += fmt::format("{}", time[k]);
    for (const auto& [name, column] : columns)
      text += fmt::format(",{}", column.direction.dot(value[k][column.joint]) + 0.0);  // no −0
    text += "\n";
  }
  return text;
}

// How a table is marched again. Nothing leads passive joints along angles.
std::string remark_on_angles(const Joints& joints) {
  std::vector<std::string> passive, confined;
  for (const model::JointDescription& joint : joints) {
    if (joint.passive()) passive.push_back(joint.name);
    const bool all = !joint.control_axes || joint.control_axes->size() == 3 || joint.kind != model::JointKind::ball;
    if (joint.actuated && !all) confined.push_back(joint.name);
  }
  if (passive.empty() && !confined.empty())
    return fmt::format(
        "joint angles from zero; as moments act about some axes of {} alone (control_axes), which seldom lead along "
        "angles about all, lamprey simulate marches the moments instead",
        fmt::join(confined, ", "));
  if (passive.empty()) return "joint angles from zero; lamprey simulate P.toml --angles angles.csv";
  return fmt::format(
      "joint angles from zero; as no moment leads {}, lamprey simulate marches the moments instead, or these without "
      "such joints",
      fmt::join(passive, ", "));
}

// A table does not tell in which shape, and how fast, a gait begins.
std::string remark_on_moments(const Results& results) {
  const std::string what(exported_moments.substr(2));
  if (results.problem.goal && results.problem.goal->periodic)
    return what +
           "lamprey simulate P.toml --controls solution.json begins as the gait does, --controls moments.csv as P.toml "
           "says";
  return what + "lamprey simulate P.toml --controls moments.csv";
}

}  // namespace

document::PendingFile angles_table(const Results& results, const std::string& path) {
  const Joints joints = problem_of(results).swimmer.joints;
  const AngleSamples samples = angles_of_results(results, path, joints);
  return document::finished_file(
      "angles.csv", table_text(TableKind::angles, joints, remark_on_angles(joints), samples.time, samples.angle));
}

std::optional<document::PendingFile> moments_table(const Results& results, const std::string& path) {
  if (!integrator::single_step(results.problem.scheme)) return std::nullopt;
  const Joints joints = problem_of(results).swimmer.joints;
  const ControlSamples samples = controls_of_results(results, path, joints);
  return document::finished_file(
      "moments.csv", table_text(TableKind::moments, joints, remark_on_moments(results), samples.time, samples.control));
}

}  // namespace lamprey::result
