#include "transcription/transcription.hpp"

#include <cmath>

#include "maneuver/control_path.hpp"
#include "maneuver/step_chart.hpp"

namespace lamprey::transcription {

namespace {

using Eigen::Vector4d;
using maneuver::advanced_quaternion;
using maneuver::advanced_quaternion_by_cayley;
using maneuver::advanced_quaternion_by_quaternion;
using maneuver::applies;
using maneuver::natural_spline_basis;
using maneuver::StepChart;
using mechanics::Interval;
using model::System;

using model::at;

constexpr double unbounded = 2e19;     // as Ipopt has it
constexpr double farthest_sign = 2.0;  // of a power, whose work is at least at ±1

bool is_ancestor(const System& system, int ancestor, int body) {
  for (int i = body; i >= 0; i = system.body(i).parent)
    if (i == ancestor) return true;
  return false;
}

}  // namespace

double inertia_scale(const System& system, const Maneuver& maneuver) {
  const std::vector<Vector3d> centres = system.mass_centres(maneuver.start.rotation, maneuver.start.position);
  double inertia = 0.0;
  for (int i = 0; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    inertia += body.inertia_matrix.diagonal().maxCoeff() +
               body.mass_matrix.diagonal().maxCoeff() * (centres[at(i)] - centres[0]).squaredNorm();
  }
  return inertia / (300.0 * maneuver.duration * maneuver.duration);
}

Transcription::Transcription(const System& system, const Maneuver& maneuver, std::vector<GoalRow> goal_rows,
                             std::vector<LimitRow> limits)
    : system_(system),
      scale_(inertia_scale(system, maneuver)),
      free_(system.with_ball_joints(1.0 / scale_)),
      maneuver_(maneuver),
      goal_rows_(std::move(goal_rows)),
      limits_(std::move(limits)),
      bodies_(system.body_count()),
      steps_(maneuver.steps),
      controls_(system.control_count()),
      h_(maneuver.time_step()),
      intervals_(at(maneuver.steps), Interval(system.body_count())),
      momenta_(at(maneuver.steps), mechanics::DiscreteMomenta(system.body_count())),
      work_(system.body_count()),
      lagrangian_(system.body_count()),
      directional_(system.body_count()),
      jacobian_(system.body_count()) {
  lay_out();
  lay_patterns();
}

void Transcription::lay_out() {
  for (const GoalRow& row : goal_rows_)
    rests_ = rests_ || row.kind == GoalRow::Kind::rest || row.kind == GoalRow::Kind::recurrence;
  for (const model::Joint& joint : system_.joints()) {
    moment_place_.push_back(carries(joint) ? controls_ + reactions_ : joint.first_control);
    if (!carries(joint)) continue;
    const int freedoms = system_.body(joint.child).freedoms;
    reactions_ += 3;
    axis_rows_ += freedoms;
    joint_rows_ += 3 - freedoms;
  }
  const int others = bodies_ - 1;  // but the root
  stage_size_ = node_size() + 7 * bodies_ + 3;
  stage_rows_ = 4 * bodies_ + 6 + axis_rows_ + joint_rows_ + 3 * others;
  start_variable_ = steps_ * stage_size_ + node_size();
  variable_count_ = start_variable_ + (maneuver_.free_shape ? 4 * others : 0);
  if (maneuver_.free_duration) stretch_variable_ = variable_count_++;
  lay_costs();
  spline_variable_ = variable_count_;
  start_row_ = stage_row(steps_) + end_axis_rows();
  limit_row_ =
      start_row_ + (maneuver_.free_shape ? joint_rows_ + others : 0) + (maneuver_.periodic ? free_.control_count() : 0);
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < limits_.size(); ++r)
      if (applies(limits_[r], k, steps_, maneuver_.duration)) limited_.push_back({r, k});
  cost_row_ = limit_row_ + static_cast<int>(limited_.size());
  constraint_count_ = spline_row();
  if (maneuver_.spline_points > 0) {
    const VectorXd times = VectorXd::LinSpaced(steps_ + 1, 0.0, maneuver_.duration);
    spline_basis_ = natural_spline_basis(maneuver_.spline_points, maneuver_.duration, times);
    variable_count_ += maneuver_.spline_points * controls_;
    constraint_count_ += (steps_ + 1) * controls_;
  }
  lower_ = upper_ = VectorXd::Zero(constraint_count_);
  for (std::size_t l = 0; l < limited_.size(); ++l)
    if (!limits_[limited_[l].row].equality()) upper_[limit_row() + static_cast<int>(l)] = unbounded;
  if (worked_) {  // e ± d ≥ 0, and S, which e = 0 does not hold, not far from ±1
    const int joints = static_cast<int>(powered_.size()), first = cost_row_ + steps_ * controls_;
    for (int n = 0; n < (steps_ + 1) * joints; ++n) {
      upper_.segment<2>(first + 6 * n + 3).setConstant(unbounded);
      upper_[first + 6 * n + 5] = farthest_sign;
      lower_[first + 6 * n + 5] = -farthest_sign;
    }
  }
  related_.assign(at(bodies_), std::vector<char>(at(bodies_)));
  for (int i = 0; i < bodies_; ++i)
    for (int a = 0; a < bodies_; ++a) related_[at(i)][at(a)] = is_ancestor(system_, a, i) || is_ancestor(system_, i, a);
  start_momentum_ = start_momenta();
}

