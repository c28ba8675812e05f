#include "transcription/shooting.hpp"

#include <limits>

#include "maneuver/control_path.hpp"
#include "maneuver/motion.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::transcription {

namespace {

using maneuver::natural_spline_basis;
using maneuver::spline_points;
using model::at;

// Quaternion of the error R_goalᵀ R, of the sign with scalar part ≥ 0.
Eigen::Vector4d error_quaternion(const Matrix3d& goal, const Matrix3d& R) {
  return lie::quaternion_of_rotation(goal.transpose() * R);
}

}  // namespace

Shooting::Shooting(const model::System& system, const Maneuver& maneuver, std::vector<GoalRow> goal_rows)
    : system_(system),
      maneuver_(maneuver),
      scale_(inertia_scale(system, maneuver)),
      unit_(100.0 * scale_),
      goal_rows_(std::move(goal_rows)),
      points_(maneuver.spline_points),
      controls_(system.control_count()),
      basis_(natural_spline_basis(maneuver.spline_points, maneuver.duration,
                                  VectorXd::LinSpaced(maneuver.steps + 1, 0.0, maneuver.duration))),
      zero_(VectorXd::Zero(static_cast<Eigen::Index>(goal_rows_.size()))) {
  for (int r = 0; r < constraint_count(); ++r)
    for (int v = 0; v < variable_count(); ++v) jacobian_pattern_.add(r, v);
}

VectorXd Shooting::constraint_units() const {
  VectorXd units = VectorXd::Ones(constraint_count());
  for (int r = 0; r < constraint_count(); ++r) {
    if (goal_rows_[at(r)].kind == GoalRow::Kind::position) units[r] = system_.length_unit();
    if (goal_rows_[at(r)].kind == GoalRow::Kind::rest) units[r] = scale_ * maneuver_.duration;
  }
  return units;
}

VectorXd Shooting::node_control(const VectorXd& x, int node) const {
  return unit_ * (Eigen::Map<const MatrixXd>(x.data(), points_, controls_).transpose() * basis_.row(node).transpose());
}

double Shooting::objective(const VectorXd& x) {
  double cost = 0.0;
  for (int k = 0; k <= maneuver_.steps; ++k) cost += 0.5 * maneuver_.node_weight[k] * node_control(x, k).squaredNorm();
  return cost / (unit_ * scale_);
}

void Shooting::gradient(const VectorXd& x, VectorXd& g) {
  MatrixXd by_points = MatrixXd::Zero(points_, controls_);
  for (int k = 0; k <= maneuver_.steps; ++k)
    by_points += maneuver_.node_weight[k] * basis_.row(k).transpose() * node_control(x, k).transpose();
  g = by_points.reshaped() / scale_;
}

bool Shooting::march(const VectorXd& x) {
  if (point_.size() == x.size() && point_ == x) return marched_;
  point_ = x;
  marched_ = false;
  path_ = NodePath();
  end_ = maneuver_.start;
  integrator::StepWorkspace work(system_);
  path_.rotation.push_back(end_.rotation);
  path_.position.push_back(end_.position);
  path_.control.push_back(node_control(x, 0));
  for (int k = 0; k < maneuver_.steps; ++k) {
    path_.control.push_back(node_control(x, k + 1));
    const auto report = advance(system_, maneuver_.lagrangian, maneuver_.time_step(),
                                mechanics::joint_moments(system_, path_.control[at(k)]),
                                mechanics::joint_moments(system_, path_.control.back()), end_, work);
    if (!report.converged) return false;
    path_.cayley.push_back(work.interval.cayley);
    path_.rotation.push_back(end_.rotation);
    path_.position.push_back(end_.position);
  }
  return marched_ = true;
}

