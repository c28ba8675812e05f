// The arrays of Results, each once: name, unit, values. solution.json and trajectory.h5 are written from this list.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "result/results.hpp"

namespace lamprey::result {

/// One array as numbers in row-major order.
struct ShapedArray {
  std::string group;  // "velocity", "momentum/linear", "feedback"; empty at the top level
  std::string name;
  std::string unit;
  std::vector<std::size_t> shape;  // first entry: nodes, or steps of arrays by stage
  std::vector<double> values;

  std::string path() const { return group.empty() ? name : group + "/" + name; }
};

/// What a gain's row drives: a joint's moment along one of its control_axes.
struct ControlCoordinate {
  std::string joint;
  int axis;  // place in control_axes
};
std::vector<ControlCoordinate> control_coordinates(const ResolvedProblem& problem);

/// What a gain's column answers, in the order of integrator::deviation.
struct StateCoordinate {
  std::string quantity;  // turn, angle, position; angular_velocity, angle_rate, velocity
  std::string of;        // body; of an angle the joint
  int axis;              // of the body's frame, of the joint, of the world
  std::string unit;
};
std::vector<StateCoordinate> state_coordinates(const ResolvedProblem& problem);

/// All arrays in the interface's order. std::domain_error names an array of the wrong length or an entry that is not finite.
std::vector<ShapedArray> shaped_arrays(const Results& results);

}  // namespace lamprey::result