VectorXd Transcription::variable_units() const {
  const double length = system_.length_unit();
  if (length == 1.0) return {};
  VectorXd units = VectorXd::Ones(variable_count_);
  for (int k = 1; k <= steps_; ++k) units.segment<3>(position_variable(k)).setConstant(length);
  return units;
}

// Beside angular momenta, which are of order one, linear ones are of one over a length.
VectorXd Transcription::constraint_units() const {
  const double length = system_.length_unit();
  if (length == 1.0) return {};
  VectorXd units = VectorXd::Ones(constraint_count_);
  for (int k = 0; k < steps_; ++k) units.segment<3>(momentum_row(k)).setConstant(1.0 / length);
  for (std::size_t r = 0; r < goal_rows_.size(); ++r)
    if (goal_rows_[r].kind == GoalRow::Kind::position) units[goal_row() + static_cast<int>(r)] = length;
  return units;
}

// The derivative functions themselves record their pattern, at an arbitrary point: order and places never depend on it.
void Transcription::lay_patterns() {
  NodePath still;
  still.rotation.assign(at(steps_ + 1), maneuver_.start.rotation);
  still.position.assign(at(steps_ + 1), maneuver_.start.position);
  still.cayley.assign(at(steps_), std::vector<Vector3d>(at(bodies_), Vector3d::Zero()));
  still.control.assign(at(steps_ + 1), VectorXd::Zero(controls_));
  const VectorXd x = pack(still);
  VectorXd unused;
  jacobian(x, unused);
  hessian(x, 1.0, VectorXd::Zero(constraint_count_), unused);
}

// Angular momenta of all bodies at the start, each turning by itself about the joints that hold it.
std::vector<Vector3d> Transcription::start_momenta() const {
  const integrator::State& start = maneuver_.start;
  std::vector<Vector3d> momentum(at(bodies_), Vector3d::Zero());
  if (start.momentum.isZero(0.0)) return momentum;
  const VectorXd velocity = mechanics::velocity_of_momentum(system_, start.rotation, start.momentum);
  const mechanics::Vectors turn = mechanics::angular_velocities(system_, start.rotation, velocity);
  VectorXd freely(free_.velocity_count());
  for (int i = 0; i < bodies_; ++i) freely.segment<3>(free_.body(i).velocity_offset) = turn[at(i)];
  freely.tail<3>() = velocity.tail<3>();
  const VectorXd all = mechanics::generalized_momentum(free_, start.rotation, freely);
  for (int i = 0; i < bodies_; ++i) momentum[at(i)] = all.segment<3>(free_.body(i).velocity_offset);
  return momentum;
}

// ---- reading the point ----

double Transcription::stretch(const VectorXd& x) const {
  return stretch_variable_ < 0 ? 1.0 : std::exp(x[stretch_variable_]);
}

Vector4d Transcription::quaternion(int node, int body) const {
  const int variable = quaternion_variable(node, body);
  if (variable < 0) return lie::quaternion_of_rotation(maneuver_.start.rotation[at(body)]);
  return point_.segment<4>(variable);
}

Vector3d Transcription::position(int node) const {
  return node == 0 ? maneuver_.start.position : Vector3d(point_.segment<3>(position_variable(node)));
}

