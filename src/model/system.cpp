#include "model/system.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "fluid/ellipse.hpp"
#include "fluid/ellipsoid.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"

namespace lamprey::model {

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

bool positive_definite(const Matrix6d& m) {
  return Eigen::LLT<Eigen::MatrixXd>(Eigen::MatrixXd(m)).info() == Eigen::Success;
}

bool symmetric_positive_definite(const Matrix3d& m) {
  return m.allFinite() && m.isApprox(m.transpose(), 1e-12) && model::positive_definite(m);
}

int index_of(const std::vector<Body>& bodies, const std::string& name, const std::string& key) {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].name == name) return static_cast<int>(i);
  throw InputError(key, "found \"" + name + "\", which is no body's name; name a [[body]] of this file");
}

Matrix3d homogeneous_inertia(const BodyDescription& described, double mass) {
  const Vector3d s = described.semi_axes.cwiseAbs2();
  if (described.ellipse) return (mass * fluid::ellipse_spread(described.semi_axes.head<2>())).asDiagonal();
  return (mass / 5.0 * Vector3d(s[1] + s[2], s[2] + s[0], s[0] + s[1])).asDiagonal();
}

Body resolve_body(const BodyDescription& described, double density) {
  const fluid::EllipsoidInertia shape = described.ellipse
                                            ? fluid::ellipse_inertia(described.semi_axes.head<2>(), density)
                                            : fluid::ellipsoid_inertia(described.semi_axes, density);
  if (!described.mass && density <= 0.0)
    throw InputError("body.mass",
                     "missing for \"" + described.name + "\"; a vacuum gives no buoyancy: state the mass in kg");
  Body body;
  body.name = described.name;
  body.semi_axes = described.semi_axes;
  body.ellipse = described.ellipse;
  body.volume = shape.volume;
  body.mass = described.mass.value_or(shape.mass);
  body.body_inertia = described.body_inertia.value_or(homogeneous_inertia(described, body.mass));
  const Matrix3d added_mass = shape.added_mass.asDiagonal();
  const Matrix3d added_inertia = shape.added_inertia.asDiagonal();
  body.mass_matrix = described.mass_matrix.value_or(body.mass * Matrix3d::Identity() + added_mass);
  body.inertia_matrix = described.inertia_matrix.value_or(body.body_inertia + added_inertia);
  if (!symmetric_positive_definite(body.mass_matrix))
    throw InputError("body.mass_matrix",
                     "of \"" + body.name + "\" is not symmetric positive definite; mend its entries");
  if (!symmetric_positive_definite(body.inertia_matrix))
    throw InputError("body.inertia_matrix",
                     "of \"" + body.name + "\" is not symmetric positive definite; mend its entries");
  body.coupling_matrix = described.coupling_matrix.value_or(Matrix3d::Zero());
  body.coupled = !body.coupling_matrix.isZero(0.0);
  body.trace_weight = 0.5 * body.inertia_matrix.trace() * Matrix3d::Identity() - body.inertia_matrix;
  Matrix6d whole;
  whole << body.inertia_matrix, body.coupling_matrix.transpose(), body.coupling_matrix, body.mass_matrix;
  if (!whole.allFinite() || !positive_definite(whole))
    throw InputError("body.coupling_matrix", "of \"" + body.name +
                                                 "\" makes the 6×6 inertia [J Cᵀ; C M] not positive definite; make its "
                                                 "entries smaller");
  body.parent = -1;
  body.joint = -1;
  body.freedoms = 3;
  body.velocity_offset = 0;
  return body;
}

// Orthonormal basis of the span of the control axes, in the order given.
Axes span_of(const JointDescription& described) {
  Axes basis(3, 0);
  for (const Vector3d& given : *described.control_axes) {
    Vector3d axis = given.stableNormalized();
    const double length = axis.norm();  // 1 or 0
    for (int pass = 0; pass < 2; ++pass) axis -= basis * (basis.transpose() * axis);
    if (!(axis.norm() > 1e-9 * length))
      throw InputError("joint.control_axes", "of \"" + described.name + "\" are not linearly independent; remove one");
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols<1>() = axis.normalized();
  }
  return basis;
}

