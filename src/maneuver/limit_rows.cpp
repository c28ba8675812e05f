#include "maneuver/limit_rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fluid/gap.hpp"
#include "fluid/gap_across.hpp"
#include "lie/so3.hpp"
#include "maneuver/joint_angle.hpp"

namespace lamprey::maneuver {

namespace {

using lie::double_cross;
using lie::hat;
using model::at;
using model::Joint;
using model::System;
using Kind = LimitRow::Kind;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Where the pieces of the body coordinates lie.
Eigen::Index turn_of(int body) { return 3 * body; }
Eigen::Index position_of(const System& system) { return 3 * system.body_count(); }
Eigen::Index turn_before_of(const System& system, int body) { return 3 * (system.body_count() + 1 + body); }

Vector3d mass_centre(const System& system, const LimitedNode& node, int body) {
  Vector3d x = node.position;
  for (const model::PathPoint& point : system.body(body).path) x += node.rotation[at(point.body)] * point.offset;
  return x;
}

// o_i in x_b − x_a = Σ R_i o_i; a < 0: from the root's mass centre.
Vector3d offset_along(const System& system, int a, int b, int i) {
  Vector3d offset = Vector3d::Zero();
  for (const model::PathPoint& point : system.body(b).path)
    if (point.body == i) offset += point.offset;
  if (a < 0) return offset;
  for (const model::PathPoint& point : system.body(a).path)
    if (point.body == i) offset -= point.offset;
  return offset;
}

// A quantity's derivatives by the turns of two bodies and the offset from one to the other (world, m), spread over the
// body coordinates: the offset turns with the bodies between. `from` < 0: a fixed point instead of the first body.
void spread_pair(const System& system, const LimitedNode& node, int from, int to, const Vector9d& local,
                 const Matrix9d& local_hessian, VectorXd& gradient, MatrixXd& hessian) {
  using Rate = Eigen::Matrix<double, 9, 3>;
  const int bodies = system.body_count(), last = from < 0 ? bodies : bodies - 1;  // after the turns the root's position
  const auto rate_by = [&](int i) {
    Rate rate = Rate::Zero();
    if (i == bodies) {
      rate.bottomRows<3>().setIdentity();
      return rate;
    }
    if (i == from) rate.topRows<3>().setIdentity();
    if (i == to) rate.middleRows<3>(3).setIdentity();
    rate.bottomRows<3>() = -lie::times_hat(node.rotation[at(i)], offset_along(system, from, to, i));
    return rate;
  };
  for (int i = 0; i <= last; ++i) {
    const Rate by_i = rate_by(i);
    if (by_i.isZero(0.0)) continue;
    const Rate bent = local_hessian * by_i;
    gradient.segment<3>(3 * i) = by_i.transpose() * local;
    for (int j = 0; j <= last; ++j) hessian.block<3, 3>(3 * j, 3 * i) = rate_by(j).transpose() * bent;
    if (i == bodies) continue;
    const Vector3d pull = node.rotation[at(i)].transpose() * local.tail<3>();
    hessian.block<3, 3>(3 * i, 3 * i) += double_cross(pull, offset_along(system, from, to, i));
  }
}

// x_b − x_a: what both paths from the root have in common falls out.
Vector3d offset_between(const System& system, const LimitedNode& node, int a, int b) {
  const std::vector<model::PathPoint>&from = system.body(a).path, &to = system.body(b).path;
  const std::size_t shorter = std::min(from.size(), to.size());
  const auto turned = [&](int body, const Vector3d& offset) -> Vector3d { return node.rotation[at(body)] * offset; };
  std::size_t n = 0;
  while (n < shorter && from[n].body == to[n].body && from[n].offset == to[n].offset) ++n;
  Vector3d offset = Vector3d::Zero();
  if (n < shorter && from[n].body == to[n].body) {  // where they part
    offset += turned(to[n].body, to[n].offset - from[n].offset);
    ++n;
  }
  for (std::size_t m = n; m < from.size(); ++m) offset += turned(from[m].body, -from[m].offset);
  for (std::size_t m = n; m < to.size(); ++m) offset += turned(to[m].body, to[m].offset);
  return offset;
}

fluid::EllipsoidPair pair_of_bodies(const System& system, const LimitRow& row, const LimitedNode& node) {
  return {system.body(row.body).gap_axes(), system.body(row.other_body).gap_axes(), node.rotation[at(row.body)],
          node.rotation[at(row.other_body)], offset_between(system, node, row.body, row.other_body)};
}

fluid::EllipsoidPair pair_with_sphere(const System& system, const LimitRow& row, const LimitedNode& node) {
  return {Vector3d::Constant(row.bound), system.body(row.body).gap_axes(), Matrix3d::Identity(),
          node.rotation[at(row.body)], mass_centre(system, node, row.body) - row.centre};
}

// Equation 10.4: half the sum of a body's extents towards a half-space's face.
double support(const Vector3d& semi_axes, const Vector3d& direction) {
  return semi_axes.cwiseProduct(direction).norm();
}

// Arms of a joint: its parent's mass centre → joint in the parent's frame, joint → its child's in the child's, unit.
Vector3d parent_arm(const Joint& joint) { return joint.parent_offset.normalized(); }
Vector3d child_arm(const Joint& joint) { return -joint.child_offset.normalized(); }

double twist(const Joint& joint, const mechanics::Rotations& R) {
  return twist_about(child_arm(joint), joint, mechanics::child_to_parent(R, joint));
}

// Equation 10.2 of a row that is `scale` times the twist about an axis, and something that does not change.
void add_twist(const LimitRow& row, const Joint& joint, const Vector3d& axis, double scale, const LimitedNode& node,
               VectorXd& gradient, MatrixXd& hessian) {
  const TwistDerivatives twist = twist_derivatives(axis, joint, mechanics::child_to_parent(node.rotation, joint));
  const std::array<Eigen::Index, 2> place{turn_of(joint.parent), turn_of(joint.child)};
  for (int a = 0; a < 2; ++a) {
    gradient.segment<3>(place[at(a)]) = scale / row.unit * twist.gradient.segment<3>(3 * a);
    for (int b = 0; b < 2; ++b)
      hessian.block<3, 3>(place[at(a)], place[at(b)]) = scale / row.unit * twist.hessian.block<3, 3>(3 * a, 3 * b);
  }
}

// Equation 10.1: cosine of the angle between the arms.
void swing_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, VectorXd& gradient,
                       MatrixXd& hessian) {
  const Joint& joint = system.joint(row.joint);
  const Matrix3d Q = mechanics::child_to_parent(node.rotation, joint);
  const Vector3d a = parent_arm(joint), b = child_arm(joint);
  const Vector3d b_seen = Q * b, a_seen = Q.transpose() * a;
  const Eigen::Index p = turn_of(joint.parent), c = turn_of(joint.child);
  gradient.segment<3>(p) = a.cross(b_seen) / row.unit;
  gradient.segment<3>(c) = b.cross(a_seen) / row.unit;
  hessian.block<3, 3>(p, p) = double_cross(b_seen, a) / row.unit;
  hessian.block<3, 3>(c, c) = double_cross(a_seen, b) / row.unit;
  hessian.block<3, 3>(p, c) = -hat(a) * Q * hat(b) / row.unit;
  hessian.block<3, 3>(c, p) = hessian.block<3, 3>(p, c).transpose();
}

// The angle, rad, that a rate turns a joint by in a step. A step shows no more than half a turn: every motion keeps to that.
struct TurnAllowed {
  double angle;
  bool whole;
  double sine, cosine, half_sine;
};

TurnAllowed turn_allowed(double rate, double time_step) {
  const double angle = rate * time_step;
  if (angle >= std::numbers::pi) return {angle, true, 0.0, -1.0, 1.0};
  return {angle, false, std::sin(angle), std::cos(angle), std::sin(0.5 * angle)};
}

// Equation 10.3 without cancellation: |Q_{k+1} − Q_k|² = 2 (3 − tr(Q_kᵀ Q_{k+1})) by the Frobenius norm.
double speed_value(const Matrix3d& before, const Matrix3d& now, const TurnAllowed& turn) {
  const double most = 4.0 * turn.half_sine * turn.half_sine;
  return (most - 0.5 * (now - before).squaredNorm()) / (turn.angle * turn.angle);
}

// Equation 10.3: trace of the joint's turn over the step, 1 + 2 cos of its angle.
void speed_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, VectorXd& gradient,
                       MatrixXd& hessian) {
  const Joint& joint = system.joint(row.joint);
  const Matrix3d before = mechanics::child_to_parent(node.rotation_before, joint);
  const Matrix3d now = mechanics::child_to_parent(node.rotation, joint);
  const Matrix3d M = before.transpose() * now, K = now * before.transpose();
  const double scale = std::pow(row.bound * node.time_step, 2) * row.unit;
  const std::array<Eigen::Index, 4> place{turn_before_of(system, joint.parent), turn_of(joint.parent),
                                          turn_before_of(system, joint.child), turn_of(joint.child)};
  const Matrix3d m = M - M.trace() * Matrix3d::Identity(), k = K - K.trace() * Matrix3d::Identity();
  const Matrix3d kB = k * now;
  const std::array<Vector3d, 4> slope{-2.0 * lie::vee(K), 2.0 * lie::vee(K), 2.0 * lie::vee(M), -2.0 * lie::vee(M)};
  const auto symmetric = [](const Matrix3d& matrix) { return Matrix3d(0.5 * (matrix + matrix.transpose())); };
  const auto set = [&](int a, int b, const Matrix3d& block) {
    hessian.block<3, 3>(place[at(a)], place[at(b)]) = block / scale;
    if (a != b) hessian.block<3, 3>(place[at(b)], place[at(a)]) = block.transpose() / scale;
  };
  for (int n = 0; n < 4; ++n) gradient.segment<3>(place[at(n)]) = slope[at(n)] / scale;
  // by the logarithm of the time step
  const TurnAllowed turn = turn_allowed(row.bound, node.time_step);
  const double by_bound = 2.0 * turn.sine / turn.angle;
  const double rate = by_bound - 2.0 * speed_value(before, now, turn);
  const Eigen::Index time = gradient.size() - 1;
  gradient[time] = rate / row.unit;
  hessian(time, time) = ((turn.whole ? 0.0 : 2.0 * turn.cosine) - by_bound - 2.0 * rate) / row.unit;
  for (Eigen::Index a = 0; a < time; ++a) hessian(a, time) = hessian(time, a) = -2.0 * gradient[a];
  set(0, 0, symmetric(k));
  set(1, 1, symmetric(k));
  set(0, 1, -k);
  set(2, 2, symmetric(m));
  set(3, 3, symmetric(m));
  set(2, 3, -m.transpose());
  set(0, 3, kB);
  set(1, 3, -kB);
  set(0, 2, -kB);
  set(1, 2, kB);
}

