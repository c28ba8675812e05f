#include "shape/composed_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

namespace {

using maneuver::cayley_between;
using maneuver::end_row;
using maneuver::legendre;
using maneuver::move_shape;
using maneuver::polynomial_terms;
using maneuver::shape_size;
using maneuver::stage_fractions;
using maneuver::write_shape;
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
      given_rows_(end_rows),
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
      space_(layout_),
      condensed_(at(steps_), CondensedStep(layout_)),
      multiplier_(at(steps_ * stages_ + 1), VectorXd::Zero(shape_)),
      end_multiplier_(VectorXd::Zero(static_cast<Eigen::Index>(end_rows_.size()) + rest_rows_)),
      control_(at(steps_), std::vector<Moments>(at(stages_ + 1), Moments(at(system.joint_count()), Vector3d::Zero()))),
      costate_(at(stages_), {VectorXd(shape_), VectorXd(shape_), Vector6d::Zero()}),
      moment_(controls_),
      all_moments_(VectorXd::Zero(moments_.size())),
      work_(shape_size(system), moments_.size()),
      by_shape_(controls_, shape_size(system)),
      along_(shape_size(system)),
      ends_(2 * shape_),
      spread_(at(system.body_count()), Vector3d::Zero()),
      spread_turn_(spread_),
      buffer_(system.body_count()),
      end_derivative_(shape_size(system) + 6) {
  if (const auto lagrangian = integrator::lagrangian_of(scheme); FourSteps::serves(system, lagrangian))
    four_steps_.emplace(system, lagrangian, shape_basis_);
  for (double fraction : fraction_) value_.push_back(legendre(fraction, layout_.terms));
  const MatrixXd inertia = mechanics::generalized_inertia(system, maneuver.start.rotation);
  const int size = shape_size(system);
  inertia_ = (shape_basis_.transpose() * inertia.block(3, 3, size, size) * shape_basis_).diagonal();
  const std::size_t nodes = at(steps_ * stages_ + 1);
  for (CondensedStep& step : condensed_) {
    for (StageLink& link : step.link) link.hessian.resize(2 * shape_ + 3, 2 * shape_ + 3);
    for (std::size_t node = 0; node < value_.size(); ++node) {
      step.force[node].control_by_shape.resize(controls_, shape_);
      step.force[node].value = value_[node];
    }
  }
  for (Motion* motion : {&now_, &trial_}) {
    motion->shape.assign(nodes, Rotations(at(system.body_count()), Matrix3d::Identity()));
    motion->rotation = motion->shape;
    motion->position.assign(nodes, Vector3d::Zero());
    motion->stage.assign(nodes - 1, four_steps_ ? ShapeStep::of_root() : ShapeStep(system));
    motion->polynomial.assign(at(steps_), VectorXd::Zero(layout_.inputs()));
    motion->impulse.assign(nodes, MatrixXd(shape_, moments_.size()));
    motion->missing.assign(nodes - 1, VectorXd::Zero(shape_));
    motion->end_rows = VectorXd::Zero(end_multiplier_.size());
  }
}

optimizer::StageSizes ComposedProgram::sizes() const {
  return {steps_, layout_.states(), layout_.inputs(), static_cast<int>(end_multiplier_.size())};
}

void ComposedProgram::take_end_multipliers(const VectorXd& multipliers) {
  end_start_.resize(0);
  if (multipliers.size() != static_cast<Eigen::Index>(given_rows_.size())) return;
  end_start_.setZero(end_multiplier_.size());
  Eigen::Index place = 0;
  for (std::size_t r = 0; r < given_rows_.size(); ++r)
    if (given_rows_[r].kind != EndRow::Kind::moment) end_start_[place++] = multipliers[static_cast<Eigen::Index>(r)];
}

VectorXd ComposedProgram::end_multipliers() const {
  VectorXd multipliers = VectorXd::Zero(static_cast<Eigen::Index>(given_rows_.size()));
  Eigen::Index place = 0;
  for (std::size_t r = 0; r < given_rows_.size(); ++r)
    if (given_rows_[r].kind != EndRow::Kind::moment)
      multipliers[static_cast<Eigen::Index>(r)] = end_multiplier_[place++];
  return multipliers;
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
  if (has_multipliers()) end_multiplier_ = end_start_;
  multipliers_known_ = false;
  return roll_out(now_);
}

NodePath ComposedProgram::path() const {
  NodePath path;
  path.rotation = now_.rotation;
  path.position = now_.position;
  path.polynomial = now_.polynomial;
  for (std::size_t n = 0; n < now_.stage.size(); ++n)
    if (four_steps_)
      cayley_between(now_.rotation[n], now_.rotation[n + 1], path.cayley.emplace_back());
    else
      path.cayley.push_back(now_.stage[n].interval.cayley);
  VectorXd control(controls_), control_before(controls_);
  for (int n = 0; n <= steps_ * stages_; ++n) {
    const int k = std::min(n / stages_, steps_ - 1);
    read_moments(now_, k, n - k * stages_, control);
    if (n % stages_ == 0 && k > 0 && n < steps_ * stages_) {
      read_moments(now_, k - 1, stages_, control_before);
      control = 0.5 * (control + control_before);
    }
    path.control.push_back(control);
  }
  return path;
}

void ComposedProgram::read_moments(const Motion& motion, int step, int node, VectorXd& moment) const {
  moment.setZero();
  for (int term = 0; term < layout_.terms; ++term)
    algebra::add_multiple(value_[at(node)][term], motion.polynomial[at(step)].segment(term * controls_, controls_),
                          moment);
}

// One for each of four steps; beyond the last it is repeated.
template <typename Of>
auto ComposedProgram::of_four(int first, const Of& of) const {
  const auto lane = [&](int l) { return of(std::min(first + l, steps_ - 1)); };
  return ForFour<decltype(lane(0))>{lane(0), lane(1), lane(2), lane(3)};
}

// Shapes become a motion from node to node.
bool ComposedProgram::roll_out(Motion& motion) {
  motion.rotation.front() = maneuver_.start.rotation;
  motion.position.front() = maneuver_.start.position;
  if (four_steps_)
    for (int s = 0; s < stages_; ++s)
      for (int first = 0; first < steps_; first += 4)
        if (!solve_four(first, s, motion)) return false;
  for (int n = 0; n < steps_ * stages_; ++n) {
    ShapeStep& stage = motion.stage[at(n)];
    if (four_steps_)
      follow_root(motion.rotation[at(n)], motion.shape[at(n + 1)], stage, motion.rotation[at(n + 1)]);
    else if (!solve_stage(n, motion))
      return false;
    motion.position[at(n + 1)] = motion.position[at(n)] + stage.interval.displacement;
  }
  measure(motion);
  return std::isfinite(motion.merit.cost) && std::isfinite(motion.merit.violation);
}

bool ComposedProgram::solve_stage(int n, Motion& motion) {
  ShapeStep& stage = motion.stage[at(n)];
  if (!kernel_.solve(stage_time(n), motion.rotation[at(n)], motion.shape[at(n + 1)], stage)) return false;
  motion.rotation[at(n + 1)] = stage.interval.next_rotation;
  for (Matrix3d& R : motion.rotation[at(n + 1)]) R = lie::renormalized(R);
  return true;
}

// The same stage of four steps: its length is theirs.
bool ComposedProgram::solve_four(int first, int s, Motion& motion) {
  const auto shape = [&](int node) {
    return of_four(first, [&](int k) -> const Rotations* { return &motion.shape[at(k * stages_ + node)]; });
  };
  four_steps_->take_shapes(stage_time(s), shape(s), shape(s + 1));
  if (four_steps_->solve(of_four(first, [&](int k) { return &motion.stage[at(k * stages_ + s)]; }))) return true;
  // where bodies turn far, ShapeKernel may find motions that are not found in fours
  for (int n = first * stages_ + s; n < std::min(first + 4, steps_) * stages_; n += stages_) {
    ShapeStep& stage = motion.stage[at(n)];
    ShapeStep alone(system_);
    alone.root_turn = stage.root_turn;
    alone.root_shift = stage.root_shift;
    if (!kernel_.solve(stage_time(s), motion.shape[at(n)], motion.shape[at(n + 1)], alone)) return false;
    alone.interval = std::move(stage.interval);
    stage = std::move(alone);
  }
  return true;
}

// What the polynomials cost, and what they leave missing.
void ComposedProgram::measure(Motion& motion) {
  Merit& merit = motion.merit;
  merit = Merit();
  double cost = 0.0;
  double largest = 0.0, missing = 0.0;
  VectorXd& arrived = motion.end_momentum;
  arrived = shape_basis_.transpose() * maneuver_.start.momentum.segment(3, shape_basis_.rows());
  for (int n = 0; n <= steps_ * stages_; ++n) {
    MatrixXd& impulse = motion.impulse[at(n)];
    moments_.virtual_work(motion.rotation[at(n)], work_);
    algebra::set_product(shape_basis_.transpose(), work_, impulse);
    const int k = n / stages_, s = n % stages_;
    if (n > 0) {
      arrived = motion.stage[at(n - 1)].plus;
      read_moments(motion, s == 0 ? k - 1 : k, s == 0 ? stages_ : s, moment_);
      optimizer::add_image(half_time_before(n), impulse.leftCols(controls_), moment_, arrived);
    }
    if (n == steps_ * stages_) break;
    if (s == 0) cost += 0.5 * effort_ * motion.polynomial[at(k)].squaredNorm();
    read_moments(motion, k, s, moment_);
    VectorXd& gap = motion.missing[at(n)];
    gap = motion.stage[at(n)].minus - arrived;
    optimizer::add_image(-half_time_after(n), impulse.leftCols(controls_), moment_, gap);
    missing += gap.lpNorm<1>();
    largest = std::max(largest, moment_.lpNorm<Eigen::Infinity>());
  }
  const auto stated = static_cast<Eigen::Index>(end_rows_.size());
  for (Eigen::Index r = 0; r < stated; ++r)
    motion.end_rows[r] = end_row(system_, maneuver_, end_rows_[static_cast<std::size_t>(r)], motion.rotation.back(),
                                 motion.position.back(), end_derivative_);
  if (rest_rows_ > 0) motion.end_rows.tail(rest_rows_) = maneuver_.duration * arrived.cwiseQuotient(inertia_);
  merit.violation = motion.end_rows.lpNorm<1>() + missing / std::max(maneuver_.duration * largest, 1e-300);
  motion.cost = cost + maneuver_.time_weight * maneuver_.duration;
  weigh_gaps(motion);
}

// With it the cost changes along a step as the Lagrangian does, whose second derivatives are the model's.
void ComposedProgram::weigh_gaps(Motion& motion) const {
  double worth = 0.0;
  for (std::size_t n = 0; n < motion.missing.size() && multipliers_known_; ++n)
    worth += multiplier_[n].dot(motion.missing[n]);
  motion.merit.gaps = worth;
  motion.merit.cost = motion.cost - maneuver_.time_weight * maneuver_.duration + worth;  // time's share is given
}

// Those of a maneuver whose moments are free at every instant: G'λ = effort · u (equation 9.6).
void ComposedProgram::guess_multipliers() {
  for (int n = 0; n <= steps_ * stages_; ++n) {
    const int k = std::min(n / stages_, steps_ - 1);
    read_moments(now_, k, n - k * stages_, moment_);
    all_moments_.head(controls_) = maneuver_.effort * moment_;
    multiplier_[at(n)] = now_.impulse[at(n)].transpose().partialPivLu().solve(all_moments_);
  }
  all_moments_.setZero();
  multipliers_known_ = true;
}

// −λ·U is bilinear in the moments and the joints' attitude: its second derivative, [m][f].
void ComposedProgram::find_control_by_shape(int node, MatrixXd& by_shape) {
  const Rotations& R = now_.rotation[at(node)];
  along_.setZero();
  optimizer::add_image(-1.0, shape_basis_, multiplier_[at(node)], along_);
  write_shape(system_, along_, spread_);
  mechanics::body_turns(system_, R, spread_, spread_turn_);
  moments_.virtual_work_by_shape(R, {spread_, spread_turn_}, by_shape_);
  algebra::set_product(by_shape_, shape_basis_, by_shape);
}

// Moments at the nodes of a step and what they do there.
void ComposedProgram::lay_forces(int k) {
  CondensedStep& step = condensed_[at(k)];
  for (int s = 0; s <= stages_; ++s) {
    StageForce& force = step.force[at(s)];
    force.impulse = now_.impulse[at(k * stages_ + s)].leftCols(controls_);
    if (s == 0 && k > 0)
      force.control_by_shape = condensed_[at(k - 1)].force.back().control_by_shape;
    else
      find_control_by_shape(k * stages_ + s, force.control_by_shape);
    read_moments(now_, k, s, moment_);
    all_moments_.head(controls_) = moment_;
    moments_.controls(all_moments_, control_[at(k)][at(s)]);
  }
}

// Tangents and curvature of the same stage of up to four steps. Multipliers of the root's pose at the end: its position's
// stays, its turn's takes up the lever on the way back.
void ComposedProgram::differentiate_four(int first, int s, const Vector6d& pose_multiplier) {
  const Vector3d turn = pose_multiplier.head<3>(), shift = pose_multiplier.tail<3>();
  const auto multipliers = [&](int k) {
    const int n = k * stages_ + s;
    const Vector3d lever = now_.position.back() - now_.position[at(n + 1)];
    return ShapeMultipliers{multiplier_[at(n)], multiplier_[at(n + 1)], turn + lever.cross(shift), shift};
  };
  const auto link = [&](int k) { return &condensed_[at(k)].link[at(s)]; };
  if (!four_steps_) {
    for (int k = first; k < std::min(first + 4, steps_); ++k) {
      ShapeStep& stage = now_.stage[at(k * stages_ + s)];
      const Moments &control = control_[at(k)][at(s)], &next_control = control_[at(k)][at(s + 1)];
      kernel_.tangent(stage_time(s), control, next_control, stage, link(k)->tangent);
      kernel_.curvature(stage_time(s), control, next_control, stage, multipliers(k), link(k)->hessian);
      turn_at_end(link(k)->tangent, link(k)->hessian);
    }
    return;
  }
  const auto shape = [&](int node) {
    return of_four(first, [&](int k) -> const Rotations* { return &now_.shape[at(k * stages_ + node)]; });
  };
  const auto control = [&](int node) {
    return of_four(first, [&](int k) -> const Moments* { return &control_[at(k)][at(node)]; });
  };
  const auto stage = of_four(first, [&](int k) -> const ShapeStep* { return &now_.stage[at(k * stages_ + s)]; });
  const auto of_lanes = of_four(first, multipliers);
  four_steps_->take_shapes(stage_time(s), shape(s), shape(s + 1));
  four_steps_->tangent(stage, control(s), control(s + 1), of_four(first, [&](int k) { return &link(k)->tangent; }));
  four_steps_->curvature(stage, control(s), control(s + 1), {&of_lanes[0], &of_lanes[1], &of_lanes[2], &of_lanes[3]},
                         of_four(first, [&](int k) { return &link(k)->hessian; }));
}

void ComposedProgram::model_step(int k, Stage& stage) {
  CondensedStep& step = condensed_[at(k)];
  for (int s = 0; s < stages_; ++s) {
    const std::size_t n = at(k * stages_ + s);
    step.link[at(s)].displacement = now_.stage[n].interval.displacement;
    step.link[at(s)].missing = now_.missing[n];
  }
  if (!step.condense(space_, stage))  // no factorisation takes it, and the search ends here
    stage.R.setConstant(std::numeric_limits<double>::quiet_NaN());
  const VectorXd& polynomial = now_.polynomial[at(k)];
  stage.weight = effort_;
  stage.gradient = effort_ * polynomial.lpNorm<Eigen::Infinity>();
  stage.R.diagonal().array() += effort_;
  algebra::add_multiple(effort_, polynomial, stage.r);
}

void ComposedProgram::model_goal(StageModel& model) {
  model.C.setZero();
  model.c = now_.end_rows;
  const Eigen::Index all = shape_basis_.rows();
  const auto stated = static_cast<Eigen::Index>(end_rows_.size());
  for (Eigen::Index r = 0; r < stated; ++r) {
    end_row(system_, maneuver_, end_rows_[static_cast<std::size_t>(r)], now_.rotation.back(), now_.position.back(),
            end_derivative_);
    model.C.row(r).head(shape_).noalias() = end_derivative_.head(all) * shape_basis_;
    model.C.row(r).tail(pose_).noalias() = end_derivative_.tail<6>() * pose_basis_;
  }
  for (int r = 0; r < rest_rows_; ++r) model.C(stated + r, shape_ + r) = maneuver_.duration / inertia_[r];
}

// Rates of the shape, weighed by inertia and by what moments are like (equation 9.10).
void ComposedProgram::add_metrics(StageModel& model) {
  double square = 0.0;
  for (const VectorXd& polynomial : now_.polynomial) square += polynomial.squaredNorm() / steps_;
  const double scale = maneuver_.effort * std::sqrt(square);
  for (int k = 0; k < steps_; ++k) condensed_[at(k)].measure_rates(scale, space_, model.stage[at(k)]);
}

void ComposedProgram::linearize(StageModel& model) {
  if (!multipliers_known_) guess_multipliers();
  weigh_gaps(now_);
  model_goal(model);
  const Vector6d pose = pose_basis_ * (model.C.rightCols(pose_).transpose() * end_multiplier_);
  for (int k = 0; k < steps_; ++k) lay_forces(k);
  for (int s = 0; s < stages_; ++s)
    for (int first = 0; first < steps_; first += 4) differentiate_four(first, s, pose);
  for (int k = 0; k < steps_; ++k) model_step(k, model.stage[at(k)]);
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
    trial_.polynomial[at(k)] = now_.polynomial[at(k)] + length * along.input[at(k)];
    step.pack(state, along.input[at(k)], packed_);
    ends_.tail(shape_) = state.head(shape_);
    for (int s = 0; s < stages_; ++s) {
      const int n = k * stages_ + s;
      ends_.head(shape_) = ends_.tail(shape_);
      if (s + 1 < stages_)
        step.shape_along(s + 1, packed_, ends_.tail(shape_));
      else
        ends_.tail(shape_) = along.state[at(k + 1)].head(shape_);
      along_.setZero();
      optimizer::add_image(length, shape_basis_, ends_.tail(shape_), along_);
      move_shape(system_, now_.shape[at(n + 1)], along_, buffer_, trial_.shape[at(n + 1)]);
      // the root's motion to first order
      Vector6d change = Vector6d::Zero();
      optimizer::add_image(length, step.link[at(s)].tangent.pose, ends_, change);
      const ShapeStep& from = now_.stage[at(n)];
      ShapeStep& to = trial_.stage[at(n)];
      to.root_turn =
          from.root_turn * lie::cayley(0.5 * (from.interval.next_rotation[0].transpose() * change.head<3>()));
      to.root_shift = from.root_shift + from.interval.rotation[0].transpose() * change.tail<3>();
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
  for (int k = 0; k < steps_; ++k) {
    const VectorXd& next = step.costate[at(k + 1)];
    const StepCostate end{next.head(shape_), next.segment(shape_, shape_), pose_basis_ * next.tail(pose_)};
    condensed_[at(k)].carry_back(step.state[at(k)], step.input[at(k)], end, costate_);
    take(k * stages_, step.costate[at(k)].segment(shape_, shape_));
    for (int s = 1; s < stages_; ++s) take(k * stages_ + s, costate_[at(s)].momentum);
  }
  take(steps_ * stages_, step.costate.back().segment(shape_, shape_));
}

double ComposedProgram::longest(const StageStep& step, const optimizer::Promise& /*promise*/) {
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

}  // namespace lamprey::shape