// N m, along the joints' actuation: variables are what a motion of the first guess's duration would take.
VectorXd Transcription::controls(int node) const {
  const double s = stretch();
  return control_unit() / (s * s) * point_.segment(control_variable(node), controls_);
}

// On the parents, in the time of the first guess's duration and of units of scale_ N m.
mechanics::Moments Transcription::moments(int node) const {
  mechanics::Moments u(at(system_.joint_count()));
  for (int j = 0; j < system_.joint_count(); ++j) {
    const auto& actuation = free_.joint(j).actuation;
    u[at(j)] = unit * (actuation * point_.segment(moment_variable(node, j), actuation.cols()));
  }
  return u;
}

mechanics::Rotations Transcription::rotations(int node) const {
  mechanics::Rotations R(at(bodies_));
  for (int i = 0; i < bodies_; ++i) R[at(i)] = lie::rotation_of_quaternion(quaternion(node, i));
  return R;
}

void Transcription::move_to(const VectorXd& x) {
  if (point_.size() == x.size() && point_ == x) return;
  point_ = x;
  for (int k = 0; k < steps_; ++k) {
    Interval& step = intervals_[at(k)];
    for (int i = 0; i < bodies_; ++i) {
      step.rotation[at(i)] = lie::rotation_of_quaternion(quaternion(k, i));
      step.cayley[at(i)] = 0.5 * h_ * point_.segment<3>(turn_variable(k, i));
    }
    step.displacement = position(k + 1) - position(k);
    mechanics::update_interval(free_, step);
    mechanics::discrete_momenta(free_, maneuver_.lagrangian, h_, step, momenta_[at(k)]);
  }
}

// ---- cost, in units of cost_unit, so that gradients are of order one ----

double Transcription::objective(const VectorXd& x) {
  double cost = 0.0;
  for (int k = 0; k <= steps_; ++k)
    cost += 0.5 * maneuver_.node_weight[k] * x.segment(control_variable(k), controls_).squaredNorm();
  return cost * unit / std::pow(stretch(x), 3) + maneuver_.time_weight * duration(x) / cost_unit() +
         other_costs(x).sum() - won(x);
}

double Transcription::won(const VectorXd& x) const {
  return maneuver_.cost_weights.displacement.dot(x.segment<3>(position_variable(steps_)) - position(0)) / cost_unit();
}

void Transcription::gradient(const VectorXd& x, VectorXd& g) {
  g.setZero();
  const double scale = unit / std::pow(stretch(x), 3);
  for (int k = 0; k <= steps_; ++k)
    g.segment(control_variable(k), controls_) =
        scale * maneuver_.node_weight[k] * x.segment(control_variable(k), controls_);
  if (stretch_variable_ >= 0) {
    const double timed = maneuver_.time_weight * duration(x) / cost_unit();
    g[stretch_variable_] = timed - 3.0 * (objective(x) - timed - other_costs(x).sum() + won(x));
  }
  g.segment<3>(position_variable(steps_)) -= maneuver_.cost_weights.displacement / cost_unit();
  add_cost_gradient(x, g);
}

// ---- constraints ----

bool Transcription::balance_at(int node) const {
  if (node == steps_) return rests_;
  return node > 0 || !maneuver_.periodic || rests_;
}