// The change of an angle over the step, rad, the shorter way round.
double angle_change(const System& system, const LimitRow& row, const LimitedNode& node) {
  const Joint& joint = system.joint(row.joint);
  const Vector3d axis = angle_axis(joint, row.freedom());
  const double now = twist_about(axis, joint, mechanics::child_to_parent(node.rotation, joint));
  const double before = twist_about(axis, joint, mechanics::child_to_parent(node.rotation_before, joint));
  return lie::shorter_way(now - before);
}

// Of 1 ± change/(bound h), by equation 10.2 at both ends of the step.
void rate_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, VectorXd& gradient,
                      MatrixXd& hessian) {
  const Joint& joint = system.joint(row.joint);
  const Vector3d axis = angle_axis(joint, row.freedom());
  const double scale = (row.kind == Kind::rate_above ? 1.0 : -1.0) / (row.bound * node.time_step * row.unit);
  const auto add = [&](const mechanics::Rotations& R, double factor, Eigen::Index parent, Eigen::Index child) {
    const TwistDerivatives twist = twist_derivatives(axis, joint, mechanics::child_to_parent(R, joint));
    const std::array<Eigen::Index, 2> place{parent, child};
    for (int a = 0; a < 2; ++a) {
      gradient.segment<3>(place[at(a)]) = factor * twist.gradient.segment<3>(3 * a);
      for (int b = 0; b < 2; ++b)
        hessian.block<3, 3>(place[at(a)], place[at(b)]) = factor * twist.hessian.block<3, 3>(3 * a, 3 * b);
    }
  };
  add(node.rotation, scale, turn_of(joint.parent), turn_of(joint.child));
  add(node.rotation_before, -scale, turn_before_of(system, joint.parent), turn_before_of(system, joint.child));
  const Eigen::Index time = gradient.size() - 1;
  hessian.col(time).head(time) = -gradient.head(time);
  hessian.row(time).head(time) = hessian.col(time).head(time).transpose();
  hessian(time, time) = scale * angle_change(system, row, node);
  gradient[time] = -hessian(time, time);
}

