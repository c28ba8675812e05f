// Joints that lead their child, in a transcription whose bodies all turn freely: what a joint holds, and which moments are
// those of its axes (equations 5.12 and 5.13). Both are of one form, m · (Q r) with Q = R_pᵀR_c.
#include <array>

#include "maneuver/step_chart.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

namespace {

using Eigen::Vector4d;
using lie::double_cross;
using lie::hat;
using maneuver::Matrix34;
using maneuver::quaternion_curvature;
using model::at;
using model::Joint;

// m · (Q r) = asked, m in the parent's frame and r in the child's.
struct Held {
  Vector3d m, r;
  double asked;
};

// Equation 5.12: a hinge keeps its axis, a universal joint the angle between its two, a fixed joint everything.
std::vector<Held> held_by(const Joint& joint) {
  const Matrix3d& zero = joint.reference_rotation;
  std::vector<Held> held;
  if (joint.kind == model::JointKind::hinge) {
    const Vector3d axis = zero * joint.child_axis;
    const Vector3d across = axis.unitOrthogonal();
    held = {{across, joint.child_axis, 0.0}, {axis.cross(across), joint.child_axis, 0.0}};
  } else if (joint.kind == model::JointKind::universal) {
    held = {{joint.parent_axis, joint.child_axis, joint.parent_axis.dot(zero * joint.child_axis)}};
  } else {
    for (int c = 0; c < 3; ++c)
      held.push_back({Vector3d::Unit((c + 1) % 3), zero.transpose() * Vector3d::Unit((c + 2) % 3), 0.0});
  }
  return held;
}

// The form's derivatives by the turns of parent and child, body frames.
struct Form {
  double value;
  Vector3d by_parent, by_child;
  Matrix3d parent_parent, child_child, parent_child;
  Form(const Matrix3d& Q, const Vector3d& m, const Vector3d& r) {
    const Vector3d seen = Q * r, back = Q.transpose() * m;
    value = m.dot(seen);
    by_parent = m.cross(seen);
    by_child = r.cross(back);
    parent_parent = double_cross(seen, m);
    child_child = double_cross(back, r);
    parent_child = -hat(m) * Q * hat(r);
  }
};

}  // namespace

void Transcription::joint_values(int node, VectorXd& c) const {
  int row = joint_row(node);
  if (joint_rows_ == 0) return;
  const mechanics::Rotations R = rotations(node);
  for (const Joint& joint : system_.joints())
    if (!joint.free())
      for (const Held& held : held_by(joint))
        c[row++] = held.m.dot(mechanics::child_to_parent(R, joint) * held.r) - held.asked;
}

void Transcription::emit_joint_jacobian(int node, BlockSink& sink) const {
  int row = joint_row(node);
  for (const Joint& joint : system_.joints()) {
    if (joint.free()) continue;
    const Vector4d q_parent = quaternion(node, joint.parent), q_child = quaternion(node, joint.child);
    const Matrix3d Q = lie::rotation_of_quaternion(q_parent).transpose() * lie::rotation_of_quaternion(q_child);
    for (const Held& held : held_by(joint)) {
      const Form form(Q, held.m, held.r);
      if (const int q = quaternion_variable(node, joint.parent); q >= 0)
        sink.add(row, q, form.by_parent.transpose() * lie::quaternion_tangent(q_parent));
      if (const int q = quaternion_variable(node, joint.child); q >= 0)
        sink.add(row, q, form.by_child.transpose() * lie::quaternion_tangent(q_child));
      ++row;
    }
  }
}

namespace {

// Blocks of λ · form by the quaternions of parent and child; a variable below 0 is given.
void emit_form(const Form& form, double lambda, const std::array<int, 2>& variable, const std::array<Vector4d, 2>& q,
               BlockSink& sink) {
  const std::array<Matrix34, 2> tangent{lie::quaternion_tangent(q[0]), lie::quaternion_tangent(q[1])};
  if (variable[0] >= 0)
    sink.add_symmetric(variable[0], variable[0],
                       lambda * (tangent[0].transpose() * form.parent_parent * tangent[0] +
                                 quaternion_curvature(q[0], form.by_parent)));
  if (variable[1] >= 0)
    sink.add_symmetric(
        variable[1], variable[1],
        lambda * (tangent[1].transpose() * form.child_child * tangent[1] + quaternion_curvature(q[1], form.by_child)));
  if (variable[0] >= 0 && variable[1] >= 0)
    sink.add_symmetric(variable[0], variable[1], lambda * (tangent[0].transpose() * form.parent_child * tangent[1]));
}

}  // namespace