void Transcription::constraints(const VectorXd& x, VectorXd& c) {
  move_to(x);
  const Vector3d linear = stretch() / scale_ * maneuver_.total.linear;
  for (int k = 0; k < steps_; ++k) {
    const mechanics::DiscreteMomenta& momenta = momenta_[at(k)];
    Vector3d angular = position(k).cross(linear) - stretch() / scale_ * maneuver_.total.angular;
    for (int i = 0; i < bodies_; ++i) {
      angular += intervals_[at(k)].rotation[at(i)] * momenta.minus[at(i)];
      c.segment<4>(kinematic_row(k, i)) =
          quaternion(k + 1, i) - advanced_quaternion(quaternion(k, i), intervals_[at(k)].cayley[at(i)]);
    }
    c.segment<3>(momentum_row(k)) = momenta.linear - linear;
    c.segment<3>(momentum_row(k) + 3) = angular;
    axis_values(k, c);
    joint_values(k + 1, c);
    if (k == 0 && maneuver_.periodic) continue;
    const VectorXd force =
        force_weight(k) * mechanics::generalized_force(free_, intervals_[at(k)].rotation, moments(k));
    for (int i = 1; i < bodies_; ++i) {
      const Vector3d before = k == 0 ? Vector3d(stretch() * start_momentum_[at(i)]) : momenta_[at(k - 1)].plus[at(i)];
      c.segment<3>(balance_row(k, i)) = momenta.minus[at(i)] - before - force.segment<3>(3 * i);
    }
  }
  axis_values(steps_, c);
  if (maneuver_.free_shape) {
    joint_values(0, c);
    for (int i = 1; i < bodies_; ++i) c[length_row(i)] = 0.5 * (quaternion(0, i).squaredNorm() - 1.0);
  }
  if (maneuver_.periodic)
    for (int j = 0, row = ends_row(); j < system_.joint_count(); ++j) {
      const Eigen::Index moments = free_.joint(j).actuation.cols();
      c.segment(row, moments) =
          x.segment(moment_variable(0, j), moments) - x.segment(moment_variable(steps_, j), moments);
      row += static_cast<int>(moments);
    }
  cost_values(c);
  for (std::size_t l = 0; l < limited_.size(); ++l) c[limit_row() + static_cast<int>(l)] = value_of(limited_[l]);
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) c[goal_row() + static_cast<int>(r)] = value_of(goal_rows_[r]);
  if (maneuver_.spline_points == 0) return;
  for (int k = 0; k <= steps_; ++k)
    for (int m = 0; m < controls_; ++m)
      c[spline_row() + k * controls_ + m] =
          x[control_variable(k) + m] -
          spline_basis_.row(k).dot(x.segment(spline_variable_ + m * maneuver_.spline_points, maneuver_.spline_points));
}

// ---- Jacobian ----

void Transcription::jacobian(const VectorXd& x, VectorXd& values) {
  move_to(x);
  BlockSink sink(jacobian_pattern_, values);
  for (int k = 0; k < steps_; ++k) {
    emit_kinematics(k, sink);
    emit_step_jacobian(k, sink);
    emit_force_jacobian(k, sink);
    emit_axis_jacobian(k, sink);
    emit_joint_jacobian(k + 1, sink);
  }
  emit_axis_jacobian(steps_, sink);
  if (maneuver_.free_shape) {
    emit_joint_jacobian(0, sink);
    for (int i = 1; i < bodies_; ++i) sink.add(length_row(i), quaternion_variable(0, i), quaternion(0, i).transpose());
  }
  if (stretch_variable_ >= 0 && !maneuver_.periodic)
    for (int i = 1; i < bodies_; ++i)
      sink.add(balance_row(0, i), stretch_variable_, -stretch() * start_momentum_[at(i)]);
  if (maneuver_.periodic)
    for (int j = 0, row = ends_row(); j < system_.joint_count(); ++j) {
      const Eigen::Index moments = free_.joint(j).actuation.cols();
      sink.add(row, moment_variable(0, j), MatrixXd::Identity(moments, moments));
      sink.add(row, moment_variable(steps_, j), -MatrixXd::Identity(moments, moments));
      row += static_cast<int>(moments);
    }
  emit_limit_jacobian(sink);
  emit_cost_rows_jacobian(sink);
  emit_goal_jacobian(sink);
}

void Transcription::emit_kinematics(int k, BlockSink& sink) const {
  for (int i = 0; i < bodies_; ++i) {
    const int row = kinematic_row(k, i);
    const Vector3d& zeta = intervals_[at(k)].cayley[at(i)];
    sink.add(row, quaternion_variable(k + 1, i), Eigen::Matrix4d::Identity());
    if (const int q = quaternion_variable(k, i); q >= 0) sink.add(row, q, -advanced_quaternion_by_quaternion(zeta));
    sink.add(row, turn_variable(k, i), -0.5 * h_ * advanced_quaternion_by_cayley(quaternion(k, i), zeta));
  }
}