void half_space_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, VectorXd& gradient,
                            MatrixXd& hessian) {
  const model::Body& body = system.body(row.body);
  const Vector3d m = node.rotation[at(row.body)].transpose() * row.normal;
  const Matrix3d square = body.semi_axes.cwiseAbs2().asDiagonal();
  const double h = support(body.semi_axes, m);
  const Vector3d by_m = square * m / h;
  const Matrix3d by_m_m = (square - by_m * by_m.transpose()) / h;
  Vector9d local = Vector9d::Zero();
  Matrix9d local_hessian = Matrix9d::Zero();
  local.segment<3>(3) = -by_m.cross(m);
  local.tail<3>() = row.normal;
  local_hessian.block<3, 3>(3, 3) = -double_cross(by_m, m) - hat(m).transpose() * by_m_m * hat(m);
  spread_pair(system, node, -1, row.body, local / row.unit, local_hessian / row.unit, gradient, hessian);
}

void gap_row_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, Vector3d& across,
                         VectorXd& gradient, MatrixXd& hessian) {
  const bool sphere = row.kind == Kind::sphere;
  const fluid::EllipsoidPair pair = sphere ? pair_with_sphere(system, row, node) : pair_of_bodies(system, row, node);
  Vector9d local;
  Matrix9d local_hessian;
  const fluid::Gap gap = fluid::gap_across(pair, across);
  fluid::gap_derivatives(pair, gap, local, local_hessian);
  if (sphere) {
    local.head<3>().setZero();  // a sphere does not turn
    local_hessian.topRows<3>().setZero();
    local_hessian.leftCols<3>().setZero();
  }
  spread_pair(system, node, sphere ? -1 : row.body, sphere ? row.body : row.other_body, local / row.unit,
              local_hessian / row.unit, gradient, hessian);
}