void Transcription::emit_joint_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const {
  int row = joint_row(node);
  for (const Joint& joint : system_.joints()) {
    if (joint.free()) continue;
    const std::array<Vector4d, 2> q{quaternion(node, joint.parent), quaternion(node, joint.child)};
    const Matrix3d Q = lie::rotation_of_quaternion(q[0]).transpose() * lie::rotation_of_quaternion(q[1]);
    for (const Held& held : held_by(joint))
      emit_form(Form(Q, held.m, held.r), multiplier[row++],
                {quaternion_variable(node, joint.parent), quaternion_variable(node, joint.child)}, q, sink);
  }
}

// Equation 5.13: the moment on the parent, μ, has the controls, springs and dampers (5.16) for its components about the axes: a of
// a universal joint, and Q b. At an end of which nothing is asked joints hold nothing either: what they would is no one's.
void Transcription::axis_values(int node, VectorXd& c) const {
  int row = axis_row(node);
  if (node == steps_ && !rests_) {
    c.segment(row, reactions_) = point_.segment(control_variable(node) + controls_, reactions_);
    return;
  }
  if (axis_rows_ == 0) return;
  const mechanics::Rotations R = rotations(node);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    const int freedoms = system_.body(joint.child).freedoms;
    if (!carries(joint) || freedoms == 0) continue;
    const auto moment = point_.segment<3>(moment_variable(node, j));
    const VectorXd asked = (joint.actuation * point_.segment(control_variable(node) + system_.joint(j).first_control,
                                                             joint.actuation.cols()))
                               .head(freedoms);
    if (joint.free()) {
      for (int component = 0; component < 3; ++component)
        c[row++] = moment[component] - asked[component] - compliant_moment(node, joint, component);
      continue;
    }
    if (freedoms == 2) c[row++] = joint.parent_axis.dot(moment) - asked[0] - compliant_moment(node, joint, 0);
    c[row++] = moment.dot(mechanics::child_to_parent(R, joint) * joint.child_axis) - asked[freedoms - 1] -
               compliant_moment(node, joint, freedoms - 1);
  }
}

void Transcription::emit_axis_jacobian(int node, BlockSink& sink) const {
  int row = axis_row(node);
  if (node == steps_ && !rests_) {
    sink.add(row, control_variable(node) + controls_, MatrixXd::Identity(reactions_, reactions_));
    return;
  }
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    const int freedoms = system_.body(joint.child).freedoms;
    if (!carries(joint) || freedoms == 0) continue;
    const int variable = moment_variable(node, j), control = control_variable(node) + system_.joint(j).first_control;
    const auto by_control = [&](int axis) {
      if (joint.actuation.cols() > 0) sink.add(row, control, -joint.actuation.row(axis));
    };
    if (joint.free()) {
      for (int component = 0; component < 3; ++component, ++row) {
        sink.add(row, variable + component, Eigen::Matrix<double, 1, 1>(1.0));
        by_control(component);
        emit_compliance_jacobian(row, node, joint, component, sink);
      }
      continue;
    }
    if (freedoms == 2) {
      sink.add(row, variable, joint.parent_axis.transpose());
      by_control(0);
      emit_compliance_jacobian(row, node, joint, 0, sink);
      ++row;
    }
    const Vector4d q_parent = quaternion(node, joint.parent), q_child = quaternion(node, joint.child);
    const Matrix3d Q = lie::rotation_of_quaternion(q_parent).transpose() * lie::rotation_of_quaternion(q_child);
    const Form form(Q, point_.segment<3>(variable), joint.child_axis);
    sink.add(row, variable, (Q * joint.child_axis).transpose());
    by_control(freedoms - 1);
    if (const int q = quaternion_variable(node, joint.parent); q >= 0)
      sink.add(row, q, form.by_parent.transpose() * lie::quaternion_tangent(q_parent));
    if (const int q = quaternion_variable(node, joint.child); q >= 0)
      sink.add(row, q, form.by_child.transpose() * lie::quaternion_tangent(q_child));
    emit_compliance_jacobian(row, node, joint, freedoms - 1, sink);
    ++row;
  }
}

