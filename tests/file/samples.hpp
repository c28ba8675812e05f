// Inputs that several tests of this room share.
#pragma once

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "result/results.hpp"

namespace lamprey::tests {

inline std::string folder_of_tests() { return std::string(LAMPREY_SOURCE_DIR) + "/tests/file/"; }

inline std::string bytes_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// A new folder under the system's temporary one, removed with all it holds when the test ends.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lamprey_test_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Numbers that all differ and have no short decimal form.
class SampleNumbers {
 public:
  double number() { return std::sin(next_ += 1.0) / 3.0; }
  Eigen::Vector3d vector() {
    Eigen::Vector3d v;
    for (double& entry : v) entry = number();
    return v;
  }
  Eigen::Matrix3d matrix() { return vector() * vector().transpose(); }

 private:
  double next_ = 0.0;
};

inline result::ResolvedProblem sample_problem(int steps, SampleNumbers& sample) {
  result::ResolvedProblem problem;
  for (const char* name : {"middle", "front", "back"})
    problem.bodies.push_back(
        {name, sample.vector().cwiseAbs(), sample.number(), sample.matrix(), sample.matrix(), sample.matrix()});
  for (int child : {1, 2})
    problem.joints.push_back({problem.bodies[static_cast<std::size_t>(child)].name,
                              model::JointKind::ball,
                              0,
                              child,
                              sample.vector(),
                              sample.vector(),
                              {sample.vector(), sample.vector()}});
  problem.joints.back().control_axes.clear();
  problem.scheme = maneuver::Scheme::paper;
  problem.cost_rule = maneuver::CostRule::rectangle;
  problem.control = maneuver::ControlKind::spline;
  problem.points = std::min(5, steps + 1);
  problem.steps = steps;
  problem.density = 0.00994718394324346;
  problem.duration = sample.number();
  problem.time_step = problem.duration / steps;
  problem.effort = sample.number();
  problem.tolerance = sample.number();
  problem.goal.emplace();
  problem.goal->move[0] = 2.0;
  problem.goal->turn = sample.vector();
  problem.goal->rotation["front"] = sample.vector();
  problem.goal->rotation["back"] = std::nullopt;
  return problem;
}

inline void sample_motion(int steps, double time_step, SampleNumbers& sample, maneuver::Solution& solution) {
  const auto vectors = [&](int count) {
    maneuver::Vectors result;
    for (int i = 0; i < count; ++i) result.push_back(sample.vector());
    return result;
  };
  for (int k = 0; k <= steps; ++k) {
    solution.time.push_back(k * time_step);
    solution.rotation.push_back({sample.matrix(), sample.matrix(), sample.matrix()});
    solution.joint_angle.push_back(vectors(2));
    solution.control.push_back(vectors(2));
    solution.angular_velocity.push_back(vectors(3));
  }
  solution.position = vectors(steps + 1);
  solution.linear_velocity = vectors(steps + 1);
  for (maneuver::MomentumHistory* momentum : {&solution.linear_momentum, &solution.angular_momentum})
    *momentum = {vectors(steps + 1), vectors(steps + 1), vectors(steps + 1)};
}

/// One node at rest, of bodies that a tree of joints holds.
inline maneuver::Solution standing(std::size_t bodies, std::size_t joints) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  maneuver::Solution solution;
  solution.time = {0.0};
  solution.position = solution.linear_velocity = {none};
  solution.rotation.emplace_back(bodies, Eigen::Matrix3d::Identity());
  solution.angular_velocity.emplace_back(bodies, none);
  solution.control.emplace_back(joints, none);
  solution.joint_angle.emplace_back(joints, none);
  solution.linear_momentum = solution.angular_momentum = {{none}, {none}, {none}};
  return solution;
}

inline std::size_t at_nodes(int steps) { return static_cast<std::size_t>(steps) + 1; }

/// Results of every field, three bodies and two joints.
inline result::Results sample_results(int steps) {
  SampleNumbers sample;
  result::Results results;
  results.name = "a \"name\" with\ttricks <é>";
  results.source = "made up";
  results.problem = sample_problem(steps, sample);
  results.problem.time_weight = sample.number();
  maneuver::Limits& limits = results.problem.limits;
  limits.torque = sample.number();
  limits.joint_torque_component["a \"joint\""] = sample.number();
  limits.angular_velocity = sample.number();
  limits.joint_angular_velocity_component["a \"joint\""] = sample.number();
  limits.swing["b"] = sample.number();
  limits.angle["c"] = {{sample.number(), sample.number()}};
  limits.angle["d"] = {{sample.number(), sample.number()}, {sample.number(), sample.number()}};
  limits.clearance = sample.number();
  limits.spheres = {{Eigen::Vector3d(sample.number(), 0.0, -1.0), sample.number()}};
  limits.half_spaces = {{Eigen::Vector3d(sample.number(), 0.0, -1.0), Eigen::Vector3d(sample.number(), 2.0, 0.0)}};
  results.problem.waypoints = {
      {sample.number(), {sample.number(), std::nullopt, 2.0}, std::nullopt, {}},
      {sample.number(), {}, Eigen::Vector3d(sample.number(), 1.0, 2.0), {{"d", Eigen::Vector3d::Zero()}}}};
  maneuver::Solution& solution = results.solution;
  solution.status = maneuver::Status::optimal;
  solution.message = "Found.";
  solution.cost = sample.number();
  sample_motion(steps, results.problem.time_step, sample, solution);
  solution.limit_multipliers = {
      {"limits.torque", 1, -1, -1, 2, true, std::vector<double>(at_nodes(steps), sample.number())}};
  solution.search = {4, 2, 3, 3, {{sample.number(), 2, 1}, {sample.number(), 1}}};
  solution.solver = {"structured",
                     7,
                     21,
                     sample.number(),
                     sample.number(),
                     sample.number(),
                     {{0, sample.number(), 0.5, 0.25, 0.125, 1e-14}, {1, 2.0, 3.0, 4.0, std::nan(""), std::nan("")}},
                     {},
                     {}};
  certificate::Certificate certificate;
  certificate.goal_error = sample.number();
  certificate.clearance = {sample.number(), sample.number(), 1, 2};
  certificate.kkt = 1e-300;
  certificate.second_order = {sample.number(), true, 0};
  certificate.all_axes = {1e-12, {-sample.number(), false, 14}};
  certificate.verdict = certificate::Verdict::proved;
  certificate.iterates_momentum = sample.number();
  certificate.refinement = {
      sample.number(), sample.number(), sample.number(), std::nan(""), {{10, sample.number()}, {20, 1.0}}};
  certificate.replay = {"dopri",         0.05,           sample.number(), sample.number(), sample.number(),
                        sample.number(), sample.number()};
  results.certificate = certificate;
  results.provenance = {
      "0.1.0", "Release", "g++", "a machine", "lamprey solve", std::string(64, 'a'), 18446744073709551615U};
  return results;
}

}  // namespace lamprey::tests
