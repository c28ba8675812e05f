#include "maneuver/seen_shape.hpp"

#include "mechanics/connection.hpp"
#include "mechanics/continuous.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::maneuver {

namespace {

using mechanics::child_to_parent;
using mechanics::Rotations;
using mechanics::turn_between;
using mechanics::turned_by;
using model::at;
using model::Joint;
using model::System;

constexpr int bisections = 50;

bool of_shape(const LimitRow& row) {
  switch (row.kind) {
    case LimitRow::Kind::swing:
    case LimitRow::Kind::twist:
    case LimitRow::Kind::angle_above:
    case LimitRow::Kind::angle_below:
      return true;
    default:
      return false;
  }
}

Rotations placed(const System& system, const Matrix3d& root, const std::vector<Matrix3d>& joints) {
  Rotations R(at(system.body_count()), root);
  for (int i : system.root_to_leaves())
    if (system.body(i).parent >= 0) R[at(i)] = R[at(system.body(i).parent)] * joints[at(system.body(i).joint)];
  return R;
}

// rad, by which a joint is beyond a limit of its own.
double beyond(const System& system, const LimitRow& row, const Matrix3d& joint) {
  Rotations R(at(system.body_count()), Matrix3d::Identity());
  R[at(system.joint(row.joint).child)] = joint;
  const VectorXd unmoved;
  const double missing = -limit_value(system, row, {R, R, Vector3d::Zero(), unmoved, 1.0, 0.0}, 0.0);
  return missing > 0.0 ? row.excess(missing, 1.0) : 0.0;
}

}  // namespace

Vector3d joint_rate(const System& system, const Joint& joint, const Matrix3d& Q, const mechanics::Vectors& angular,
                    const VectorXd& velocity) {
  if (joint.free()) return Q * angular[at(joint.child)] - angular[at(joint.parent)];
  const model::Body& child = system.body(joint.child);
  Vector3d rate = Vector3d::Zero();
  rate.head(child.freedoms) = velocity.segment(child.velocity_offset, child.freedoms);
  return rate;
}

SeenShape shape_of(const System& system, const integrator::State& state) {
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  const mechanics::Vectors angular = mechanics::angular_velocities(system, state.rotation, velocity);
  SeenShape shape;
  for (const Joint& joint : system.joints()) {
    shape.rotation.push_back(child_to_parent(state.rotation, joint));
    shape.rate.push_back(joint_rate(system, joint, shape.rotation.back(), angular, velocity));
  }
  return shape;
}

SeenShape shape_between(const System& system, const Rotations& from, const Rotations& to, double time_step,
                        double share) {
  SeenShape shape;
  for (const Joint& joint : system.joints()) {
    const Matrix3d Q = child_to_parent(from, joint);
    const Vector3d turn = turn_between(joint, Q, child_to_parent(to, joint));
    shape.rotation.push_back(turned_by(joint, Q, share * turn));
    shape.rate.emplace_back(joint.free() ? Vector3d(shape.rotation.back() * turn / time_step)
                                         : Vector3d(turn / time_step));
  }
  return shape;
}

BeyondLimit beyond_limits(const System& system, const std::vector<LimitRow>& rows, const SeenShape& shape) {
  BeyondLimit worst;
  for (const LimitRow& row : rows) {
    if (!of_shape(row)) continue;
    const double angle = beyond(system, row, shape.rotation[at(row.joint)]);
    if (angle > worst.angle) worst = {angle, &row};
  }
  return worst;
}

SeenShape held_within_limits(const System& system, const std::vector<LimitRow>& rows, SeenShape shape,
                             const Rotations& inside) {
  for (const LimitRow& row : rows) {
    if (!of_shape(row)) continue;
    const Joint& joint = system.joint(row.joint);
    Matrix3d& Q = shape.rotation[at(row.joint)];
    if (!(beyond(system, row, Q) > 0.0)) continue;
    const Vector3d turn = turn_between(joint, Q, child_to_parent(inside, joint));
    double out = 0.0, in = 1.0;
    for (int n = 0; n < bisections; ++n) {
      const double share = 0.5 * (out + in);
      (beyond(system, row, turned_by(joint, Q, share * turn)) > 0.0 ? out : in) = share;
    }
    Q = turned_by(joint, Q, in * turn);
    shape.rate[at(row.joint)].setZero();
  }
  return shape;
}

integrator::State state_of(const System& system, const Matrix3d& root, const Vector3d& position, const SeenShape& shape,
                           const mechanics::SpatialMomentum& total) {
  const Rotations R = placed(system, root, shape.rotation);
  return integrator::state_of_velocity(system, R, position,
                                       mechanics::velocity_of_rates(system, R, position, shape.rate, total));
}

}  // namespace lamprey::maneuver
