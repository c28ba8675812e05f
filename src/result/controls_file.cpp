#include "result/controls_file.hpp"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/QR>

#include "document/text_file.hpp"
#include "document/toml_document.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "maneuver/control_path.hpp"
#include "model/input_error.hpp"
#include "model/system.hpp"
#include "result/followed_file.hpp"
#include "result/joint_table.hpp"
#include "result/solution_file.hpp"

namespace lamprey::result {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::InputError;

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
    if (joint.kind != file::JointKind::universal) continue;
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

}  // namespace

ControlSamples controls_of_results(const Results& results, const std::string& path, const Joints& joints) {
  require_motion_of(joints, results, path);
  ControlSamples samples;
  const bool spline = results.problem.control == maneuver::ControlKind::spline;
  const bool stages = !spline && !results.solution.control_stages.empty();
  samples.source = spline ? ControlSource::spline : stages ? ControlSource::stages : ControlSource::steps;
  if (stages) {
    take_stages(results, samples);
  } else {
    take_nodes(results, samples);
    for (const ResolvedJoint& joint : results.problem.joints) samples.links.emplace_back(joint.parent, joint.child);
    if (results.solution.divided.steps == 0 && results.solution.marched_by.empty()) {
      samples.motion.rotation = results.solution.rotation;
      samples.motion.position = results.solution.position;
    }
  }
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
  JointTable table = parse_joint_table(TableKind::moments, bytes, path, joints);
  ControlSamples samples;
  if (bytes.starts_with(exported_moments)) samples.source = ControlSource::lines;
  samples.time = std::move(table.time);
  samples.control = std::move(table.value);
  samples.remark = std::move(table.remark);
  return samples;
}

void require_period(const std::string& path, const Joints& joints, const ControlSamples& table) {
  constexpr double same = 1e-6;  // of the largest moment, and of the period
  if (std::abs(table.time.front()) > same * table.time.back())
    throw InputError(
        path, "t",
        fmt::format("found a first time of {} s; allowed: 0 s, where cycles repeat; begin there", table.time.front()));
  double largest = 0.0;
  for (const auto& row : table.control)
    for (const Vector3d& moment : row) largest = std::max(largest, moment.lpNorm<Eigen::Infinity>());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const double off = (table.control.back()[j] - table.control.front()[j]).lpNorm<Eigen::Infinity>();
    if (off > same * largest)
      throw InputError(
          path, joints[j].name,
          fmt::format("found {:.3g} N m between its last and its first moment; allowed: none, where cycles "
                      "repeat; end with the moments that it begins with, or leave cycles out",
                      off));
  }
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
  if (joints == 0) return {};
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
  const std::string file = document::motion_file(path);
  return parse_controls(document::read_bytes(file, table_byte_limit), file, joints);
}

}  // namespace lamprey::result