// Moments along a hinge's or universal joint's axes that also lie in the span of its control axes.
Axes confined(const JointDescription& described, const Axes& free, const Axes& span) {
  constexpr double within = 1e-9;
  const Axes outside = free - span * (span.transpose() * free);
  if (outside.colwise().norm().maxCoeff() <= within) return Matrix3d::Identity().leftCols(free.cols());
  Vector3d inside = Vector3d::Zero();  // coefficients of the axes whose parts outside the span cancel
  if (free.cols() == 2) {
    const int longer = outside.col(0).norm() >= outside.col(1).norm() ? 0 : 1;
    inside[1 - longer] = 1.0;
    inside[longer] = -outside.col(0).dot(outside.col(1)) / outside.col(longer).squaredNorm();
    inside.normalize();
  }
  if (inside.isZero(0.0) || (outside * inside.head(free.cols())).norm() > within)
    throw InputError("joint.control_axes", "of \"" + described.name +
                                               "\" hold no direction that the joint leaves free; name the joint's own "
                                               "axis (parent's frame), or set actuated = false");
  return inside;
}

Axes actuation_basis(const JointDescription& described, const Joint& joint) {
  const int freedoms = freedoms_of(joint.kind);
  if (!described.actuated) return Axes(3, 0);
  if (!described.control_axes) return Axes(Matrix3d::Identity().leftCols(freedoms));
  const Axes span = span_of(described);
  if (freedoms == 3) return span;
  if (freedoms == 0) return Axes(3, 0);
  Axes free(3, freedoms);
  free.col(0) = joint.parent_axis;
  if (freedoms == 2) free.col(1) = joint.reference_rotation * joint.child_axis;
  return confined(described, free, span);
}

Vector3d unit_axis(const Vector3d& axis, const std::string& key, const std::string& name) {
  const double length = axis.stableNorm();
  if (!(length > 0.0)) throw InputError(key, "of \"" + name + "\" is zero; give a direction");
  return axis.stableNormalized();
}

void lay_axes(const JointDescription& described, Joint& joint) {
  joint.reference_rotation = lie::exp(described.reference_rotation);
  joint.parent_axis.setZero();
  joint.child_axis.setZero();
  if (joint.kind == JointKind::hinge) {
    if (!described.axis) throw InputError("joint.axis", "of \"" + described.name + "\" is missing; a hinge needs one");
    joint.child_axis = unit_axis(*described.axis, "joint.axis", described.name);
    joint.parent_axis = joint.reference_rotation * joint.child_axis;
  }
  if (joint.kind == JointKind::universal) {
    if (!described.axes)
      throw InputError("joint.axes", "of \"" + described.name + "\" are missing; a universal joint needs two");
    joint.parent_axis = unit_axis((*described.axes)[0], "joint.axes", described.name);
    joint.child_axis = unit_axis((*described.axes)[1], "joint.axes", described.name);
    if (std::abs(joint.parent_axis.dot(joint.reference_rotation * joint.child_axis)) > 1e-6)
      throw InputError("joint.axes",
                       "of \"" + described.name + "\" are not orthogonal at zero angle; turn one of them");
    // what is left of the parent's axis in the child's, up to 1e-6, goes
    const Vector3d first = joint.reference_rotation.transpose() * joint.parent_axis;
    joint.child_axis = (joint.child_axis - first * first.dot(joint.child_axis)).normalized();
  }
}

}  // namespace

int freedoms_of(JointKind kind) {
  switch (kind) {
    case JointKind::ball:
      return 3;
    case JointKind::universal:
      return 2;
    case JointKind::hinge:
      return 1;
    case JointKind::fixed:
      return 0;
  }
  return 0;
}

bool positive_definite(const Matrix3d& m) {
  Matrix6d padded = Matrix6d::Identity();
  padded.topLeftCorner<3, 3>() = m;
  return positive_definite(padded);
}

Vector3d Body::gap_axes() const {
  return ellipse ? Vector3d(semi_axes[0], semi_axes[1], semi_axes.maxCoeff()) : semi_axes;
}

System::System(const SwimmerDescription& description) : density_(description.density) {
  resolve_bodies(description);
  resolve_joints(description);
  order_tree();
  find_stiff_parts();
  lay_paths();
  lay_freedoms();
  lay_drives();
}

void System::resolve_bodies(const SwimmerDescription& description) {
  if (description.bodies.empty()) throw InputError("body", "found none; describe at least one [[body]]");
  for (const BodyDescription& described : description.bodies) {
    bodies_.push_back(resolve_body(described, density_));
    coupled_ = coupled_ || bodies_.back().coupled;
  }
}