void Transcription::emit_step_jacobian(int k, BlockSink& sink) {
  const Interval& step = intervals_[at(k)];
  mechanics::lagrangian_quadratic(free_, maneuver_.lagrangian, h_, step, work_, lagrangian_);
  mechanics::momentum_jacobian(lagrangian_, jacobian_);
  const mechanics::StepLayout layout{bodies_};
  MatrixXd angular = MatrixXd::Zero(3, layout.size());
  for (int i = 0; i < bodies_; ++i) {
    angular += step.rotation[at(i)] * jacobian_.minus.middleRows<3>(3 * i);
    angular.middleCols<3>(layout.left(i)) -= step.rotation[at(i)] * lie::hat(momenta_[at(k)].minus[at(i)]);
  }
  const auto emit = [&](int row, const auto& by_step, int body) {  // body < 0: couples to all
    for (int a = 0; a < bodies_; ++a) {
      if (body >= 0 && !related_[at(body)][at(a)]) continue;
      const StepChart chart(quaternion(k, a), step.cayley[at(a)], step.relative_rotation[at(a)], h_);
      if (const int q = quaternion_variable(k, a); q >= 0)
        sink.add(row, q,
                 by_step.template middleCols<3>(layout.left(a)) * chart.left_by_quaternion +
                     by_step.template middleCols<3>(layout.right(a)) * chart.right_by_quaternion);
      sink.add(row, turn_variable(k, a), by_step.template middleCols<3>(layout.right(a)) * chart.right_by_turn);
    }
    const auto by_shift = by_step.template rightCols<3>();
    if (k > 0) sink.add(row, position_variable(k), -by_shift);
    sink.add(row, position_variable(k + 1), by_shift);
  };
  emit(momentum_row(k), jacobian_.linear, -1);
  emit(momentum_row(k) + 3, angular, -1);
  const Vector3d linear = stretch() / scale_ * maneuver_.total.linear,
                 about_root = stretch() / scale_ * maneuver_.total.angular - position(k).cross(linear);
  if (k > 0) sink.add(momentum_row(k) + 3, position_variable(k), -lie::hat(linear));
  if (stretch_variable_ >= 0) {
    sink.add(momentum_row(k), stretch_variable_, -linear);
    sink.add(momentum_row(k) + 3, stretch_variable_, -about_root);
  }
  for (int i = 1; i < bodies_; ++i) {
    if (k > 0 || !maneuver_.periodic) emit(balance_row(k, i), jacobian_.minus.middleRows<3>(3 * i), i);
    if (k + 1 < steps_) emit(balance_row(k + 1, i), (-jacobian_.plus.middleRows<3>(3 * i)).eval(), i);
  }
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) {
    const GoalRow& goal = goal_rows_[r];
    const int row = goal_row() + static_cast<int>(r), place = 3 * goal.body + goal.component;
    if (goal.kind != GoalRow::Kind::rest && goal.kind != GoalRow::Kind::recurrence) continue;
    if (k + 1 == steps_) emit(row, jacobian_.plus.row(place).eval(), goal.body);
    if (k == 0 && goal.kind == GoalRow::Kind::recurrence) emit(row, (-jacobian_.minus.row(place)).eval(), goal.body);
  }
}

// Rows in which a component of weight · U at a node stands, with its sign.
std::vector<std::pair<int, double>> Transcription::end_force_rows(int node, int body, int component) const {
  if (node < steps_ && (node > 0 || !maneuver_.periodic)) return {{balance_row(node, body) + component, -1.0}};
  std::vector<std::pair<int, double>> rows;
  for (std::size_t r = 0; r < goal_rows_.size(); ++r) {
    const GoalRow& row = goal_rows_[r];
    const bool counts = row.kind == GoalRow::Kind::recurrence || (row.kind == GoalRow::Kind::rest && node == steps_);
    if (counts && row.body == body && row.component == component)
      rows.emplace_back(goal_row() + static_cast<int>(r), 1.0);
  }
  return rows;
}

