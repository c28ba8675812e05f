// The continuous equations of motion by a Runge–Kutta–Fehlberg 7(8) method with step control: a second opinion on every
// scheme.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mechanics/equations_of_motion.hpp"

namespace lamprey::integrator {

/// Configuration and velocity ξ = (rates along the freedoms, ẋ).
struct ReferenceState {
  mechanics::Rotations rotation;  // [bodies] body → world
  Eigen::Vector3d position;       // m, root's mass centre, world
  Eigen::VectorXd velocity;       // [velocity_count] rad/s along the freedoms, m/s in the world
};

/// Joint moments at a time in s.
using ControlFunction = std::function<mechanics::Moments(double time)>;

/// Joint moments at a time in s and a state: a controller.
using StateControl = std::function<mechanics::Moments(double time, const ReferenceState& state)>;

/// What the method is called in result files.
std::string reference_scheme(double tolerance);

class ReferenceIntegrator {
 public:
  using Flat = std::vector<double>;  // quaternions [4 bodies], position [3], velocity [velocity_count]

  /// `tolerance`: error of a step, relative and absolute, in each component (quaternions, m, rad/s, m/s).
  ReferenceIntegrator(const model::System& system, ControlFunction control, double tolerance);
  /// The same under a controller.
  ReferenceIntegrator(const model::System& system, StateControl control, double tolerance);

  /// Carries the state from `begin` to `end`, s; moments must be smooth in between, so stop at each kink.
  /// Returns false, with the state as it was, when the step size falls to nothing or numbers leave the finite.
  bool advance(double begin, double end, ReferenceState& state);

 private:
  void rate(const Flat& y, Flat& dydt, double t);

  StateControl control_;
  double tolerance_;
  mechanics::EquationsOfMotion equations_;
  ReferenceState stage_;  // a buffer
  double step_ = 0.0;     // s, the last one that held its tolerance
};

}  // namespace lamprey::integrator
