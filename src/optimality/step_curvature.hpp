// Second derivatives of a step of the Lagrangian, the momenta's multipliers given.
#pragma once

#include "mechanics/step_balance.hpp"

namespace lamprey::optimality {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Buffers and result of one step.
class StepCurvature {
 public:
  explicit StepCurvature(const model::System& system);

  /// Of −E⁻·λ_k + E⁺·λ_{k+1} + p_x·(difference of the costates of p_x), along exponentials (equation 6.13). Costates are
  /// gradients by the states at both ends, as integrator::StateLayout.
  void evaluate(const mechanics::ForcedStep& step, const VectorXd& costate, const VectorXd& costate_next);

  /// [2 turns + 3]² symmetric: by the freedoms at k, those at k + 1 and the root's displacement over the step.
  const MatrixXd& by_motion() const { return by_motion_; }
  /// [controls][turns] by the moments u_k along Joint::actuation and the freedoms at k; by u_{k+1} and those at k + 1.
  const MatrixXd& by_control() const { return by_control_; }
  const MatrixXd& by_next_control() const { return by_next_control_; }

 private:
  void spread(const VectorXd& generalized, Eigen::Index first, mechanics::Freedoms& freedoms) const;

  const model::System& system_;
  Eigen::Index turns_;
  mechanics::StepBalance balance_;
  mechanics::StepVariation multiplier_, direction_;
  mechanics::StepRate multiplier_rate_, rate_;
  mechanics::SecondRateWorkspace second_;
  mechanics::Freedoms minus_, plus_;
  mechanics::Moments work_;
  MatrixXd by_motion_, by_control_, by_next_control_;
};

}  // namespace lamprey::optimality