void System::resolve_joints(const SwimmerDescription& description) {
  for (const JointDescription& described : description.joints) {
    Joint joint;
    joint.name = described.name;
    joint.kind = described.kind;
    joint.parent = index_of(bodies_, described.parent, "joint.parent");
    joint.child = index_of(bodies_, described.child, "joint.child");
    joint.parent_offset = described.parent_offset;
    joint.child_offset = described.child_offset;
    joint.stiffness = described.stiffness;
    joint.damping = described.damping;
    lay_axes(described, joint);
    joint.actuation = actuation_basis(described, joint);
    damped_ = damped_ || joint.damping > 0.0;
    compliant_ = compliant_ || described.compliant();
    only_free_joints_ = only_free_joints_ && joint.free() && joint.stiffness == 0.0 && joint.damping == 0.0;
    joint.first_control = control_count_;
    control_count_ += static_cast<int>(joint.actuation.cols());

    Body& child = bodies_[static_cast<std::size_t>(joint.child)];
    if (joint.child == 0)
      throw InputError("joint.child", "found the root \"" + described.child + "\"; the first body has no parent");
    if (child.parent >= 0)
      throw InputError("joint.child", "\"" + described.child + "\" has two parents; remove one joint");
    child.parent = joint.parent;
    child.joint = joint_count();
    child.freedoms = freedoms_of(joint.kind);
    bodies_[static_cast<std::size_t>(joint.parent)].children.push_back(joint.child);
    joints_.push_back(joint);
  }
}

void System::order_tree() {
  order_ = {0};
  for (std::size_t next = 0; next < order_.size(); ++next)
    for (int child : body(order_[next]).children) order_.push_back(child);
  if (static_cast<int>(order_.size()) != body_count())
    throw InputError("joint",
                     "some bodies are not joined to the root; every body needs a chain of joints to the first one");
}

void System::find_stiff_parts() {
  part_.resize(bodies_.size());
  for (int i : order_) {
    const Body& own = body(i);
    part_[at(i)] = own.parent >= 0 && joint(own.joint).kind == JointKind::fixed ? part_[at(own.parent)] : i;
  }
}

void System::lay_paths() {
  for (int i : order_) {
    Body& body_i = bodies_[static_cast<std::size_t>(i)];
    if (body_i.parent >= 0) {
      const Joint& up = joint(body_i.joint);
      body_i.path = body(body_i.parent).path;
      body_i.path.back().offset += up.parent_offset;
      body_i.path.push_back({i, -up.child_offset});
    } else {
      body_i.path = {{i, Vector3d::Zero()}};
    }
  }
}

void System::lay_freedoms() {
  for (Body& body_i : bodies_) {
    body_i.velocity_offset = velocity_count_;
    velocity_count_ += body_i.freedoms;
  }
  velocity_count_ += 3;
}

void System::lay_drives() {
  drives_.clear();
  for (int j = 0; j < joint_count(); ++j) {
    const auto controls = static_cast<int>(joint(j).actuation.cols());
    const int own = joint(j).kind == JointKind::universal ? std::max(controls, 1) : 1;
    for (int d = 0; d < own; ++d) drives_.push_back({j, joint(j).first_control + d, controls / own});
  }
}

System System::with_ball_joints(double heavier) const {
  System free = *this;
  free.control_count_ = free.velocity_count_ = 0;
  free.only_free_joints_ = true;
  free.damped_ = free.compliant_ = false;
  for (Joint& joint_j : free.joints_) {
    if (!joint_j.free() || joint_j.stiffness > 0.0 || joint_j.damping > 0.0) joint_j.actuation = Matrix3d::Identity();
    joint_j.kind = JointKind::ball;
    joint_j.stiffness = joint_j.damping = 0.0;
    joint_j.first_control = free.control_count_;
    free.control_count_ += static_cast<int>(joint_j.actuation.cols());
  }
  for (Body& body_i : free.bodies_) {
    body_i.freedoms = 3;
    body_i.mass *= heavier;
    for (Matrix3d* matrix : {&body_i.body_inertia, &body_i.mass_matrix, &body_i.inertia_matrix, &body_i.coupling_matrix,
                             &body_i.trace_weight})
      *matrix *= heavier;
  }
  free.lay_freedoms();
  free.lay_drives();
  return free;
}

double System::size() const {
  double size = 0.0;
  for (const Body& body : bodies_) size = std::max(size, body.semi_axes.maxCoeff());
  return size;
}

double System::length_unit() const { return std::exp2(std::round(std::log2(size() / 8.0))); }

std::vector<Vector3d> System::mass_centres(const std::vector<Matrix3d>& rotation, const Vector3d& position) const {
  std::vector<Vector3d> centres(bodies_.size(), position);
  for (int i : order_) {
    const Body& body_i = body(i);
    if (body_i.parent < 0) continue;
    const Joint& up = joint(body_i.joint);
    centres[static_cast<std::size_t>(i)] = centres[static_cast<std::size_t>(up.parent)] +
                                           rotation[static_cast<std::size_t>(up.parent)] * up.parent_offset -
                                           rotation[static_cast<std::size_t>(i)] * up.child_offset;
  }
  return centres;
}

}  // namespace lamprey::model
