// Moments that joints exert: controls and springs at a node, dampers over a step; with their rates (equations 8.14 to 8.19).
// A ball joint's moment is a pair on parent and child, in body frames; a hinge's or universal joint's acts along its axes.
#pragma once

#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::mechanics {

/// Moments on the bodies and along the freedoms of bodies that their joints lead; zero at the start of a sum.
struct JointMoments {
  Vectors body;    // [bodies] N m (or N m s), body frames
  Freedoms along;  // [bodies] the same, about the joints' axes
  explicit JointMoments(int bodies);
  void set_zero();
};

/// As one generalised force; used up.
VectorXd gathered(const model::System& system, const Rotations& R, JointMoments& moments);

/// How the bodies turn at a node along one direction.
struct NodeTurns {
  const Freedoms& freedoms;
  const Vectors& turns;  // [bodies] body frames
};

/// Which derivative of moments along a direction is asked for.
enum class RateKind {
  tangent,  // the rate of the moments
  adjoint,  // the gradient, as moments, of their virtual work along the direction
};

/// Moments on the parents from controls along Joint::actuation, [control_count].
Moments joint_moments(const model::System& system, const Eigen::VectorXd& control);

/// What moments on the parents are along Joint::actuation, [control_count].
Eigen::VectorXd along_actuation(const model::System& system, const Moments& moments);
void along_actuation(const model::System& system, const Moments& moments, Eigen::Ref<Eigen::VectorXd> control);

/// Adds weight × (controls and springs) at a node.
void add_node_moments(const model::System& system, const Rotations& R, const Moments& control, double weight,
                      JointMoments& result);

/// Adds weight × their rates along a direction; `control_rate` may be empty (tangent) and is not used by the adjoint.
void add_node_moment_rates(const model::System& system, const Rotations& R, const Moments& control, NodeTurns along,
                           const Moments& control_rate, RateKind kind, double weight, JointMoments& result);

/// Adds weight × rates along `second` of the adjoint rates along `first`; `first_changes`: change of first.turns along
/// second.
void add_node_moment_second_rates(const model::System& system, const Rotations& R, const Moments& control,
                                  NodeTurns first, NodeTurns second, const Vectors& first_changes,
                                  const Moments& second_control_rate, double weight, JointMoments& result);

/// Moments by which controls answer to unit virtual turns: gradient of the controls' virtual work by the controls.
void control_work(const model::System& system, const Rotations& R, NodeTurns along, Moments& result);

/// Rate along `second` of control_work along `first`.
void control_work_rate(const model::System& system, const Rotations& R, NodeTurns first, NodeTurns second,
                       const Vectors& first_changes, Moments& result);

/// Turns over a step of the damped joints, and the impulses that resist them, halved: ψ⁻ at the beginning, ψ⁺ at the
/// end, both as momenta of ψ = Σ (c/4)|Δ|² (equation 8.17).
void damping_momenta(const model::System& system, const Interval& interval, JointMoments& minus, JointMoments& plus);

/// Adds weights × rates of the damping momenta along turns at both ends, those at the end counted `right_sign` times.
void add_damping_rates(const model::System& system, const Interval& interval, NodeTurns left, NodeTurns right,
                       double right_sign, double minus_weight, double plus_weight, JointMoments& minus,
                       JointMoments& plus);

/// A direction at both ends of a step, with its change along a second one.
struct StepTurns {
  NodeTurns left, right;
  double right_sign;  // with which the right end counts
};

/// Adds weights × rates along `second` of the damping momenta's rates along `first`.
void add_damping_second_rates(const model::System& system, const Interval& interval, const StepTurns& first,
                              const StepTurns& second, const Vectors& first_left_changes,
                              const Vectors& first_right_changes, double minus_weight, double plus_weight,
                              JointMoments& minus, JointMoments& plus);

/// Derivative of damping momenta at the beginning by the joints' turns at the end, along the freedoms: what
/// TreeElimination takes as damping.
void damping_blocks(const model::System& system, const Interval& interval, std::vector<Matrix3d>& blocks);

/// Derivative by each sprung joint's stiffness of the springs' virtual work along a direction, added `weight` times; [joints].
void add_spring_work(const model::System& system, const Rotations& R, NodeTurns along, double weight, VectorXd& result);

/// Derivative by each damped joint's damping of −ψ⁻·left − ψ⁺·right, added to [joints].
void add_damping_work(const model::System& system, const Interval& interval, NodeTurns left, NodeTurns right,
                      VectorXd& result);

/// Virtual work of moments along a direction.
double virtual_work(const JointMoments& moments, NodeTurns along);

/// Potential energy of the springs, J.
double spring_energy(const model::System& system, const Rotations& R);

}  // namespace lamprey::mechanics
