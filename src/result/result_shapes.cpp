#include "result/result_shapes.hpp"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace lamprey::result {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void append(double value, std::vector<double>& values) { values.push_back(value); }

void append(const Vector3d& value, std::vector<double>& values) {
  values.insert(values.end(), value.data(), value.data() + 3);
}

void append(const Matrix3d& value, std::vector<double>& values) {
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 3; ++column) values.push_back(value(row, column));
}

void require_length(const ShapedArray& array, std::size_t length, std::size_t expected) {
  if (length != expected)
    throw std::domain_error(fmt::format("{}: found {} entries, needs {}", array.path(), length, expected));
}

std::string place(const ShapedArray& array, std::size_t flat) {
  std::string indices;
  for (std::size_t axis = array.shape.size(); axis-- > 0;) {
    indices = fmt::format("[{}]", flat % array.shape[axis]) + indices;
    flat /= array.shape[axis];
  }
  return array.path() + indices;
}

void require_finite_array(const ShapedArray& array) {
  for (std::size_t i = 0; i < array.values.size(); ++i)
    if (!std::isfinite(array.values[i]))
      throw std::domain_error(fmt::format("{}: found {}, which no result may hold", place(array, i), array.values[i]));
}

// One value at each node; `tail` is the value's own shape.
template <class Value>
ShapedArray by_node(ShapedArray array, const std::vector<Value>& values, std::size_t nodes,
                    const std::vector<std::size_t>& tail) {
  require_length(array, values.size(), nodes);
  array.shape = {nodes};
  array.shape.insert(array.shape.end(), tail.begin(), tail.end());
  for (const Value& value : values) append(value, array.values);
  require_finite_array(array);
  return array;
}

// `count` values (bodies, joints) at each node.
template <class Value>
ShapedArray by_node_and_part(ShapedArray array, const std::vector<std::vector<Value>>& values, std::size_t nodes,
                             std::size_t count, const std::vector<std::size_t>& tail) {
  require_length(array, values.size(), nodes);
  array.shape = {nodes, count};
  array.shape.insert(array.shape.end(), tail.begin(), tail.end());
  for (const std::vector<Value>& parts : values) {
    require_length(array, parts.size(), count);
    for (const Value& value : parts) append(value, array.values);
  }
  require_finite_array(array);
  return array;
}

// One value at each of a scheme's stages in each step; above order 2 only, empty otherwise.
void add_stages(const maneuver::Solution& s, std::size_t steps, std::size_t joints, std::vector<ShapedArray>& arrays) {
  if (s.control_stages.empty()) return;
  const std::size_t stages = s.control_stages.front().size();
  ShapedArray control{"", "control_stages", "N m", {steps, stages, joints, 3}, {}};
  require_length(control, s.control_stages.size(), steps);
  for (const std::vector<maneuver::Vectors>& step : s.control_stages) {
    require_length(control, step.size(), stages);
    for (const maneuver::Vectors& moments : step) {
      require_length(control, moments.size(), joints);
      for (const Vector3d& moment : moments) append(moment, control.values);
    }
  }
  require_finite_array(control);
  arrays.push_back(control);
  arrays.push_back(by_node_and_part(ShapedArray{"", "stage_time", "s", {}, {}}, s.stage_time, steps, stages, {}));
}

// Gains at their own times, in rows by control.
void add_feedback(const Results& results, std::vector<ShapedArray>& arrays) {
  const maneuver::Feedback& feedback = results.solution.feedback;
  if (feedback.gain.empty()) return;
  const std::size_t controls = control_coordinates(results.problem).size();
  const std::size_t states = state_coordinates(results.problem).size();
  const std::size_t nodes = feedback.time.size();
  arrays.push_back(by_node(ShapedArray{"feedback", "time", "s", {}, {}}, feedback.time, nodes, {}));
  ShapedArray gain{"feedback", "gain", "N m by rad, m, rad/s, m/s", {nodes, controls, states}, {}};
  require_length(gain, feedback.gain.size(), nodes);
  for (const Eigen::MatrixXd& matrix : feedback.gain) {
    require_length(gain, static_cast<std::size_t>(matrix.rows()), controls);
    require_length(gain, static_cast<std::size_t>(matrix.cols()), states);
    for (Eigen::Index row = 0; row < matrix.rows(); ++row)
      for (Eigen::Index column = 0; column < matrix.cols(); ++column) gain.values.push_back(matrix(row, column));
  }
  require_finite_array(gain);
  arrays.push_back(gain);
}

}  // namespace

