#include "mechanics/connection.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "lie/so3.hpp"

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

// Each of the joints' rates by itself, joint after joint: [f][joints][3].
std::vector<Vectors> unit_rates(const System& system) {
  std::vector<Vectors> rates;
  for (int j = 0; j < system.joint_count(); ++j)
    for (int c = 0; c < system.body(system.joint(j).child).freedoms; ++c) {
      rates.emplace_back(at(system.joint_count()), Vector3d::Zero());
      rates.back()[at(j)] = Vector3d::Unit(c);
    }
  return rates;
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

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// [S, T] of twists: how T changes that is carried along S.
Twist bracket(const Twist& S, const Twist& T) {
  const Vector3d turn = S.head<3>(), shift = S.tail<3>(), other = T.head<3>();
  Twist result;
  result << turn.cross(other), turn.cross(T.tail<3>()) + shift.cross(other);
  return result;
}

// ad_Sᵀ of a momentum (angular, linear), which has the same power with T as the momentum has with [S, T].
Twist transposed_bracket(const Twist& S, const Twist& momentum) {
  const Vector3d turn = S.head<3>(), shift = S.tail<3>(), angular = momentum.head<3>(), linear = momentum.tail<3>();
  Twist result;
  result << -turn.cross(angular) - shift.cross(linear), -turn.cross(linear);
  return result;
}

// A motion of the joints as the root sees it while it stands.
struct Motion {
  Vectors rate;              // [joints][3] rad/s, as turned_by_joints has them
  std::vector<Twist> twist;  // [bodies]
  Twist root;                // what it moves the root by
};

// Where the bodies are and what moves them, all as the root sees it.
class SeenFromRoot {
 public:
  SeenFromRoot(const System& system, const Rotations& R)
      : system_(system), rotation_(R.size()), centre_(R.size(), Vector3d::Zero()), inertia_(R.size()) {
    Matrix6d locked = Matrix6d::Zero();
    for (int i : system.root_to_leaves()) {
      rotation_[at(i)] = R[0].transpose() * R[at(i)];
      place(i);
      locked += inertia_[at(i)];
    }
    locked_.compute(locked);
    for (int j = 0; j < system.joint_count(); ++j) axes_.push_back(axes_of(system.joint(j)));
  }

  Motion motion(const Vectors& rate) const {
    Motion motion{rate, {inertia_.size(), Twist::Zero()}, Twist::Zero()};
    Twist momentum = Twist::Zero();
    for (int i : system_.root_to_leaves()) {
      const model::Body& body = system_.body(i);
      if (body.parent < 0) continue;
      motion.twist[at(i)] = motion.twist[at(body.parent)] + by_joint(body.joint, motion.rate[at(body.joint)]);
      momentum += inertia_[at(i)] * motion.twist[at(i)];
    }
    motion.root = -locked_.solve(momentum);
    return motion;
  }

  /// Equation 9.29.
  Twist loop(const Motion& a, const Motion& b) const {
    return rate(b, a) - rate(a, b) + bracket(a.root, b.root) - motion_of_commutator(a, b);
  }

 private:
  void place(int i) {
    const model::Body& body = system_.body(i);
    if (body.parent >= 0)
      centre_[at(i)] = hub(system_.joint(body.joint)) - rotation_[at(i)] * system_.joint(body.joint).child_offset;
    Matrix6d own, seen = Matrix6d::Zero();
    own << body.inertia_matrix, body.coupling_matrix.transpose(), body.coupling_matrix, body.mass_matrix;
    seen.topLeftCorner<3, 3>() = seen.bottomRightCorner<3, 3>() = rotation_[at(i)].transpose();
    seen.bottomLeftCorner<3, 3>() = -rotation_[at(i)].transpose() * lie::hat(centre_[at(i)]);
    inertia_[at(i)] = seen.transpose() * own * seen;
  }

  Vector3d hub(const model::Joint& joint) const {
    return centre_[at(joint.parent)] + rotation_[at(joint.parent)] * joint.parent_offset;
  }

  Matrix3d axes_of(const model::Joint& joint) const {
    const Matrix3d &parent = rotation_[at(joint.parent)], &turned = rotation_[at(joint.child)];
    return joint.free() ? parent : Matrix3d(turned * joint_frame(joint, parent, turned).axes);
  }

  // The twist that a joint at this rate gives all bodies beyond it.
  Twist by_joint(int joint, const Vector3d& joint_rate) const {
    const Vector3d turn = axes_[at(joint)] * joint_rate;
    Twist twist;
    twist << turn, hub(system_.joint(joint)).cross(turn);
    return twist;
  }

  // How that of b changes along a: with the parent, and a universal joint's second axis with its first.
  Twist by_joint_rate(int joint, const Motion& b, const Motion& a) const {
    const Vector3d &of = b.rate[at(joint)], &moved = a.rate[at(joint)];
    Twist change = bracket(a.twist[at(system_.joint(joint).parent)], by_joint(joint, of));
    if (system_.joint(joint).kind == model::JointKind::universal)
      change += bracket(by_joint(joint, Vector3d(moved[0], 0.0, 0.0)), by_joint(joint, Vector3d(0.0, of[1], 0.0)));
    return change;
  }

  // How what b moves the root by changes along a: momentum stays zero while inertias are carried along (9.30).
  Twist rate(const Motion& b, const Motion& a) const {
    std::vector<Twist> twist_rate(inertia_.size(), Twist::Zero());
    Twist momentum = Twist::Zero();
    for (int i : system_.root_to_leaves()) {
      const model::Body& body = system_.body(i);
      if (body.parent < 0) continue;
      twist_rate[at(i)] = twist_rate[at(body.parent)] + by_joint_rate(body.joint, b, a);
      const Matrix6d& own = inertia_[at(i)];
      const Twist whole = b.twist[at(i)] + b.root;
      momentum +=
          own * (twist_rate[at(i)] - bracket(a.twist[at(i)], whole)) - transposed_bracket(a.twist[at(i)], own * whole);
    }
    return -locked_.solve(momentum);
  }

  // What X_a X_b − X_b X_a moves the root by, which vanishes but between rates of one ball joint.
  Twist motion_of_commutator(const Motion& a, const Motion& b) const {
    Vectors rate(a.rate.size(), Vector3d::Zero());
    bool any = false;
    for (int j = 0; j < system_.joint_count(); ++j) {
      if (!system_.joint(j).free()) continue;
      rate[at(j)] = -a.rate[at(j)].cross(b.rate[at(j)]);
      any = any || !rate[at(j)].isZero(0.0);
    }
    return any ? motion(rate).root : Twist(Twist::Zero());
  }

  const System& system_;
  Rotations rotation_;             // [bodies] body → root
  Vectors centre_;                 // [bodies] m, mass centres from the root's
  std::vector<Matrix6d> inertia_;  // [bodies] by twists
  Rotations axes_;                 // [joints] by rates
  Eigen::LDLT<Matrix6d> locked_;   // inertia of all
};

}  // namespace

