// System: a validated swimmer, a tree of rigid bodies. Never changes after construction; algorithms keep their own workspaces.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "model/description.hpp"

namespace lamprey::model {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A body's, joint's or node's number as containers count.
constexpr std::size_t at(int number) { return static_cast<std::size_t>(number); }

/// Where a body's mass centre lies: x_i = x + Σ_a R_a c_ia over the bodies a from the root to i (equation 1.2).
struct PathPoint {
  int body;         // a
  Vector3d offset;  // c_ia, m, frame of body a
};

struct Body {
  std::string name;
  Vector3d semi_axes;        // m
  bool ellipse;              // one metre of a cylinder in a plane fluid
  double volume;             // m³
  double mass;               // kg, without fluid
  Matrix3d body_inertia;     // kg m², without fluid, body frame
  Matrix3d mass_matrix;      // kg, M_i: body + fluid, body frame
  Matrix3d inertia_matrix;   // kg m², J_i: body + fluid, body frame
  Matrix3d coupling_matrix;  // kg m, C_i: body + fluid, body frame, energy V·C_iΩ
  bool coupled;              // whether C_i is not zero
  Matrix3d trace_weight;     // kg m², ½ tr(J_i) I − J_i: what rotation weighs in a discrete Lagrangian
  int parent;                // body index; −1 for the root
  int joint;                 // joint to the parent; −1 for the root
  int freedoms;         // 3: turns on its own (the root, a ball joint's child); 2, 1, 0: turns about its joint's axes
  int velocity_offset;  // where its freedoms begin in generalised vectors
  std::vector<int> children;    // body indices
  std::vector<PathPoint> path;  // root first, the body itself last

  /// Half lengths that gaps are measured by, m: an ellipse counts as so high that no way out leads over it.
  Vector3d gap_axes() const;
};

/// At most three columns.
using Axes = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;

/// How many axes a joint turns about.
int freedoms_of(JointKind kind);

/// Whether Cholesky's factorisation of a symmetric matrix succeeds.
bool positive_definite(const Matrix3d& m);

/// A joint. Ball: the child turns freely. Hinge: R_c = R_p Q_0 exp(θ b̂). Universal: R_c = R_p exp(θ_1 â) Q_0 exp(θ_2 b̂).
/// Fixed: R_c = R_p Q_0 (equation 8.1).
struct Joint {
  std::string name;
  JointKind kind;
  int parent;                   // body index
  int child;                    // body index
  Vector3d parent_offset;       // m, parent's mass centre → joint, parent's frame
  Vector3d child_offset;        // m, child's mass centre → joint, child's frame
  Matrix3d reference_rotation;  // Q_0: child → parent at zero angle
  Vector3d parent_axis;         // a: hinge and universal, unit, parent's frame at zero angle
  Vector3d child_axis;          // b: hinge and universal (the second axis), unit, child's frame
  double stiffness;             // N m/rad, about the zero angle
  double damping;               // N m s/rad
  /// Orthonormal columns spanning the moments: of a ball joint in the parent's frame, [3][controls]; of a hinge or a
  /// universal joint along its axes, entries beyond its freedoms are zero. [3][0]: none.
  Axes actuation;
  int first_control;  // where its moments along them begin among all controls

  bool free() const { return kind == JointKind::ball; }
};

/// Moments whose powers add up before their size is taken, as of one motor: all of a joint's, but each of a universal joint's by
/// itself.
struct Drive {
  int joint;
  int first_control, controls;  // among all; none where the joint has no moments
};

class System {
 public:
  /// Resolves defaults and checks the tree.
  /// Throws InputError naming the key when the description is not a tree of bodies with positive definite inertia.
  explicit System(const SwimmerDescription& description);

  /// The same bodies, so many times as heavy, on ball joints alone, without springs and dampers. Joints that led their child, or had
  /// any, exert moments about any axis of the parent's frame, what held the child and what they were among them.
  System with_ball_joints(double heavier) const;

  int body_count() const { return static_cast<int>(bodies_.size()); }
  int joint_count() const { return static_cast<int>(joints_.size()); }
  /// Number of scalar controls: Σ columns of Joint::actuation.
  int control_count() const { return control_count_; }
  /// Joint after joint, at least one of each.
  const std::vector<Drive>& drives() const { return drives_; }
  int drive_count() const { return static_cast<int>(drives_.size()); }
  const Drive& drive(int d) const { return drives_[static_cast<std::size_t>(d)]; }
  /// Dimension of generalised vectors: each body's freedoms, body after body, then 3 for the root's position.
  int velocity_count() const { return velocity_count_; }
  /// Whether every joint is a ball joint without spring or damper: each body turns on its own.
  bool only_free_joints() const { return only_free_joints_; }
  /// Whether any body's velocity and spin are coupled in its energy.
  bool coupled() const { return coupled_; }
  /// Whether any joint has a damper.
  bool damped() const { return damped_; }
  /// Whether any joint has a spring or a damper.
  bool compliant() const { return compliant_; }

  const std::vector<Body>& bodies() const { return bodies_; }
  const std::vector<Joint>& joints() const { return joints_; }
  const Body& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }
  const Joint& joint(int j) const { return joints_[static_cast<std::size_t>(j)]; }
  /// Bodies from the root to the leaves: parents come before their children.
  const std::vector<int>& root_to_leaves() const { return order_; }
  /// Whether nothing but fixed joints is between two bodies, so that they move as one.
  bool move_as_one(int i, int j) const { return part_[at(i)] == part_[at(j)]; }
  double density() const { return density_; }
  /// m, the largest semi-axis of its bodies: what lengths are large or small beside.
  double size() const;
  /// m, the power of two next to an eighth of that: what is 1 m to the paper's swimmer. Lengths and linear momenta counted by it
  /// mean the same for swimmers of all sizes, and are divided by it without loss.
  double length_unit() const;

  /// World positions of all mass centres, m.
  std::vector<Vector3d> mass_centres(const std::vector<Matrix3d>& rotation, const Vector3d& position) const;

 private:
  void resolve_bodies(const SwimmerDescription& description);
  void resolve_joints(const SwimmerDescription& description);
  void order_tree();
  void find_stiff_parts();
  void lay_paths();
  void lay_freedoms();
  void lay_drives();

  double density_ = 0.0;
  int control_count_ = 0;
  int velocity_count_ = 0;
  bool only_free_joints_ = true;
  bool coupled_ = false;
  bool damped_ = false;
  bool compliant_ = false;
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;
  std::vector<Drive> drives_;
  std::vector<int> order_;
  std::vector<int> part_;  // [bodies] the first of those that it moves as one with
};

}  // namespace lamprey::model
