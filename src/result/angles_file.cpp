#include "result/angles_file.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "document/text_file.hpp"
#include "file/words.hpp"
#include "model/input_error.hpp"
#include "model/system.hpp"
#include "result/followed_file.hpp"
#include "result/solution_file.hpp"

namespace lamprey::result {

using Eigen::Vector3d;
using model::InputError;

namespace {

constexpr double whole_turn = 2.0 * std::numbers::pi;

}  // namespace

AngleSamples angles_of_results(const Results& results, const std::string& path, const Joints& joints) {
  require_motion_of(joints, results, path);
  if (results.solution.joint_angle.size() != results.solution.time.size())
    throw InputError(
        path, "/joint_angle",
        "found none; allowed: the angles at each node; write the file anew (lamprey simulate, lamprey solve)");
  AngleSamples samples{
      .time = results.solution.time, .angle = results.solution.joint_angle, .first = first_node(results.solution)};
  for (const auto& joint : joints) samples.passive.push_back(joint.passive());
  return samples;
}

AngleSamples parse_angles(const std::string& bytes, const std::string& path, const Joints& joints) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && bytes[first] == '{')
    return angles_of_results(parse_solution(bytes, path), path, joints);
  JointTable table = parse_joint_table(TableKind::angles, bytes, path, joints);
  AngleSamples samples{
      .time = std::move(table.time), .angle = std::move(table.value), .remark = std::move(table.remark)};
  samples.passive.resize(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j)
    samples.passive[j] = table.left_out[j] && joints[j].kind != model::JointKind::fixed;
  return samples;
}

AngleSamples read_angles(const std::string& path, const Joints& joints) {
  const std::string file = document::motion_file(path);
  return parse_angles(document::read_bytes(file, table_byte_limit), file, joints);
}

namespace {

constexpr double closed = 1e-6;  // rad, of a period's ends

// By what a joint's turn is ahead after a period: whole turns about its axes. Nothing where it does not end where it began.
std::optional<Vector3d> ahead(const Vector3d& first, const Vector3d& last, bool about_axes) {
  const Vector3d between = last - first, turns = (between / whole_turn).array().round();
  const Vector3d ahead = about_axes ? Vector3d(whole_turn * turns) : Vector3d(Vector3d::Zero());
  if ((between - ahead).norm() > closed) return std::nullopt;
  return ahead;
}

}  // namespace

void repeat(int cycles, const std::string& path, const Joints& joints, AngleSamples& angles) {
  if (cycles == 1) return;
  const std::vector<double> time = angles.time;
  const auto angle = angles.angle;
  const double period = time.back();
  if (std::abs(time.front()) > closed * period)
    throw InputError(
        path, "t",
        fmt::format("found a first time of {} s; allowed: 0 s, where cycles repeat; begin there", time.front()));
  std::vector<Vector3d> gained;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto turned = ahead(angle.front()[j], angle.back()[j], joints[j].kind != model::JointKind::ball);
    if (!turned)
      throw InputError(
          path, joints[j].name,
          fmt::format(
              "found {:.3g} rad between its last and its first angle; allowed: none, or whole turns of a hinge, where "
              "cycles repeat; end where it begins, or leave cycles out",
              (angle.back()[j] - angle.front()[j]).norm()));
    gained.push_back(*turned);
  }
  for (int cycle = 1; cycle < cycles; ++cycle)
    for (std::size_t k = 1; k < time.size(); ++k) {
      angles.time.push_back(time[k] + cycle * period);
      angles.angle.push_back(angle[k]);
      for (std::size_t j = 0; j < joints.size(); ++j) angles.angle.back()[j] += cycle * gained[j];
    }
}

void require_freedoms(const AngleSamples& angles, const std::string& path, const Joints& joints) {
  for (std::size_t k = 0; k < angles.time.size(); ++k)
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const int freedoms = freedoms_of(joints[j].kind);
      const Vector3d& angle = angles.angle[k][j];
      if (angle.tail(3 - freedoms).isZero(0.0)) continue;
      throw InputError(path, joints[j].name,
                       fmt::format("found [{}, {}, {}] at {} s; allowed: {} of a {} joint, zeros behind; {}", angle[0],
                                   angle[1], angle[2], angles.time[k],
                                   freedoms == 0   ? "no angle"
                                   : freedoms == 1 ? "one angle"
                                                   : "two angles",
                                   file::word(joints[j].kind), "put angles about the joint's axes first"));
    }
}

}  // namespace lamprey::result