Vector3d turn_error(const LimitRow& row, const LimitedNode& node) {
  return lie::log(row.asked.transpose() * node.rotation[at(row.body)]);
}

void pass_turn_derivatives(const LimitRow& row, const LimitedNode& node, VectorXd& gradient, MatrixXd& hessian) {
  const Vector3d error = turn_error(row, node);
  const Matrix3d tangent = lie::log_tangent(error);
  const Eigen::Index place = turn_of(row.body);
  gradient.segment<3>(place) = tangent.row(row.component).transpose() / row.unit;
  Matrix3d second;
  for (int c = 0; c < 3; ++c)
    second.col(c) = lie::log_tangent_rate(error, tangent.col(c)).row(row.component).transpose();
  hessian.block<3, 3>(place, place) = 0.5 * (second + second.transpose()) / row.unit;
}

// N m, in the frame of Joint::actuation's columns.
Vector3d joint_moment(const System& system, int joint, const VectorXd& moment) {
  const auto& actuation = system.joint(joint).actuation;
  return actuation * moment.segment(system.joint(joint).first_control, actuation.cols());
}

double angle_of(const System& system, const LimitRow& row, const LimitedNode& node) {
  const Joint& joint = system.joint(row.joint);
  return twist_about(angle_axis(joint, row.freedom()), joint, mechanics::child_to_parent(node.rotation, joint));
}

