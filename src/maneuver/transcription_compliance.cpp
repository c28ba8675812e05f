// Springs and dampers of joints that lead their child: what they add to the moment about an axis at a node (equation 5.16). It is
// linear in the joint's angles at the node and at those next to it.
#include <array>
#include <cmath>
#include <numbers>

#include "maneuver/joint_angle.hpp"
#include "maneuver/step_chart.hpp"
#include "maneuver/transcription.hpp"

namespace lamprey::maneuver {

namespace {

using Eigen::Vector4d;
using model::at;
using model::Joint;

constexpr double spring_slows = 2.0, damper_slows = 1.0;  // powers of the stretch that they grow with

}  // namespace

Matrix3d Transcription::child_to_parent(int node, const Joint& joint) const {
  return lie::rotation_of_quaternion(quaternion(node, joint.parent)).transpose() *
         lie::rotation_of_quaternion(quaternion(node, joint.child));
}

std::vector<Transcription::AngleShare> Transcription::angle_shares(int node, const Joint& joint, int freedom) const {
  const Vector3d axis = angle_axis(joint, freedom);
  const auto angle = [&](int at_node) { return twist_about(axis, joint, child_to_parent(at_node, joint)); };
  std::vector<AngleShare> shares;
  const double s = stretch();
  if (joint.stiffness > 0.0)
    shares.push_back({node, std::pow(s, spring_slows) * joint.stiffness / control_unit(), 0.0, angle(node)});
  if (joint.damping == 0.0) return shares;
  std::vector<int> steps = steps_about(node);
  if (maneuver_.periodic && node == 0) steps.push_back(steps_ - 1);
  const double weight = maneuver_.periodic ? h_ : force_weight(node);
  const double share = std::pow(s, damper_slows) * 0.5 * joint.damping / weight / control_unit();
  for (const int step : steps) {
    const double before = angle(step), turn = std::remainder(angle(step + 1) - before, 2.0 * std::numbers::pi);
    shares.push_back({step, 0.0, -share, before});
    shares.push_back({step + 1, 0.0, share, before + turn});
  }
  return shares;
}

double Transcription::compliance(int node, const Joint& joint, int freedom) const {
  double moment = 0.0;
  for (const AngleShare& share : angle_shares(node, joint, freedom)) moment += share.sum() * share.angle;
  return moment;
}

void Transcription::emit_compliance_jacobian(int row, int node, const Joint& joint, int freedom,
                                             BlockSink& sink) const {
  const Vector3d axis = angle_axis(joint, freedom);
  double by_log_stretch = 0.0;
  for (const AngleShare& share : angle_shares(node, joint, freedom)) {
    const Matrix3d Q = child_to_parent(share.node, joint);
    const TwistDerivatives twist = twist_derivatives(axis, joint, Q);
    by_log_stretch += (spring_slows * share.spring + damper_slows * share.damper) * share.angle;
    const std::array<int, 2> bodies{joint.parent, joint.child};
    for (int end = 0; end < 2; ++end)
      if (const int q = quaternion_variable(share.node, bodies[at(end)]); q >= 0)
        sink.add(row, q,
                 -share.sum() * twist.gradient.segment<3>(3 * end).transpose() *
                     lie::quaternion_tangent(quaternion(share.node, bodies[at(end)])));
  }
  if (stretch_variable_ >= 0 && (joint.stiffness > 0.0 || joint.damping > 0.0))
    sink.add(row, stretch_variable_, Eigen::Matrix<double, 1, 1>(-by_log_stretch));
}

void Transcription::emit_compliance_hessian(double lambda, int node, const Joint& joint, int freedom,
                                            BlockSink& sink) const {
  const Vector3d axis = angle_axis(joint, freedom);
  double by_log_stretch_twice = 0.0;
  for (const AngleShare& share : angle_shares(node, joint, freedom)) {
    const Matrix3d Q = child_to_parent(share.node, joint);
    const TwistDerivatives twist = twist_derivatives(axis, joint, Q);
    const double factor = -lambda * share.sum(),
                 by_log_stretch = -lambda * (spring_slows * share.spring + damper_slows * share.damper);
    by_log_stretch_twice -= lambda *
                            (spring_slows * spring_slows * share.spring + damper_slows * damper_slows * share.damper) *
                            share.angle;
    const std::array<int, 2> variable{quaternion_variable(share.node, joint.parent),
                                      quaternion_variable(share.node, joint.child)};
    const std::array<Vector4d, 2> q{quaternion(share.node, joint.parent), quaternion(share.node, joint.child)};
    const std::array<Matrix34, 2> tangent{lie::quaternion_tangent(q[0]), lie::quaternion_tangent(q[1])};
    for (int a = 0; a < 2; ++a) {
      if (variable[at(a)] < 0) continue;
      const Vector3d by_turn = twist.gradient.segment<3>(3 * a);
      sink.add_symmetric(
          variable[at(a)], variable[at(a)],
          factor * (tangent[at(a)].transpose() * twist.hessian.block<3, 3>(3 * a, 3 * a) * tangent[at(a)] +
                    quaternion_curvature(q[at(a)], by_turn)));
      if (stretch_variable_ >= 0)
        sink.add_symmetric(variable[at(a)], stretch_variable_, by_log_stretch * (tangent[at(a)].transpose() * by_turn));
    }
    if (variable[0] >= 0 && variable[1] >= 0)
      sink.add_symmetric(variable[0], variable[1],
                         factor * (tangent[0].transpose() * twist.hessian.block<3, 3>(0, 3) * tangent[1]));
  }
  if (stretch_variable_ >= 0 && (joint.stiffness > 0.0 || joint.damping > 0.0))
    sink.add(stretch_variable_, stretch_variable_, Eigen::Matrix<double, 1, 1>(by_log_stretch_twice));
}

}  // namespace lamprey::maneuver