void Shooting::constraints(const VectorXd& x, VectorXd& c) {
  if (!march(x)) {
    c.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  for (int r = 0; r < constraint_count(); ++r) {
    const GoalRow& row = goal_rows_[at(r)];
    if (row.kind == GoalRow::Kind::rotation)
      c[r] =
          2.0 * error_quaternion(*maneuver_.end_rotation[at(row.body)], end_.rotation[at(row.body)])[1 + row.component];
    else if (row.kind == GoalRow::Kind::joint)
      c[r] = 2.0 * joint_error(row.body)[1 + row.component];
    else if (row.kind == GoalRow::Kind::position)
      c[r] = end_.position[row.component] - *maneuver_.end_position[at(row.component)];
    else
      c[r] = end_.momentum[3 * row.body + row.component];
  }
}

// How far a body's joint ends from what is asked for.
Eigen::Vector4d Shooting::joint_error(int body) const {
  const int joint = system_.body(body).joint;
  return error_quaternion(*maneuver_.end_joint[at(joint)],
                          mechanics::child_to_parent(end_.rotation, system_.joint(joint)));
}

// Gradients of the goal rows by the end state.
MatrixXd Shooting::end_rows() const {
  const integrator::StateLayout layout{system_};
  MatrixXd rows = MatrixXd::Zero(constraint_count(), layout.size());
  for (int r = 0; r < constraint_count(); ++r) {
    const GoalRow& row = goal_rows_[at(r)];
    if (row.kind == GoalRow::Kind::rotation) {
      const Eigen::Vector4d q = error_quaternion(*maneuver_.end_rotation[at(row.body)], end_.rotation[at(row.body)]);
      const Matrix3d by_turn = q[0] * Matrix3d::Identity() + lie::hat(q.tail<3>());
      rows.block<1, 3>(r, layout.freedom(row.body)) = by_turn.row(row.component);
    } else if (row.kind == GoalRow::Kind::joint) {
      const Eigen::Vector4d q = joint_error(row.body);
      const Matrix3d by_turn = q[0] * Matrix3d::Identity() + lie::hat(q.tail<3>());
      const Matrix3d seen = mechanics::child_to_parent(end_.rotation, system_.joint(system_.body(row.body).joint));
      rows.block<1, 3>(r, layout.freedom(row.body)) = by_turn.row(row.component);
      rows.block<1, 3>(r, layout.freedom(system_.body(row.body).parent)) =
          -by_turn.row(row.component) * seen.transpose();
    } else if (row.kind == GoalRow::Kind::position) {
      rows(r, layout.position() + row.component) = 1.0;
    } else {
      rows(r, layout.momentum(row.body) + row.component) = 1.0;
    }
  }
  return rows;
}

void Shooting::jacobian(const VectorXd& x, VectorXd& values) {
  values.resize(jacobian_pattern_.size());
  if (!march(x)) {
    values.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const auto source = [this](int k, mechanics::Interval& step) {
    step.rotation = path_.rotation[at(k)];
    step.cayley = path_.cayley[at(k)];
    step.displacement = path_.position[at(k + 1)] - path_.position[at(k)];
    mechanics::update_interval(system_, step);
  };
  std::vector<mechanics::Moments> moments;
  for (const VectorXd& u : path_.control) moments.push_back(mechanics::joint_moments(system_, u));
  const MatrixXd by_nodes = integrator::gradient_sweep(system_, maneuver_.lagrangian, maneuver_.time_step(), source,
                                                       moments, {0, maneuver_.steps}, end_rows())
                                .by_control;
  for (int r = 0; r < constraint_count(); ++r) {
    const VectorXd row = by_nodes.row(r);
    const Eigen::Map<const MatrixXd> by_node(row.data(), controls_, maneuver_.steps + 1);
    const MatrixXd by_points = unit_ * (basis_.transpose() * by_node.transpose());
    values.segment(r * variable_count(), variable_count()) = by_points.reshaped();
  }
}

double Shooting::goal_error(const VectorXd& x) {
  if (!march(x)) return std::numeric_limits<double>::infinity();
  double error = 0.0;
  for (int i = 0; i < system_.body_count(); ++i)
    if (maneuver_.end_rotation[at(i)])
      error = std::max(error, lie::rotation_angle(maneuver_.end_rotation[at(i)]->transpose() * end_.rotation[at(i)]));
  for (int i = 1; i < system_.body_count(); ++i)
    if (const int joint = system_.body(i).joint; maneuver_.tells_joint(joint)) {
      const Matrix3d now = mechanics::child_to_parent(end_.rotation, system_.joint(joint));
      error = std::max(error, lie::rotation_angle(maneuver_.end_joint[at(joint)]->transpose() * now));
    }
  for (int c = 0; c < 3; ++c)
    if (maneuver_.end_position[at(c)])
      error = std::max(error, std::abs(end_.position[c] - *maneuver_.end_position[at(c)]));
  return error;
}

VectorXd Shooting::pack(const NodePath& path) const {
  MatrixXd samples(maneuver_.steps + 1, controls_);
  for (int k = 0; k <= maneuver_.steps; ++k) samples.row(k) = path.control[at(k)].transpose() / unit_;
  return spline_points(basis_, samples).reshaped();
}

NodePath Shooting::unpack(const VectorXd& x) {
  march(x);
  return path_;
}

}  // namespace lamprey::transcription