double plain_value(const System& system, const LimitRow& row, const LimitedNode& node, double enough,
                   Vector3d& across) {
  switch (row.kind) {
    case Kind::torque:
      return 1.0 - joint_moment(system, row.joint, node.moment).norm() / row.bound;
    case Kind::torque_component:
      return 1.0 - std::abs(node.moment[system.joint(row.joint).first_control + row.component]) / row.bound;
    case Kind::swing: {
      const Joint& joint = system.joint(row.joint);
      return parent_arm(joint).dot(mechanics::child_to_parent(node.rotation, joint) * child_arm(joint)) -
             std::cos(row.bound);
    }
    case Kind::twist:
      return row.bound - std::abs(twist(system.joint(row.joint), node.rotation));
    case Kind::angle_above:
      return angle_of(system, row, node) - row.bound;
    case Kind::angle_below:
      return row.bound - angle_of(system, row, node);
    case Kind::speed: {
      const Joint& joint = system.joint(row.joint);
      return speed_value(mechanics::child_to_parent(node.rotation_before, joint),
                         mechanics::child_to_parent(node.rotation, joint), turn_allowed(row.bound, node.time_step));
    }
    case Kind::rate_above:
      return 1.0 + angle_change(system, row, node) / (row.bound * node.time_step);
    case Kind::rate_below:
      return 1.0 - angle_change(system, row, node) / (row.bound * node.time_step);
    case Kind::clearance: {
      const fluid::EllipsoidPair pair = pair_of_bodies(system, row, node);
      return fluid::gap_or_enough(pair, enough * row.unit + row.bound, across) - row.bound;
    }
    case Kind::sphere: {
      const fluid::EllipsoidPair pair = pair_with_sphere(system, row, node);
      return fluid::gap_or_enough(pair, enough * row.unit, across);
    }
    case Kind::half_space:
      return row.normal.dot(mass_centre(system, node, row.body) - row.centre) -
             support(system.body(row.body).semi_axes, node.rotation[at(row.body)].transpose() * row.normal);
    case Kind::pass_position:
      return node.position[row.component] - row.bound;
    case Kind::pass_turn:
      return turn_error(row, node)[row.component];
    case Kind::not_shorter:
      return node.duration / row.bound - 1.0;
    case Kind::not_longer:
      return 1.0 - node.duration / row.bound;
  }
  return 0.0;
}

}  // namespace

double limit_value(const System& system, const LimitRow& row, const LimitedNode& node, double enough,
                   Vector3d& across) {
  return plain_value(system, row, node, enough, across) / row.unit;
}

double limit_value(const System& system, const LimitRow& row, const LimitedNode& node, double enough) {
  Vector3d across = Vector3d::Zero();
  return limit_value(system, row, node, enough, across);
}

void limit_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, VectorXd& gradient,
                       MatrixXd& hessian) {
  Vector3d across = Vector3d::Zero();
  limit_derivatives(system, row, node, across, gradient, hessian);
}