void Transcription::emit_force_jacobian(int node, BlockSink& sink) const {
  if (!balance_at(node)) return;
  const mechanics::Moments u = moments(node);
  const double weight = force_weight(node);
  const auto emit = [&](int body, int column, const MatrixXd& block) {
    if (column < 0 || block.cols() == 0) return;
    for (int c = 0; c < 3; ++c)
      for (const auto& [row, sign] : end_force_rows(node, body, c)) sink.add(row, column, sign * weight * block.row(c));
  };
  for (int j = 0; j < system_.joint_count(); ++j) {
    const model::Joint& joint = free_.joint(j);
    const Vector4d q_child = quaternion(node, joint.child), q_parent = quaternion(node, joint.parent);
    const Matrix3d Q = lie::rotation_of_quaternion(q_child).transpose() * lie::rotation_of_quaternion(q_parent);
    const int column = moment_variable(node, j);
    const int child = quaternion_variable(node, joint.child), parent = quaternion_variable(node, joint.parent);
    if (joint.parent > 0) emit(joint.parent, column, unit * joint.actuation);
    // −R_cᵀR_p u: by η_c it is −ŷ, by η_p it is +Q û
    emit(joint.child, column, -unit * Q * joint.actuation);
    emit(joint.child, child, -lie::hat(Q * u[at(j)]) * lie::quaternion_tangent(q_child));
    emit(joint.child, parent, Q * lie::hat(u[at(j)]) * lie::quaternion_tangent(q_parent));
  }
}

// ---- points and motions ----

VectorXd Transcription::pack(const NodePath& path, double duration) {
  VectorXd x = VectorXd::Zero(variable_count_);
  if (stretch_variable_ >= 0 && duration > 0.0) x[stretch_variable_] = std::log(duration / maneuver_.duration);
  for (int i = 0; i < bodies_; ++i) {
    const int start = quaternion_variable(0, i);
    const Matrix3d& first = start < 0 ? maneuver_.start.rotation[at(i)] : path.rotation.front()[at(i)];
    Vector4d before = lie::quaternion_of_rotation(first);
    if (start >= 0) x.segment<4>(start) = before;
    for (int k = 0; k < steps_; ++k) {
      Vector4d q = lie::quaternion_of_rotation(path.rotation[at(k + 1)][at(i)]);
      if (q.dot(advanced_quaternion(before, path.cayley[at(k)][at(i)])) < 0.0) q = -q;
      x.segment<4>(quaternion_variable(k + 1, i)) = q;
      x.segment<3>(turn_variable(k, i)) = 2.0 / h_ * path.cayley[at(k)][at(i)];
      before = q;
    }
  }
  const double s = stretch(x);
  for (int k = 0; k < steps_; ++k) x.segment<3>(position_variable(k + 1)) = path.position[at(k + 1)];
  for (int k = 0; k <= steps_; ++k)
    x.segment(control_variable(k), controls_) = s * s / control_unit() * path.control[at(k)];
  if (reactions_ > 0) pack_reactions(path, x);
  pack_costs(x);
  if (maneuver_.spline_points == 0) return x;
  MatrixXd samples(steps_ + 1, controls_);
  for (int k = 0; k <= steps_; ++k) samples.row(k) = x.segment(control_variable(k), controls_).transpose();
  const MatrixXd coefficients = maneuver::spline_points(spline_basis_, samples);
  for (int m = 0; m < controls_; ++m)
    x.segment(spline_variable_ + m * maneuver_.spline_points, maneuver_.spline_points) = coefficients.col(m);
  return x;
}

NodePath Transcription::unpack(const VectorXd& x) const {
  NodePath path;
  path.rotation.push_back(maneuver_.start.rotation);
  path.position.push_back(maneuver_.start.position);
  if (maneuver_.free_shape)
    for (int i = 1; i < bodies_; ++i)
      path.rotation.front()[at(i)] = lie::rotation_of_quaternion(x.segment<4>(quaternion_variable(0, i)));
  for (int k = 0; k < steps_; ++k) {
    mechanics::Rotations R(at(bodies_));
    std::vector<Vector3d> cayley(at(bodies_));
    for (int i = 0; i < bodies_; ++i) {
      R[at(i)] = lie::rotation_of_quaternion(x.segment<4>(quaternion_variable(k + 1, i)));
      cayley[at(i)] = 0.5 * h_ * x.segment<3>(turn_variable(k, i));
    }
    path.rotation.push_back(R);
    path.cayley.push_back(cayley);
    path.position.push_back(x.segment<3>(position_variable(k + 1)));
  }
  const double s = stretch(x);
  for (int k = 0; k <= steps_; ++k)
    path.control.push_back(control_unit() / (s * s) * x.segment(control_variable(k), controls_));
  return path;
}

}  // namespace lamprey::transcription
