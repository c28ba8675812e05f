// Following a motion: moments that answer how far a swimmer is off it (chapter 11).
#pragma once

#include <functional>
#include <vector>

#include "integrator/reference_integrator.hpp"
#include "integrator/step.hpp"

namespace lamprey::integrator {

using Eigen::MatrixXd;

/// Moments that motors give, [joints] N m, of those asked for.
using MotorFunction = std::function<Moments(const Moments& asked)>;

/// A motion known at nodes.
struct NodeMotion {
  std::vector<double> time;           // [N+1] s, rising
  std::vector<ReferenceState> state;  // [N+1]
};

/// A motion between its nodes: joint angles, position and the turn of each body that turns on its own run as cubics
/// through the nodes' values and velocities (equation 11.9). Beyond the ends it stands.
class MotionPath {
 public:
  /// `system` must outlive the path.
  MotionPath(const model::System& system, NodeMotion motion);
  ReferenceState at_time(double time) const;
  double begin() const { return motion_.time.front(); }
  double end() const { return motion_.time.back(); }
  const model::System& system() const { return system_; }

 private:
  const model::System& system_;
  NodeMotion motion_;
};

/// How far a state is off another, [2 velocity_count]: turns of bodies that turn on their own (rad, body frame), changes
/// of the others' joint angles (rad), the root's shift (m, world); then the differences of the velocities ξ, in the same
/// order (rad/s, body frame; rad/s; m/s, world) (equation 11.1).
VectorXd deviation(const model::System& system, const ReferenceState& from, const ReferenceState& state);

/// u(t) = u*(t) + K(t) s(t): planned moments, and gains that answer the deviation s from the planned path.
class FeedbackLaw {
 public:
  /// `gain` [M+1][controls][2 velocity_count] at the times `gain_time` [M+1], linear between; controls count along
  /// Joint::actuation of the path's system. `planned`: moments of the path.
  FeedbackLaw(MotionPath path, ControlFunction planned, std::vector<double> gain_time, std::vector<MatrixXd> gain);

  Moments moments(double time, const ReferenceState& state) const;
  Moments planned(double time) const { return planned_(time); }
  MatrixXd gain(double time) const;
  const MotionPath& path() const { return path_; }

 private:
  MotionPath path_;
  ControlFunction planned_;
  std::vector<double> gain_time_;
  std::vector<MatrixXd> gain_;
};

/// The moments that a controller asks for at a stage's end, where the velocity that it answers holds half of their own
/// impulse; [joints], what the joints cannot exert left out. `state` is what a stage of length `time_step` under `used` has
/// left; its momentum becomes that under the moments returned. The controller must be affine in the velocity
/// (equation 11.10). `given`: what motors give of what it asks for; may be empty.
Moments settled_moments(const model::System& system, const StateControl& controller, const MotorFunction& given,
                        double time, double time_step, const Moments& used, State& state);

/// What the joints can exert of the moments, [joints] N m.
Moments exerted(const model::System& system, Moments moments);

}  // namespace lamprey::integrator
