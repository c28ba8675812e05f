// The equations of motion 𝕀(R) ξ̇ + bias = U + damping (chapter 2).
#pragma once

#include "mechanics/body_motion.hpp"
#include "mechanics/joint_moments.hpp"
#include "mechanics/tree_elimination.hpp"

namespace lamprey::mechanics {

/// Velocity-dependent part: what momenta change by where ξ̇ = 0.
VectorXd bias(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// Generalised force of the joints' dampers.
VectorXd damping_force(const model::System& system, const Rotations& rotation, const VectorXd& velocity);

/// ξ̇ = 𝕀⁻¹ (U + damping − bias).
VectorXd acceleration(const model::System& system, const Rotations& rotation, const VectorXd& velocity,
                      const Moments& control);

/// The same again and again: owns its workspace, no allocation after construction.
class EquationsOfMotion {
 public:
  /// `system` must outlive it.
  explicit EquationsOfMotion(const model::System& system);

  /// At velocity ξ under joint moments; in time linear in the bodies.
  void evaluate(const Rotations& rotation, const VectorXd& velocity, const Moments& control);
  /// ξ̇ [velocity_count] of the latest evaluation, rad/s² and m/s²; NaN where 𝕀 is singular.
  const VectorXd& acceleration() const { return acceleration_; }
  const BodyMotion& motion() const { return motion_; }

 private:
  const model::System& system_;
  TreeElimination inertia_;
  std::vector<BodyBlock> blocks_;  // [bodies]
  BodyMotion motion_;
  JointMoments moments_;
  Vectors turn_rate_, centre_rate_;  // [bodies] rad/s² body frames, m/s² world, where ξ̇ = 0
  Vectors force_, moment_;           // [bodies] N world, N m body frames
  Freedoms along_;                   // [bodies]
  VectorXd acceleration_;
};

}  // namespace lamprey::mechanics
