// Motions by schemes above order 2. Their nodes alone do not tell whether the steps between them obey the law, so each step
// is marched again, from its stored node and under the stored moments of its stages, to where the next node should be.
#pragma once

#include <optional>

#include "evidence/stored_motion.hpp"
#include "mechanics/step_balance.hpp"

namespace lamprey::evidence {

struct StageMotion {
  int stages;
  int terms;                                  // coefficients of each moment in a step
  std::vector<double> time_step;              // [stages] s, some negative
  std::vector<double> fraction;               // [stages + 1] of the step, at the stages' nodes
  std::vector<integrator::State> node;        // [N+1] as stored: momenta of the stored velocities
  std::vector<mechanics::Interval> interval;  // [N · stages]
  std::vector<mechanics::Moments> control;    // [N · (stages + 1)] along the joints
  std::vector<VectorXd> polynomial;           // [N][terms · controls] nearest to the stored moments
  double momentum_error;       // kg m²/s, largest part of the difference of a marched end from the next node
  double configuration_error;  // rad, of positions by the unit of length, likewise
  double
      actuation_error;  // largest part of a stored moment outside the actuation, or what a node has beside the mean of
                        // both its sides / largest moment
  double
      polynomial_error;  // largest distance of a stored moment from the steps' polynomials / largest moment; 0 without these
  double time_error;  // s, of the stages' stored times
};

/// Nothing for other schemes, without stored stages, where a march divided its steps and where a step does not converge.
std::optional<StageMotion> march_again(const StoredMotion& motion);

/// The same without intervals and polynomials, which long marches would fill the memory with; where a step does not converge
/// its error is infinite.
std::optional<StageMotion> check_march(const StoredMotion& motion);

/// Stage s of step k.
mechanics::ForcedStep forced_stage(const StoredMotion& motion, const StageMotion& stages, int k, int s);

/// Moments of a step's polynomials at a fraction of it, [joints] along the joints.
mechanics::Moments moments_of_step(const StoredMotion& motion, const StageMotion& stages, int k, double fraction);

/// Largest change of what the march of the steps left open: of the momenta in units of `scale`, of rotations in rad and positions by the unit of length;
/// with what the first node's momentum differs from the problem's.
double step_residual(const StoredMotion& motion, const StageMotion& stages, double scale);

/// The effort by the problem's weight, (N m)² s.
double cost_of_steps(const StoredMotion& motion, const StageMotion& stages);

}  // namespace lamprey::evidence