void limit_derivatives(const System& system, const LimitRow& row, const LimitedNode& node, Vector3d& across,
                       VectorXd& gradient, MatrixXd& hessian) {
  gradient.setZero(body_coordinates(system));
  hessian.setZero(gradient.size(), gradient.size());
  switch (row.kind) {
    case Kind::swing:
      return swing_derivatives(system, row, node, gradient, hessian);
    case Kind::twist: {
      const Joint& joint = system.joint(row.joint);
      const double scale = twist(joint, node.rotation) < 0.0 ? 1.0 : -1.0;  // of bound − |τ|
      return add_twist(row, joint, child_arm(joint), scale, node, gradient, hessian);
    }
    case Kind::angle_above:
    case Kind::angle_below: {
      const Joint& joint = system.joint(row.joint);
      const double scale = row.kind == Kind::angle_above ? 1.0 : -1.0;
      return add_twist(row, joint, angle_axis(joint, row.freedom()), scale, node, gradient, hessian);
    }
    case Kind::speed:
      return speed_derivatives(system, row, node, gradient, hessian);
    case Kind::rate_above:
    case Kind::rate_below:
      return rate_derivatives(system, row, node, gradient, hessian);
    case Kind::clearance:
    case Kind::sphere:
      return gap_row_derivatives(system, row, node, across, gradient, hessian);
    case Kind::half_space:
      return half_space_derivatives(system, row, node, gradient, hessian);
    case Kind::pass_position:
      gradient[position_of(system) + row.component] = 1.0 / row.unit;
      return;
    case Kind::pass_turn:
      return pass_turn_derivatives(row, node, gradient, hessian);
    case Kind::not_shorter:
    case Kind::not_longer: {
      const Eigen::Index time = gradient.size() - 1;
      gradient[time] = hessian(time, time) =
          (row.kind == Kind::not_shorter ? 1.0 : -1.0) * node.duration / row.bound / row.unit;
      return;
    }
    case Kind::torque:
    case Kind::torque_component:
      return;
  }
}

double price_of_bound(const LimitRow& row, double time_step, double value) {
  switch (row.kind) {
    case Kind::torque:
    case Kind::torque_component:
      return 1.0 / row.bound / row.unit;
    case Kind::swing: {
      const double cosine = std::cos(row.bound) + row.unit * value;
      return std::sqrt(std::max(1.0 - cosine * cosine, 0.0)) / row.unit;
    }
    case Kind::speed: {
      const TurnAllowed turn = turn_allowed(row.bound, time_step);
      const double square = turn.angle * turn.angle;
      const double half_sine_squared = turn.half_sine * turn.half_sine - 0.25 * square * row.unit * value;
      const double half_sine = std::sqrt(std::clamp(half_sine_squared, 0.0, 1.0));
      return 4.0 * half_sine * std::sqrt(1.0 - half_sine * half_sine) * time_step / square / row.unit;
    }
    case Kind::rate_above:
    case Kind::rate_below:
    case Kind::not_shorter:
    case Kind::not_longer:
      return 1.0 / row.bound / row.unit;
    default:
      return 1.0 / row.unit;
  }
}

void torque_derivatives(const System& system, const LimitRow& row, const VectorXd& moment, VectorXd& gradient,
                        MatrixXd& hessian) {
  gradient.setZero(system.control_count());
  hessian.setZero(gradient.size(), gradient.size());
  const Eigen::Index first = system.joint(row.joint).first_control;
  const double scale = -1.0 / (row.bound * row.unit);
  if (row.kind == Kind::torque_component) {
    gradient[first + row.component] = moment[first + row.component] < 0.0 ? -scale : scale;
    return;
  }
  const auto& actuation = system.joint(row.joint).actuation;
  const Eigen::Index columns = actuation.cols();
  const Vector3d u = joint_moment(system, row.joint, moment);
  const double size = u.norm();
  if (size == 0.0) return;  // far from any bound
  const auto along = actuation.transpose() * (u / size);
  gradient.segment(first, columns) = scale * along;
  hessian.block(first, first, columns, columns) =
      scale / size * (actuation.transpose() * actuation - along * along.transpose());
}

}  // namespace lamprey::maneuver
