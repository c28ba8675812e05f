#include "mechanics/connection.hpp"

#include <Eigen/LU>

namespace lamprey::mechanics {

namespace {

using model::at;
using model::System;

// Angular velocities of the bodies, body frames, where the root stands still and the joints turn.
Vectors turned_by_joints(const System& system, const Rotations& R, const Vectors& rate) {
  Vectors angular(R.size(), Vector3d::Zero());
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent < 0) continue;
    const model::Joint& joint = system.joint(body.joint);
    const JointFrame frame = joint_frame(joint, R[at(body.parent)], R[at(i)]);
    angular[at(i)] = frame.child_to_parent.transpose() * angular[at(body.parent)];
    const Vector3d& own = rate[at(body.joint)];
    angular[at(i)] += joint.free() ? Vector3d(frame.child_to_parent.transpose() * own) : Vector3d(frame.axes * own);
  }
  return angular;
}

// The whole, stiff, turned and shifted: a column for each of the root's velocities, Ω then ẋ, both along its frame.
MatrixXd moved_as_one(const System& system, const Rotations& R) {
  MatrixXd velocity(system.velocity_count(), 6);
  for (int c = 0; c < 3; ++c) {
    const Vector3d axis = R[0].col(c);
    Vectors angular;
    for (const Matrix3d& own : R) angular.emplace_back(own.transpose() * axis);
    velocity.col(c) = velocity_of_bodies(system, R, angular, Vector3d::Zero());
    velocity.col(3 + c) = velocity_of_bodies(system, R, Vectors(R.size(), Vector3d::Zero()), axis);
  }
  return velocity;
}

}  // namespace

LocalConnection local_connection(const System& system, const Rotations& rotation) {
  std::vector<VectorXd> columns;
  for (int j = 0; j < system.joint_count(); ++j)
    for (int c = 0; c < system.body(system.joint(j).child).freedoms; ++c) {
      Vectors rate(at(system.joint_count()), Vector3d::Zero());
      rate[at(j)] = Vector3d::Unit(c);
      columns.push_back(
          velocity_of_bodies(system, rotation, turned_by_joints(system, rotation, rate), Vector3d::Zero()));
    }
  MatrixXd shape(system.velocity_count(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) shape.col(static_cast<Eigen::Index>(c)) = columns[c];
  const MatrixXd rigid = moved_as_one(system, rotation), inertia = generalized_inertia(system, rotation);
  // momentum of the whole along the rigid motions is rigidᵀ 𝕀 ξ
  const MatrixXd momentum = rigid.transpose() * inertia;
  const MatrixXd locked = momentum * rigid, coupling = momentum * shape;
  const MatrixXd root = -locked.partialPivLu().solve(coupling);
  const MatrixXd whole = shape + rigid * root;
  return {root.topRows(3), root.bottomRows(3), whole.transpose() * inertia * whole};
}

VectorXd with_momentum(const System& system, const Rotations& rotation, const Vector3d& position,
                       const VectorXd& velocity, const SpatialMomentum& total) {
  const MatrixXd rigid = moved_as_one(system, rotation);
  const MatrixXd momentum = rigid.transpose() * generalized_inertia(system, rotation);
  VectorXd asked(6);
  asked << rotation[0].transpose() * (total.angular - position.cross(total.linear)),
      rotation[0].transpose() * total.linear;
  asked -= momentum * velocity;
  const MatrixXd locked = momentum * rigid;
  return velocity + rigid * VectorXd(locked.partialPivLu().solve(asked));
}

VectorXd velocity_of_rates(const System& system, const Rotations& rotation, const Vector3d& position,
                           const Vectors& rate, const SpatialMomentum& total) {
  const Vectors angular = turned_by_joints(system, rotation, rate);
  return with_momentum(system, rotation, position, velocity_of_bodies(system, rotation, angular, Vector3d::Zero()),
                       total);
}

}  // namespace lamprey::mechanics
