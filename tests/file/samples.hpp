// Inputs that several tests of this room share.
#pragma once

#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "file/results.hpp"

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

/// Results of every field, three bodies and two joints; each number differs from the others and has no short decimal form.
inline file::Results sample_results(int steps) {
  double next = 0.0;
  const auto number = [&next] { return std::sin(next += 1.0) / 3.0; };
  const auto vector = [&] { return Eigen::Vector3d(number(), number(), number()); };
  const auto matrix = [&] { return Eigen::Matrix3d(vector() * vector().transpose()); };
  file::Results results;
  results.name = "a \"name\" with\ttricks <é>";
  results.source = "made up";
  for (const char* name : {"middle", "front", "back"}) {
    file::ResolvedBody body;
    body.name = name;
    body.semi_axes = vector();
    body.mass = number();
    body.body_inertia = matrix();
    body.mass_matrix = matrix();
    body.inertia_matrix = matrix();
    results.problem.bodies.push_back(body);
  }
  for (int child : {1, 2}) {
    file::ResolvedJoint joint;
    joint.name = child == 1 ? "front" : "back";
    joint.child = child;
    joint.parent_offset = vector();
    joint.child_offset = vector();
    joint.control_axes = {vector(), vector()};
    results.problem.joints.push_back(joint);
  }
  results.problem.joints.back().control_axes.clear();
  results.problem.scheme = maneuver::Scheme::paper;
  results.problem.cost_rule = maneuver::CostRule::rectangle;
  results.problem.control = maneuver::ControlKind::spline;
  results.problem.points = 5;
  results.problem.steps = steps;
  results.problem.duration = number();
  results.problem.time_step = results.problem.duration / steps;
  maneuver::Goal goal;
  goal.move[0] = 2.0;
  goal.turn = vector();
  goal.rotation["front"] = vector();
  goal.rotation["back"] = std::nullopt;
  results.problem.goal = goal;
  maneuver::Solution& solution = results.solution;
  solution.status = maneuver::Status::optimal;
  solution.message = "Found.";
  solution.cost = number();
  for (int k = 0; k <= steps; ++k) {
    solution.time.push_back(k * results.problem.time_step);
    solution.position.push_back(vector());
    solution.rotation.push_back({matrix(), matrix(), matrix()});
    solution.control.push_back({vector(), vector()});
    solution.linear_velocity.push_back(vector());
    solution.angular_velocity.push_back({vector(), vector(), vector()});
    for (maneuver::MomentumHistory* momentum : {&solution.linear_momentum, &solution.angular_momentum}) {
      momentum->bodies.push_back(vector());
      momentum->fluid.push_back(vector());
      momentum->total.push_back(vector());
    }
  }
  solution.search = {4, 3, {{number(), 2}, {number(), 1}}};
  solution.solver = {"structured",
                     7,
                     21,
                     number(),
                     {{0, number(), number(), number(), number()}, {1, number(), number(), number(), std::nan("")}}};
  certificate::Certificate certificate;
  certificate.goal_error = number();
  certificate.kkt = 1e-300;
  certificate.second_order = {number(), true};
  certificate.replay = {"dopri", number(), number(), number(), number(), number(), number()};
  results.certificate = certificate;
  results.provenance = {
      "0.1.0", "Release", "g++", "a machine", "lamprey solve", std::string(64, 'a'), 18446744073709551615U};
  return results;
}

}  // namespace lamprey::tests