LocalConnection local_connection(const System& system, const Rotations& rotation) {
  std::vector<VectorXd> columns;
  for (const Vectors& rate : unit_rates(system))
    columns.push_back(velocity_of_bodies(system, rotation, turned_by_joints(system, rotation, rate), Vector3d::Zero()));
  MatrixXd shape(system.velocity_count(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) shape.col(static_cast<Eigen::Index>(c)) = columns[c];
  const MatrixXd rigid = moved_as_one(system, rotation), inertia = generalized_inertia(system, rotation);
  // momentum of the whole along the rigid motions is rigidᵀ 𝕀 ξ
  const MatrixXd momentum = rigid.transpose() * inertia;
  const MatrixXd locked = momentum * rigid, coupling = momentum * shape;
  MatrixXd root = -locked.partialPivLu().solve(coupling);
  root.array() += 0.0;  // no minus zeros
  const MatrixXd whole = shape + rigid * root;
  return {root.topRows(3), root.bottomRows(3), whole.transpose() * inertia * whole};
}

Twist moved_root(const System& system, const Rotations& rotation, const Vectors& rate) {
  return SeenFromRoot(system, rotation).motion(rate).root;
}

Twist moved_by_loop(const System& system, const Rotations& rotation, const Vectors& first, const Vectors& second) {
  const SeenFromRoot seen(system, rotation);
  return seen.loop(seen.motion(first), seen.motion(second));
}

ConnectionCurvature connection_curvature(const System& system, const Rotations& rotation) {
  const SeenFromRoot seen(system, rotation);
  std::vector<Motion> motions;
  for (const Vectors& rate : unit_rates(system)) motions.push_back(seen.motion(rate));
  const auto f = static_cast<Eigen::Index>(motions.size());
  ConnectionCurvature curvature;
  curvature.turn.fill(MatrixXd::Zero(f, f));
  curvature.shift.fill(MatrixXd::Zero(f, f));
  for (Eigen::Index a = 0; a < f; ++a)
    for (Eigen::Index b = 0; b < a; ++b) {
      const Twist loop = seen.loop(motions[static_cast<std::size_t>(a)], motions[static_cast<std::size_t>(b)]);
      for (std::size_t k = 0; k < 3; ++k) {
        curvature.turn[k](a, b) = loop[static_cast<Eigen::Index>(k)];
        curvature.turn[k](b, a) = -curvature.turn[k](a, b);
        curvature.shift[k](a, b) = loop[static_cast<Eigen::Index>(3 + k)];
        curvature.shift[k](b, a) = -curvature.shift[k](a, b);
      }
    }
  for (std::size_t k = 0; k < 3; ++k) {  // no minus zeros
    curvature.turn[k].array() += 0.0;
    curvature.shift[k].array() += 0.0;
  }
  return curvature;
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
