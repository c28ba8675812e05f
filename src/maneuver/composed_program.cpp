#include "maneuver/composed_program.hpp"

#include <algorithm>
#include <cmath>

namespace lamprey::maneuver {

namespace {

using mechanics::Freedoms;
using mechanics::Moments;
using mechanics::Rotations;
using model::at;
using model::System;
using optimizer::Merit;
using optimizer::Stage;
using optimizer::StageModel;
using optimizer::StageStep;

constexpr double longest_shape_turn = 0.6;  // rad, of one shape coordinate in one step of the search

StepLayout layout_of(const Maneuver& maneuver, Scheme scheme, const ShapeCoordinates& coordinates, int moments) {
  StepLayout layout;
  layout.shape = static_cast<int>(coordinates.shape.cols());
  layout.moments = moments;
  layout.terms = polynomial_terms(scheme);
  layout.pose_basis = coordinates.pose;
  for (double fraction : integrator::composition(scheme).fractions)
    layout.time.push_back(fraction * maneuver.time_step());
  return layout;
}

std::vector<EndRow> without_moments(const std::vector<EndRow>& rows) {
  std::vector<EndRow> kept;
  for (const EndRow& row : rows)
    if (row.kind != EndRow::Kind::moment) kept.push_back(row);
  return kept;
}

}  // namespace

ComposedProgram::ComposedProgram(const System& system, const Maneuver& maneuver, Scheme scheme,
                                 const ShapeCoordinates& coordinates, const std::vector<EndRow>& end_rows)
    : system_(system),
      maneuver_(maneuver),
      end_rows_(without_moments(end_rows)),
      shape_basis_(coordinates.shape),
      pose_basis_(coordinates.pose),
      end_curvature_(system, end_rows_, shape_basis_, pose_basis_),
      steps_(maneuver.steps),
      stages_(integrator::composition(scheme).stages()),
      shape_(static_cast<int>(shape_basis_.cols())),
      pose_(static_cast<int>(pose_basis_.cols())),
      controls_(system.control_count()),
      rest_rows_(maneuver.rest ? shape_ : 0),
      h_(maneuver.time_step()),
      layout_(layout_of(maneuver, scheme, coordinates, controls_)),
      fraction_(stage_fractions(scheme)),
      effort_(maneuver.effort * h_),
      kernel_(system, integrator::lagrangian_of(scheme), shape_basis_),
      moments_(system, shape_basis_, maneuver.start.rotation),
      work_(shape_size(system), moments_.size()),
      condensed_(at(steps_), CondensedStep(layout_)),
      multiplier_(at(steps_ * stages_ + 1), VectorXd::Zero(shape_)),
      end_multiplier_(VectorXd::Zero(static_cast<Eigen::Index>(end_rows_.size()) + rest_rows_)),
      buffer_(system.body_count()),
      hessian_(2 * shape_ + 3, 2 * shape_ + 3) {
  for (double fraction : fraction_) value_.push_back(legendre(fraction, layout_.terms));
  const MatrixXd inertia = mechanics::generalized_inertia(system, maneuver.start.rotation);
  const int size = shape_size(system);
  inertia_ = (shape_basis_.transpose() * inertia.block(3, 3, size, size) * shape_basis_).diagonal();
  const std::size_t nodes = at(steps_ * stages_ + 1);
  for (Motion* motion : {&now_, &trial_}) {
    motion->shape.assign(nodes, Rotations(at(system.body_count()), Matrix3d::Identity()));
    motion->rotation = motion->shape;
    motion->position.assign(nodes, Vector3d::Zero());
    motion->stage.assign(nodes - 1, ShapeStep(system));
    motion->polynomial.assign(at(steps_), VectorXd::Zero(layout_.inputs()));
    motion->impulse.assign(nodes, MatrixXd(shape_, moments_.size()));
    motion->missing.assign(nodes - 1, VectorXd::Zero(shape_));
    motion->end_rows = VectorXd::Zero(end_multiplier_.size());
  }
}

optimizer::StageSizes ComposedProgram::sizes() const {
  return {steps_, layout_.states(), layout_.inputs(), static_cast<int>(end_multiplier_.size())};
}

bool ComposedProgram::go_to(const NodePath& path) {
  for (std::size_t n = 0; n < now_.shape.size(); ++n) {
    const Rotations& R = path.rotation[n];
    for (std::size_t i = 0; i < R.size(); ++i) now_.shape[n][i] = R[0].transpose() * R[i];
    if (n + 1 == now_.shape.size()) break;
    ShapeStep& stage = now_.stage[n];
    stage.root_turn = R[0].transpose() * path.rotation[n + 1][0];
    stage.root_shift = R[0].transpose() * (path.position[n + 1] - path.position[n]);
  }
  now_.polynomial = path.polynomial;
  end_multiplier_.setZero();
  multipliers_known_ = false;
  return roll_out(now_);
}

NodePath ComposedProgram::path() const {
  NodePath path;
  path.rotation = now_.rotation;
  path.position = now_.position;
  path.polynomial = now_.polynomial;
  for (const ShapeStep& stage : now_.stage) path.cayley.push_back(stage.interval.cayley);
  for (int n = 0; n <= steps_ * stages_; ++n) {
    const int k = std::min(n / stages_, steps_ - 1);
    VectorXd control = moments(now_, k, n - k * stages_);
    if (n % stages_ == 0 && k > 0 && n < steps_ * stages_) control = 0.5 * (control + moments(now_, k - 1, stages_));
    path.control.push_back(control);
  }
  return path;
}

VectorXd ComposedProgram::moments(const Motion& motion, int step, int node) const {
  return motion.polynomial[at(step)].reshaped(controls_, layout_.terms) * value_[at(node)];
}

// Shapes become a motion from node to node.
bool ComposedProgram::roll_out(Motion& motion) {
  motion.rotation.front() = maneuver_.start.rotation;
  motion.position.front() = maneuver_.start.position;
  for (int n = 0; n < steps_ * stages_; ++n) {
    ShapeStep& stage = motion.stage[at(n)];
    if (!kernel_.solve(stage_time(n), motion.rotation[at(n)], motion.shape[at(n + 1)], stage)) return false;
    motion.rotation[at(n + 1)] = stage.interval.next_rotation;
    for (Matrix3d& R : motion.rotation[at(n + 1)]) R = lie::renormalized(R);
    motion.position[at(n + 1)] = motion.position[at(n)] + stage.interval.displacement;
  }
  measure(motion);
  return std::isfinite(motion.merit.cost) && std::isfinite(motion.merit.violation);
}

// What the polynomials cost, and what they leave missing.
void ComposedProgram::measure(Motion& motion) {
  Merit& merit = motion.merit;
  merit = Merit();
  merit.cost = maneuver_.time_weight * maneuver_.duration;
  double largest = 0.0, missing = 0.0;
  VectorXd arrived = shape_basis_.transpose() * maneuver_.start.momentum.segment(3, shape_basis_.rows());
  for (int n = 0; n <= steps_ * stages_; ++n) {
    moments_.virtual_work(motion.rotation[at(n)], work_);
    motion.impulse[at(n)].noalias() = shape_basis_.transpose() * work_;
    const auto by_controls = motion.impulse[at(n)].leftCols(controls_);
    const int k = n / stages_, s = n % stages_;
    if (n > 0) {
      arrived = motion.stage[at(n - 1)].plus;
      arrived += half_time_before(n) * by_controls * (s == 0 ? moments(motion, k - 1, stages_) : moments(motion, k, s));
    }
    if (n == steps_ * stages_) break;
    if (s == 0) merit.cost += 0.5 * effort_ * motion.polynomial[at(k)].squaredNorm();
    const VectorXd here = moments(motion, k, s);
    VectorXd& gap = motion.missing[at(n)];
    gap = motion.stage[at(n)].minus - arrived - half_time_after(n) * by_controls * here;
    missing += gap.lpNorm<1>();
    largest = std::max(largest, here.lpNorm<Eigen::Infinity>());
  }
  motion.end_momentum = arrived;
  const auto stated = static_cast<Eigen::Index>(end_rows_.size());
  Eigen::RowVectorXd unused(shape_size(system_) + 6);
  for (Eigen::Index r = 0; r < stated; ++r)
    motion.end_rows[r] = end_row(system_, maneuver_, end_rows_[static_cast<std::size_t>(r)], motion.rotation.back(),
                                 motion.position.back(), unused);
  if (rest_rows_ > 0) motion.end_rows.tail(rest_rows_) = maneuver_.duration * arrived.cwiseQuotient(inertia_);
  merit.violation = motion.end_rows.lpNorm<1>() + missing / std::max(maneuver_.duration * largest, 1e-300);
}

// Those of a maneuver whose moments are free at every instant: G'λ = effort · u (equation 9.6).
void ComposedProgram::guess_multipliers() {
  VectorXd all = VectorXd::Zero(moments_.size());
  for (int n = 0; n <= steps_ * stages_; ++n) {
    const int k = std::min(n / stages_, steps_ - 1);
    all.head(controls_) = maneuver_.effort * moments(now_, k, n - k * stages_);
    multiplier_[at(n)] = now_.impulse[at(n)].transpose().partialPivLu().solve(all);
  }
  multipliers_known_ = true;
}

// −λ·U is bilinear in the moments and the joints' attitude: its second derivative, [m][f].
MatrixXd ComposedProgram::control_by_shape(int node) {
  const Rotations& R = now_.rotation[at(node)];
  const std::size_t bodies = at(system_.body_count());
  Freedoms along(bodies, Vector3d::Zero());
  mechanics::Vectors turns(bodies);
  write_shape(system_, -(shape_basis_ * multiplier_[at(node)]), along);
  mechanics::body_turns(system_, R, along, turns);
  MatrixXd by_shape(controls_, shape_size(system_));
  moments_.virtual_work_by_shape(R, {along, turns}, by_shape);
  return by_shape * shape_basis_;
}

void ComposedProgram::model_step(int k, const Vector3d& turn, const Vector3d& shift, Stage& stage) {
  CondensedStep& step = condensed_[at(k)];
  const int first = k * stages_;
  const auto all = [&](int node) {
    VectorXd moment = VectorXd::Zero(moments_.size());
    moment.head(controls_) = moments(now_, k, node);
    Moments by_joint(at(system_.joint_count()));
    moments_.controls(moment, by_joint);
    return by_joint;
  };
  Moments control = all(0), next_control;
  for (int s = 0; s <= stages_; ++s) {
    const int n = first + s;
    StageForce& force = step.force[at(s)];
    force.impulse = now_.impulse[at(n)].leftCols(controls_);
    force.control_by_shape =
        s == 0 && k > 0 ? condensed_[at(k - 1)].force.back().control_by_shape : control_by_shape(n);
    force.value = value_[at(s)];
    if (s == stages_) break;
    next_control = all(s + 1);
    const Vector3d lever = now_.position.back() - now_.position[at(n + 1)];
    StageLink& link = step.link[at(s)];
    kernel_.tangent(stage_time(n), control, next_control, now_.stage[at(n)], tangent_);
    kernel_.curvature(stage_time(n), control, next_control, now_.stage[at(n)],
                      {multiplier_[at(n)], multiplier_[at(n + 1)], turn + lever.cross(shift), shift}, hessian_);
    link.minus = tangent_.minus;
    link.plus = tangent_.plus;
    link.pose = tangent_.pose;
    link.hessian = hessian_;
    link.displacement = now_.stage[at(n)].interval.displacement;
    link.missing = now_.missing[at(n)];
    std::swap(control, next_control);
  }
  step.condense(stage);
  const VectorXd gradient = effort_ * now_.polynomial[at(k)];
  stage.weight = effort_;
  stage.gradient = gradient.lpNorm<Eigen::Infinity>();
  stage.R.diagonal().array() += effort_;
  stage.r += gradient;
}

void ComposedProgram::model_goal(StageModel& model) const {
  model.C.setZero();
  model.c = now_.end_rows;
  const Eigen::Index all = shape_basis_.rows();
  Eigen::RowVectorXd derivative(all + 6);
  const auto stated = static_cast<Eigen::Index>(end_rows_.size());
  for (Eigen::Index r = 0; r < stated; ++r) {
    end_row(system_, maneuver_, end_rows_[static_cast<std::size_t>(r)], now_.rotation.back(), now_.position.back(),
            derivative);
    model.C.row(r).head(shape_).noalias() = derivative.head(all) * shape_basis_;
    model.C.row(r).tail(pose_).noalias() = derivative.tail<6>() * pose_basis_;
  }
  for (int r = 0; r < rest_rows_; ++r) model.C(stated + r, shape_ + r) = maneuver_.duration / inertia_[r];
}

// Rates of the shape, weighed by inertia and by what moments are like (equation 9.10).
void ComposedProgram::add_metrics(StageModel& model) const {
  double square = 0.0;
  for (const VectorXd& polynomial : now_.polynomial) square += polynomial.squaredNorm() / steps_;
  for (int k = 0; k < steps_; ++k) condensed_[at(k)].measure_rates(std::sqrt(square), model.stage[at(k)]);
}

void ComposedProgram::linearize(StageModel& model) {
  if (!multipliers_known_) guess_multipliers();
  model_goal(model);
  // multipliers of the root's pose at the end: its position's stays, its turn's takes up the lever on the way back
  const VectorXd pose = pose_basis_ * (model.C.rightCols(pose_).transpose() * end_multiplier_);
  const Vector3d turn = pose.head<3>(), shift = pose.tail<3>();
  for (int k = 0; k < steps_; ++k) model_step(k, turn, shift, model.stage[at(k)]);
  model.Q_end.setZero();
  model.q_end.setZero();
  end_curvature_.add(end_rows_, now_.rotation.back(), end_multiplier_, 0, 2 * shape_, model.Q_end);
  add_metrics(model);
}

const Merit* ComposedProgram::try_step(const StageStep& along, double length) {
  trial_.shape.front() = now_.shape.front();
  for (int k = 0; k < steps_; ++k) {
    const CondensedStep& step = condensed_[at(k)];
    const VectorXd& state = along.state[at(k)];
    const VectorXd& input = along.input[at(k)];
    trial_.polynomial[at(k)] = now_.polynomial[at(k)] + length * input;
    VectorXd ends(2 * shape_);
    ends.tail(shape_) = state.head(shape_);
    for (int s = 0; s < stages_; ++s) {
      const int n = k * stages_ + s;
      ends.head(shape_) = ends.tail(shape_).eval();
      ends.tail(shape_) = s + 1 < stages_ ? step.shape_along(s + 1, state, input) : along.state[at(k + 1)].head(shape_);
      move_shape(system_, now_.shape[at(n + 1)], length * (shape_basis_ * ends.tail(shape_)), buffer_,
                 trial_.shape[at(n + 1)]);
      // the root's motion to first order
      const Vector6d change = step.link[at(s)].pose * ends;
      const ShapeStep& from = now_.stage[at(n)];
      ShapeStep& to = trial_.stage[at(n)];
      to.root_turn =
          from.root_turn * lie::cayley(0.5 * length * (from.interval.next_rotation[0].transpose() * change.head<3>()));
      to.root_shift = from.root_shift + length * (from.interval.rotation[0].transpose() * change.tail<3>());
      to.momentum_inverse = from.momentum_inverse;
    }
  }
  return roll_out(trial_) ? &trial_.merit : nullptr;
}

void ComposedProgram::take_multipliers(const StageStep& step, double length) {
  end_multiplier_ += length * (step.end_multiplier - end_multiplier_);
  if (step.shifted) return guess_multipliers();
  const auto take = [&](int node, const VectorXd& momentum_costate) {
    multiplier_[at(node)] -= length * (momentum_costate + multiplier_[at(node)]);
  };
  std::vector<StepCostate> costate(at(stages_), {VectorXd(shape_), VectorXd(shape_), Vector6d()});
  for (int k = 0; k < steps_; ++k) {
    const VectorXd& next = step.costate[at(k + 1)];
    const StepCostate end{next.head(shape_), next.segment(shape_, shape_), pose_basis_ * next.tail(pose_)};
    condensed_[at(k)].carry_back(step.state[at(k)], step.input[at(k)], end, costate);
    take(k * stages_, step.costate[at(k)].segment(shape_, shape_));
    for (int s = 1; s < stages_; ++s) take(k * stages_ + s, costate[at(s)].momentum);
  }
  take(steps_ * stages_, step.costate.back().segment(shape_, shape_));
}

double ComposedProgram::longest(const StageStep& step) {
  double turn = 0.0;
  for (std::size_t k = 1; k < step.state.size(); ++k)
    turn = std::max(turn, step.state[k].head(shape_).lpNorm<Eigen::Infinity>());
  return turn > longest_shape_turn ? longest_shape_turn / turn : 1.0;
}

double ComposedProgram::goal_error() const {
  double error = 0.0;
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    error = std::max(error, end_rows_[r].unit * std::abs(now_.end_rows[static_cast<Eigen::Index>(r)]));
  return error;
}

double ComposedProgram::gap() const {
  double largest = 0.0, gap = 0.0;
  for (std::size_t n = 0; n < now_.missing.size(); ++n) {
    largest = std::max(largest, now_.stage[n].minus.lpNorm<Eigen::Infinity>());
    gap = std::max(gap, now_.missing[n].lpNorm<Eigen::Infinity>());
  }
  return largest > 0.0 ? gap / largest : 0.0;
}

}  // namespace lamprey::maneuver