void Transcription::emit_axis_hessian(int node, const VectorXd& multiplier, BlockSink& sink) const {
  if (node == steps_ && !rests_) return;
  int row = axis_row(node);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    const int freedoms = system_.body(joint.child).freedoms;
    if (!carries(joint) || freedoms == 0) continue;
    if (joint.free()) {
      for (int component = 0; component < 3; ++component)
        emit_compliance_hessian(multiplier[row++], node, joint, component, sink);
      continue;
    }
    if (freedoms == 2) emit_compliance_hessian(multiplier[row++], node, joint, 0, sink);
    const double lambda = multiplier[row++];
    emit_compliance_hessian(lambda, node, joint, freedoms - 1, sink);
    const int variable = moment_variable(node, j);
    const std::array<int, 2> place{quaternion_variable(node, joint.parent), quaternion_variable(node, joint.child)};
    const std::array<Vector4d, 2> q{quaternion(node, joint.parent), quaternion(node, joint.child)};
    const Matrix3d Q = lie::rotation_of_quaternion(q[0]).transpose() * lie::rotation_of_quaternion(q[1]);
    emit_form(Form(Q, point_.segment<3>(variable), joint.child_axis), lambda, place, q, sink);
    if (place[0] >= 0)
      sink.add_symmetric(place[0], variable,
                         -lambda * (lie::quaternion_tangent(q[0]).transpose() * hat(Q * joint.child_axis)));
    if (place[1] >= 0)
      sink.add_symmetric(place[1], variable,
                         lambda * (lie::quaternion_tangent(q[1]).transpose() * hat(joint.child_axis) * Q.transpose()));
  }
}

// Moments at joints that a motion asks for, from the leaves to the root: what is left of each body's balance goes through
// the joint to its parent.
void Transcription::pack_reactions(const NodePath& path, VectorXd& x) const {
  std::vector<mechanics::DiscreteMomenta> momenta(at(steps_), mechanics::DiscreteMomenta(bodies_));
  for (int k = 0; k < steps_; ++k) {
    mechanics::Interval step(bodies_);
    step.rotation = path.rotation[at(k)];
    step.cayley = path.cayley[at(k)];
    step.displacement = path.position[at(k + 1)] - path.position[at(k)];
    mechanics::update_interval(free_, step);
    mechanics::discrete_momenta(free_, maneuver_.lagrangian, h_, step, momenta[at(k)]);
  }
  const double s = stretch(x);
  for (int node = 0; node <= steps_; ++node) {
    const bool first = node == 0, last = node == steps_;
    std::vector<Vector3d> through(at(bodies_), Vector3d::Zero());  // weight · moments on a body but by its own joint
    for (auto i = system_.root_to_leaves().rbegin(); i != system_.root_to_leaves().rend(); ++i) {
      if (system_.body(*i).parent < 0) continue;
      const int j = system_.body(*i).joint;
      const Joint& joint = free_.joint(j);
      const Matrix3d Q = mechanics::child_to_parent(path.rotation[at(node)], joint);
      Vector3d before = Vector3d::Zero(), after = Vector3d::Zero();
      if (!first) before = momenta[at(node - 1)].plus[at(*i)];
      if (first) before = maneuver_.periodic ? momenta.back().plus[at(*i)] : Vector3d(s * start_momentum_[at(*i)]);
      if (!last) after = momenta[at(node)].minus[at(*i)];
      if (last && maneuver_.periodic) after = momenta.front().minus[at(*i)];
      const double weight = maneuver_.periodic ? h_ : force_weight(node);
      auto moment = x.segment(moment_variable(node, j), joint.actuation.cols());
      if (carries(system_.joint(j))) moment = Q * (through[at(*i)] - (after - before)) / (weight * unit);
      through[at(joint.parent)] += weight * unit * (joint.actuation * moment);
    }
  }
}

}  // namespace lamprey::transcription