std::vector<ControlCoordinate> control_coordinates(const ResolvedProblem& problem) {
  std::vector<ControlCoordinate> coordinates;
  for (const ResolvedJoint& joint : problem.joints)
    for (std::size_t axis = 0; axis < joint.control_axes.size(); ++axis)
      coordinates.push_back({joint.name, static_cast<int>(axis)});
  return coordinates;
}

std::vector<StateCoordinate> state_coordinates(const ResolvedProblem& problem) {
  std::vector<StateCoordinate> coordinates;
  for (const bool rate : {false, true}) {
    for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
      const ResolvedJoint* up = nullptr;
      for (const ResolvedJoint& joint : problem.joints)
        if (static_cast<std::size_t>(joint.child) == body) up = &joint;
      const bool led = up != nullptr && up->kind != model::JointKind::ball;
      const int freedoms = !led ? 3 : up->axes ? 2 : up->axis ? 1 : 0;
      for (int axis = 0; axis < freedoms; ++axis)
        coordinates.push_back({led ? (rate ? "angle_rate" : "angle") : (rate ? "angular_velocity" : "turn"),
                               led ? up->name : problem.bodies[body].name, axis, rate ? "rad/s" : "rad"});
    }
    for (int axis = 0; axis < 3; ++axis)
      coordinates.push_back({rate ? "velocity" : "position", problem.bodies.front().name, axis, rate ? "m/s" : "m"});
  }
  return coordinates;
}

std::vector<ShapedArray> shaped_arrays(const Results& results) {
  const maneuver::Solution& s = results.solution;
  const std::size_t nodes = s.time.size();
  const std::size_t bodies = results.problem.bodies.size();
  const std::size_t joints = results.problem.joints.size();
  if (nodes != 0 && nodes != static_cast<std::size_t>(results.problem.steps) + 1)
    throw std::domain_error(
        fmt::format("time: found {} nodes, needs problem.steps + 1 = {}", nodes, results.problem.steps + 1));
  const auto named = [](std::string group, std::string name, std::string unit) {
    return ShapedArray{std::move(group), std::move(name), std::move(unit), {}, {}};
  };
  const std::string linear = "momentum/linear";
  const std::string angular = "momentum/angular";
  std::vector<ShapedArray> arrays;
  arrays.push_back(by_node(named("", "time", "s"), s.time, nodes, {}));
  arrays.push_back(by_node(named("", "position", "m"), s.position, nodes, {3}));
  arrays.push_back(by_node_and_part(named("", "rotation", "1"), s.rotation, nodes, bodies, {3, 3}));
  arrays.push_back(by_node_and_part(named("", "control", "N m"), s.control, nodes, joints, {3}));
  if (!s.joint_angle.empty())  // files of early versions have none
    arrays.push_back(by_node_and_part(named("", "joint_angle", "rad"), s.joint_angle, nodes, joints, {3}));
  add_stages(s, nodes == 0 ? 0 : nodes - 1, joints, arrays);
  arrays.push_back(by_node(named("velocity", "linear", "m/s"), s.linear_velocity, nodes, {3}));
  arrays.push_back(by_node_and_part(named("velocity", "angular", "rad/s"), s.angular_velocity, nodes, bodies, {3}));
  arrays.push_back(by_node(named(linear, "bodies", "kg m/s"), s.linear_momentum.bodies, nodes, {3}));
  arrays.push_back(by_node(named(linear, "fluid", "kg m/s"), s.linear_momentum.fluid, nodes, {3}));
  arrays.push_back(by_node(named(linear, "total", "kg m/s"), s.linear_momentum.total, nodes, {3}));
  arrays.push_back(by_node(named(angular, "bodies", "kg m²/s"), s.angular_momentum.bodies, nodes, {3}));
  arrays.push_back(by_node(named(angular, "fluid", "kg m²/s"), s.angular_momentum.fluid, nodes, {3}));
  arrays.push_back(by_node(named(angular, "total", "kg m²/s"), s.angular_momentum.total, nodes, {3}));
  add_feedback(results, arrays);
  return arrays;
}

}  // namespace lamprey::result
