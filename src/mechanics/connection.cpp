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

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The twist (ω, v) that one rate of a joint gives all bodies beyond it, as the root sees it.
struct JointScrew {
  int joint;
  int axis;
  Vector6d twist;
};

// [S, T] of twists: how T changes that is carried along S.
Vector6d bracket(const Vector6d& S, const Vector6d& T) {
  const Vector3d turn = S.head<3>(), shift = S.tail<3>(), other = T.head<3>();
  Vector6d result;
  result << turn.cross(other), turn.cross(T.tail<3>()) + shift.cross(other);
  return result;
}

Matrix6d bracket_matrix(const Vector6d& S) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = lie::hat(S.head<3>());
  ad.bottomLeftCorner<3, 3>() = lie::hat(S.tail<3>());
  return ad;
}

// Where the bodies are and what moves them, all as the root sees it.
class SeenFromRoot {
 public:
  SeenFromRoot(const System& system, const Rotations& R)
      : system_(system), rotation_(R.size()), centre_(R.size(), Vector3d::Zero()), beyond_(R.size(), Matrix6d::Zero()) {
    for (std::size_t i = 0; i < R.size(); ++i) rotation_[i] = R[0].transpose() * R[i];
    const std::vector<int>& outwards = system.root_to_leaves();
    for (int i : outwards) place(i);
    for (auto i = outwards.rbegin(); i != outwards.rend(); ++i) gather_inertia(*i);
    for (int j = 0; j < system.joint_count(); ++j) add_screws(j);
  }

  const std::vector<JointScrew>& screws() const { return screws_; }
  const Matrix6d& inertia() const { return beyond_[0]; }
  const Matrix6d& inertia_beyond(const JointScrew& screw) const { return beyond_[at(child(screw))]; }

  /// How the inertia beyond one joint changes as another moves.
  Matrix6d inertia_rate(const JointScrew& of, const JointScrew& moved) const {
    if (is_beyond(child(moved), child(of))) return carried(beyond_[at(child(of))], moved);
    if (is_beyond(child(of), child(moved))) return carried(beyond_[at(child(moved))], moved);
    return Matrix6d::Zero();
  }
  /// And that of the whole.
  Matrix6d inertia_rate(const JointScrew& moved) const { return carried(inertia_beyond(moved), moved); }

  /// How a screw changes as another moves: by those before it, or by the first of a universal joint's axes.
  Vector6d twist_rate(const JointScrew& of, const JointScrew& moved) const {
    const bool before = is_beyond(child(moved), system_.joint(of.joint).parent);
    const bool second = of.joint == moved.joint && !system_.joint(of.joint).free() && moved.axis < of.axis;
    return before || second ? bracket(moved.twist, of.twist) : Vector6d(Vector6d::Zero());
  }

  /// X_a X_b − X_b X_a of the rates' directions, which vanishes but between those of one ball joint: [f].
  VectorXd commutator(std::size_t a, std::size_t b) const {
    VectorXd result = VectorXd::Zero(static_cast<Eigen::Index>(screws_.size()));
    const JointScrew &first = screws_[a], &second = screws_[b];
    if (first.joint != second.joint || first.axis == second.axis || !system_.joint(first.joint).free()) return result;
    const Vector3d turn = Vector3d::Unit(first.axis).cross(Vector3d::Unit(second.axis));
    result.segment<3>(static_cast<Eigen::Index>(a) - first.axis) = -turn;
    return result;
  }

 private:
  int child(const JointScrew& screw) const { return system_.joint(screw.joint).child; }

  // Whether body i is `first` or beyond it.
  bool is_beyond(int first, int i) const {
    while (i >= 0 && i != first) i = system_.body(i).parent;
    return i == first;
  }

  static Matrix6d carried(const Matrix6d& inertia, const JointScrew& moved) {
    const Matrix6d along = inertia * bracket_matrix(moved.twist);
    return -along - along.transpose();
  }

