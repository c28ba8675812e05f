// Motion down the tree and moments up the tree: how the freedoms of the joints turn the bodies, and what moments and
// forces on the bodies do along the freedoms, with their first and second rates (chapter 8, equations 8.2 to 8.7).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "lie/so3.hpp"
#include "model/system.hpp"

namespace lamprey::mechanics {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Rotations = std::vector<Matrix3d>;  // [bodies] body → world
using Vectors = std::vector<Vector3d>;    // [bodies], as each name says
/// [bodies] along each body's freedoms: a turn in its own frame, or turns about its joint's axes; entries beyond are 0.
using Freedoms = std::vector<Vector3d>;

/// Q = R_pᵀ R_c of a joint.
inline Matrix3d child_to_parent(const Rotations& R, const model::Joint& joint) {
  return R[model::at(joint.parent)].transpose() * R[model::at(joint.child)];
}

/// A joint that leads its child: where its axes lie now.
struct JointFrame {
  Matrix3d child_to_parent;  // Q = R_pᵀ R_c
  Matrix3d axes;             // S, columns in the child's frame; those beyond the joint's freedoms are zero
};

JointFrame joint_frame(const model::Joint& joint, const Matrix3d& R_parent, const Matrix3d& R_child);

/// Directions in the child's frame along which damping of the joint acts: its axes, or all three of a ball joint.
inline Matrix3d damped_axes(const model::Joint& joint, const JointFrame& frame) {
  return joint.free() ? Matrix3d(Matrix3d::Identity()) : frame.axes;
}

/// Spreads a generalised vector over the bodies; its last three entries are left out.
void unpack(const model::System& system, const VectorXd& generalized, Freedoms& freedoms);

/// Writes freedoms and the position's part as one generalised vector, [velocity_count].
void pack(const model::System& system, const Freedoms& freedoms, const Vector3d& linear, VectorXd& generalized);

/// Angles of the joint to body i's parent about its axes, rad in (−π, π]; entries beyond its freedoms are 0.
Vector3d joint_angles(const model::Joint& joint, const Matrix3d& child_to_parent);

/// How far a joint has turned from its zero angle, rad: the angles of a hinge or universal joint about its axes, of a ball joint
/// the rotation vector log(Q Q_0ᵀ), parent's frame. Of the values that mean the same turn, the one next to `before`: along a
/// motion whole turns add up.
Vector3d turn_from_zero(const model::Joint& joint, const Matrix3d& child_to_parent, const Vector3d& before);

/// Q of a joint of any kind at such a turn.
Matrix3d rotation_at_turn(const model::Joint& joint, const Vector3d& turn);

/// Rotations of all bodies as the root sees them, with the joints at such turns, [joints].
Rotations shape_at_turns(const model::System& system, const Vectors& turn);

/// Q = R_pᵀ R_c of a joint that leads its child, at angles about its axes (equation 8.1).
Matrix3d joint_rotation(const model::Joint& joint, const Vector3d& angles);

/// The turn of a joint from one Q to another, rad: of a ball joint a rotation vector, child's frame, of others the change of the
/// angles about their axes, the shorter way round; and Q after such a turn.
Vector3d turn_between(const model::Joint& joint, const Matrix3d& from, const Matrix3d& to);
Matrix3d turned_by(const model::Joint& joint, const Matrix3d& from, const Vector3d& turn);

/// Body-frame turns η_i of all bodies along freedoms (equation 8.3).
void body_turns(const model::System& system, const Rotations& R, const Freedoms& freedoms, Vectors& turns);

/// Body-frame turn of one body by all freedoms, [3][velocity_count − 3].
MatrixXd turn_by_freedoms(const model::System& system, const Rotations& R, int body);
/// The same into a matrix of that size.
void set_turn_by_freedoms(const model::System& system, const Rotations& R, int body, MatrixXd& turn);

/// Change of the turns along `first` (constant freedoms) when the bodies turn along `second` (equation 8.4).
void body_turn_changes(const model::System& system, const Rotations& R, const Freedoms& first,
                       const Vectors& first_turns, const Freedoms& second, Vectors& changes);

/// Sums world forces over subtrees, in place: [bodies] N or the like.
void sum_subtrees(const model::System& system, Vectors& force);

/// Carries moments up the tree (equation 8.5). `moment` [bodies], body frames: each body's own about its mass centre
/// on entry, the moment through its joint on return; `force` [bodies], world: sums over subtrees.
void gather(const model::System& system, const Rotations& R, const Vectors& force, Vectors& moment, Freedoms& result);

/// Forces (world) and moments (body frames) on the bodies as one generalised force; both are used up.
VectorXd gathered(const model::System& system, const Rotations& R, Vectors& force, Vectors& moment);

/// What gather returned, and how turns, moments and forces change along one direction.
struct GatherRate {
  const Freedoms& freedoms;  // along which the bodies turn
  const Vectors& turns;      // body-frame turns along them
  const Vectors& force;      // rate of the subtree forces, world
};

/// Rate of gather's result along a direction (equation 8.6). `moment_rate` is as `moment` of gather: own rates on
/// entry, rates of the joints' moments on return.
void gather_rate(const model::System& system, const Rotations& R, const Vectors& force, const Vectors& moment,
                 const GatherRate& along, Vectors& moment_rate, Freedoms& result);

/// Rate along `second` of gather's rate along `first` (equation 8.7). `first_changes`: change of first.turns along
/// second; `force_second`: second rates of the subtree forces; moment rates as returned by gather_rate; `moment_second`
/// as `moment_rate`.
void gather_second_rate(const model::System& system, const Rotations& R, const Vectors& force, const Vectors& moment,
                        const GatherRate& first, const Vectors& first_moment, const GatherRate& second,
                        const Vectors& second_moment, const Vectors& first_changes, const Vectors& force_second,
                        Vectors& moment_second, Freedoms& result);

}  // namespace lamprey::mechanics
