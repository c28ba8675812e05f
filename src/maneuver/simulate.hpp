// Marching a problem's swimmer under given moments.
#pragma once

#include <functional>

#include "integrator/feedback_law.hpp"
#include "maneuver/node_path.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "mechanics/continuous.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

using ControlFunction = std::function<mechanics::Moments(double)>;  // s → [joints] N m, as mechanics::Moments says

/// No moments at any time.
ControlFunction no_control(const model::System& system);

/// Joint moments of vectors on the parents in the parents' frames with every joint at its zero angle, [joints] N m: of a
/// hinge the part along its axis a, of a universal joint the parts along its first axis a and its second one Q_0 b.
mechanics::Moments moments_at_zero_angle(const model::System& system, const Vectors& on_parent);

/// Moments that run, within each step of an earlier march, as the polynomial through its stage nodes; beyond the ends the
/// end values. `time` [steps × stages] s and `samples` [steps × stages], step after step, each from its beginning to its
/// end in the order of the scheme's nodes, which are distinct.
ControlFunction stage_polynomials(const std::vector<double>& time, const std::vector<mechanics::Moments>& samples,
                                  std::size_t stages);

struct SimulateOptions {
  bool adaptive = false;              // divide steps that do not converge
  std::function<bool()> interrupted;  // asked at every step; may be empty
  /// A controller that answers the state, affine in the velocity, in place of the moments in time; may be empty.
  integrator::StateControl feedback = {};
  integrator::MotorFunction given = {};  // of what it asks for; may be empty
  /// A motion under the same moments in steps of the same length and scheme, one after the other, again and again where the
  /// march is longer. While the bodies stand to each other as they do in it, steps are sought from its own on: after impulses
  /// the last ones are no guide. Wherever it lies and however it is headed; rotations, of as many bodies, and positions count.
  /// Of schemes with one stage; may be null.
  const NodePath* motion = nullptr;
};

/// Marches from the problem's start by its scheme, duration and steps, the controls sampled at the nodes of all stages.
/// Moments act within the joints' actuated directions only. A step that does not converge is, if `adaptive`, divided in
/// halves as often as needed, into 4096 substeps at most; the next one is taken whole again. Where that does not help
/// either the march ends: status stalled, the message names step, time, residual and a shorter step that works from
/// there, and the arrays hold the nodes before it.
Solution simulate(const model::System& system, const Problem& problem, const ControlFunction& control,
                  const SimulateOptions& options);

/// The same by the reference integrator of the continuous equations in place of the problem's scheme, whose steps are the
/// nodes of the result; nothing is divided. `tolerance`: of ReferenceIntegrator.
Solution simulate_by_reference(const model::System& system, const Problem& problem, const ControlFunction& control,
                               const SimulateOptions& options, double tolerance = 1e-12);

/// The same without dividing steps.
Solution simulate(const model::System& system, const Problem& problem, const ControlFunction& control,
                  const std::function<bool()>& interrupted);

}  // namespace lamprey::maneuver