  void place(int i) {
    const model::Body& body = system_.body(i);
    if (body.parent >= 0)
      centre_[at(i)] = hub(system_.joint(body.joint)) - rotation_[at(i)] * system_.joint(body.joint).child_offset;
  }

  Vector3d hub(const model::Joint& joint) const {
    return centre_[at(joint.parent)] + rotation_[at(joint.parent)] * joint.parent_offset;
  }

  void gather_inertia(int i) {
    const model::Body& body = system_.body(i);
    Matrix6d own, seen = Matrix6d::Zero();
    own << body.inertia_matrix, body.coupling_matrix.transpose(), body.coupling_matrix, body.mass_matrix;
    seen.topLeftCorner<3, 3>() = seen.bottomRightCorner<3, 3>() = rotation_[at(i)].transpose();
    seen.bottomLeftCorner<3, 3>() = -rotation_[at(i)].transpose() * lie::hat(centre_[at(i)]);
    beyond_[at(i)] += seen.transpose() * own * seen;
    if (body.parent >= 0) beyond_[at(body.parent)] += beyond_[at(i)];
  }

  void add_screws(int j) {
    const model::Joint& joint = system_.joint(j);
    const Matrix3d &parent = rotation_[at(joint.parent)], &turned = rotation_[at(joint.child)];
    const Matrix3d axes = joint.free() ? parent : Matrix3d(turned * joint_frame(joint, parent, turned).axes);
    for (int c = 0; c < system_.body(joint.child).freedoms; ++c) {
      JointScrew screw{j, c, Vector6d::Zero()};
      screw.twist << axes.col(c), hub(joint).cross(axes.col(c));
      screws_.push_back(screw);
    }
  }

  const System& system_;
  Rotations rotation_;              // [bodies] body → root
  Vectors centre_;                  // [bodies] m, mass centres from the root's
  std::vector<Matrix6d> beyond_;    // [bodies] inertia of a body and of all beyond it, by twists
  std::vector<JointScrew> screws_;  // [f]
};

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

ConnectionCurvature connection_curvature(const System& system, const Rotations& rotation) {
  const SeenFromRoot seen(system, rotation);
  const std::vector<JointScrew>& screws = seen.screws();
  const auto f = static_cast<Eigen::Index>(screws.size());
  const Eigen::LDLT<Matrix6d> locked(seen.inertia());
  MatrixXd A(6, f);
  for (Eigen::Index c = 0; c < f; ++c) {
    const JointScrew& screw = screws[at(static_cast<int>(c))];
    A.col(c) = -locked.solve(Vector6d(seen.inertia_beyond(screw) * screw.twist));
  }
  ConnectionCurvature curvature;
  curvature.turn.fill(MatrixXd::Zero(f, f));
  curvature.shift.fill(MatrixXd::Zero(f, f));
  const auto rate = [&](Eigen::Index of, Eigen::Index moved) {  // of A's column as a joint moves
    const JointScrew &own = screws[at(static_cast<int>(of))], &other = screws[at(static_cast<int>(moved))];
    const Vector6d momentum = seen.inertia_rate(other) * A.col(of) + seen.inertia_rate(own, other) * own.twist +
                              seen.inertia_beyond(own) * seen.twist_rate(own, other);
    return Vector6d(-locked.solve(momentum));
  };
  for (Eigen::Index a = 0; a < f; ++a)
    for (Eigen::Index b = 0; b < a; ++b) {
      const Vector6d loop = rate(b, a) - rate(a, b) + bracket(A.col(a), A.col(b)) -
                            A * seen.commutator(at(static_cast<int>(a)), at(static_cast<int>(b)));
      for (Eigen::Index k = 0; k < 3; ++k) {
        const auto component = static_cast<std::size_t>(k);
        curvature.turn[component](a, b) = loop[k];
        curvature.turn[component](b, a) = -loop[k];
        curvature.shift[component](a, b) = loop[3 + k];
        curvature.shift[component](b, a) = -loop[3 + k];
      }
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
