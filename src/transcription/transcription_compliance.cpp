// Springs and dampers: what they add to the moment through a joint at a node (equation 5.16). It is linear in turns of the joint: from
// its zero angle, and over the steps that meet at the node.
#include <array>
#include <cmath>

#include "lie/so3.hpp"
#include "maneuver/joint_angle.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

namespace {

using maneuver::angle_axis;
using maneuver::twist_about;
using maneuver::twist_derivatives;
using maneuver::TwistDerivatives;
using model::at;
using model::Joint;

constexpr double spring_slows = 2.0, damper_slows = 1.0;  // powers of the stretch that they grow with

}  // namespace

Matrix3d Transcription::child_to_parent(int node, const Joint& joint) const {
  return lie::rotation_of_quaternion(quaternion(node, joint.parent)).transpose() *
         lie::rotation_of_quaternion(quaternion(node, joint.child));
}

// Turns of parent and child at a node, coordinates 0 … 5.
std::vector<Transcription::Charted> Transcription::charted_at(int node, const Joint& joint) const {
  std::vector<Charted> all;
  for (int end = 0; end < 2; ++end) {
    const int body = end == 0 ? joint.parent : joint.child, variable = quaternion_variable(node, body);
    if (variable >= 0) all.push_back({variable, 3 * end, lie::quaternion_tangent(quaternion(node, body)), node, body});
  }
  return all;
}

std::vector<Transcription::Compliance> Transcription::compliance(int node, const Joint& joint, int row) const {
  std::vector<Compliance> terms;
  const double s = stretch();
  const double spring = std::pow(s, spring_slows) * joint.stiffness / control_unit();
  const double weight = maneuver_.periodic ? h_ : force_weight(node);
  const double damper = std::pow(s, damper_slows) * 0.5 * joint.damping / weight / control_unit();
  std::vector<StepAbout> steps;
  if (joint.damping > 0.0) steps = steps_about(node);
  if (joint.damping > 0.0 && maneuver_.periodic && node == 0) steps.push_back({steps_ - 1, -1.0});
  if (joint.free()) {
    const Vector3d along = Vector3d::Unit(row);
    if (joint.stiffness > 0.0) {
      const BallTurn turn(joint.reference_rotation, child_to_parent(node, joint));
      terms.push_back({spring, 0.0, turn.psi()[row], turn.derivative().row(row).tail<6>(),
                       turn.curvature(along).bottomRightCorner<6, 6>(), charted_at(node, joint)});
    }
    for (const StepAbout& about : steps) {
      const BallTurn turn = turn_over(about.step, joint);
      terms.push_back({0.0, damper, turn.psi()[row], turn.derivative().row(row), turn.curvature(along),
                       charted(about.step, joint)});
    }
    return terms;
  }
  const Vector3d axis = angle_axis(joint, row);
  const auto angle = [&](int at_node) { return twist_about(axis, joint, child_to_parent(at_node, joint)); };
  const auto add = [&](double by_spring, double by_damper, int at_node, double value) {
    const TwistDerivatives twist = twist_derivatives(axis, joint, child_to_parent(at_node, joint));
    terms.push_back({by_spring, by_damper, value, twist.gradient, twist.hessian, charted_at(at_node, joint)});
  };
  if (joint.stiffness > 0.0) add(spring, 0.0, node, angle(node));
  for (const StepAbout& about : steps) {  // of its two ends the difference is the shorter way round
    const double before = angle(about.step), turn = lie::shorter_way(angle(about.step + 1) - before);
    add(0.0, -damper, about.step, before);
    add(0.0, damper, about.step + 1, before + turn);
  }
  return terms;
}

double Transcription::compliant_moment(int node, const Joint& joint, int row) const {
  double moment = 0.0;
  for (const Compliance& term : compliance(node, joint, row)) moment += (term.spring + term.damper) * term.turn;
  return moment;
}

void Transcription::emit_compliance_jacobian(int constraint, int node, const Joint& joint, int row,
                                             BlockSink& sink) const {
  if (!compliant(joint)) return;
  double by_log_stretch = 0.0;
  for (const Compliance& term : compliance(node, joint, row)) {
    by_log_stretch += (spring_slows * term.spring + damper_slows * term.damper) * term.turn;
    emit_charted(constraint, -(term.spring + term.damper) * term.gradient, term.charts, sink);
  }
  if (stretch_variable_ >= 0) sink.add(constraint, stretch_variable_, Eigen::Matrix<double, 1, 1>(-by_log_stretch));
}

void Transcription::emit_compliance_hessian(double lambda, int node, const Joint& joint, int row,
                                            BlockSink& sink) const {
  if (!compliant(joint)) return;
  double by_log_stretch_twice = 0.0;
  for (const Compliance& term : compliance(node, joint, row)) {
    emit_charted(-lambda * (term.spring + term.damper), term.gradient, term.hessian, term.charts, sink);
    if (stretch_variable_ < 0) continue;
    const double by_log_stretch = -lambda * (spring_slows * term.spring + damper_slows * term.damper);
    by_log_stretch_twice -=
        lambda * term.turn * (spring_slows * spring_slows * term.spring + damper_slows * damper_slows * term.damper);
    for (const Charted& chart : term.charts)
      sink.add_symmetric(chart.variable, stretch_variable_,
                         by_log_stretch * (chart.by_variable.transpose() * term.gradient.segment(chart.coordinate, 3)));
  }
  if (stretch_variable_ >= 0)
    sink.add(stretch_variable_, stretch_variable_, Eigen::Matrix<double, 1, 1>(by_log_stretch_twice));
}

}  // namespace lamprey::transcription
