// Costs beside effort and time in the transcription (chapter 13, equation 13.17). Turns of the joints over the steps, powers of
// the joints at the nodes and their changes and, for work, its two slopes' bounds are variables; for work per distance also the
// whole work and the distance. All are as a motion of the first guess's duration would have them.
#include <cmath>

#include "maneuver/motion.hpp"
#include "maneuver/step_chart.hpp"
#include "shape/joint_turns.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

namespace {

using maneuver::CostWeights;
using model::at;
using model::Joint;
using shape::JointTurns;
using shape::mean_work;
using shape::work_term;
using shape::WorkSlopes;

Eigen::Matrix<double, 1, 1> scalar(double value) { return Eigen::Matrix<double, 1, 1>::Constant(value); }

// Along which a turn in the parent's frame is counted for a moment: against it, as moments act on the parent.
Vector3d counted_along(const Joint& joint, Eigen::Index moment) {
  if (joint.free()) return -joint.actuation.col(moment);
  return -joint.actuation(0, moment) * (joint.reference_rotation * joint.child_axis);
}

constexpr int settlings = 10;  // of slopes of the work by powers, each of which takes off up to a half of their error
constexpr double work_slows = 2.0;   // powers of the stretch that costs fall with
constexpr double other_slows = 5.0;  // squared power and smoothness
constexpr double rate_slows = 1.0;   // squared angular velocity

}  // namespace

void Transcription::lay_costs() {
  const CostWeights& weights = maneuver_.cost_weights;
  if (!weights.any()) return;
  for (int j = 0; j < system_.joint_count(); ++j)
    if (system_.joint(j).actuation.cols() > 0) powered_.push_back(j);
  const auto joints = static_cast<int>(powered_.size());
  worked_ = weights.work > 0.0 || weights.transport > 0.0;
  joint_turn_variable_ = variable_count_;
  power_variable_ = joint_turn_variable_ + steps_ * controls_;
  const int nodes = (steps_ + 1) * joints;
  change_variable_ = power_variable_ + nodes;
  size_variable_ = change_variable_ + nodes;
  sign_variable_ = size_variable_ + nodes;
  variable_count_ = worked_ ? sign_variable_ + nodes : size_variable_;
  if (weights.transport > 0.0) {
    whole_variable_ = variable_count_;
    variable_count_ += 2;
  }
  start_rate_ = VectorXd::Zero(controls_);
  const integrator::State& start = maneuver_.start;
  if (maneuver_.periodic || start.momentum.isZero(0.0)) return;
  start_rate_ = JointTurns(system_, MatrixXd())
                    .rates(start.rotation, mechanics::velocity_of_momentum(system_, start.rotation, start.momentum));
}

int Transcription::cost_row_count() const {
  if (joint_turn_variable_ < 0) return 0;
  const int nodes = (steps_ + 1) * static_cast<int>(powered_.size());
  return steps_ * controls_ + 2 * nodes + (worked_ ? 4 * nodes : 0) + (whole_variable_ < 0 ? 0 : 2);
}

// s, that a node's power counts for; 0 where no moments are.
double Transcription::power_time(int node) const {
  if (maneuver_.periodic) return node > 0 ? h_ : 0.0;
  return node < steps_ || maneuver_.rest ? force_weight(node) : 0.0;
}

// Steps whose turns a node's power sees.
std::vector<Transcription::StepAbout> Transcription::steps_about(int node) const {
  std::vector<StepAbout> steps;
  if (node > 0) steps.push_back({node - 1, -1.0});
  if (node < steps_) steps.push_back({node, 1.0});
  if (maneuver_.periodic && node == steps_) steps.push_back({0, 1.0});
  return steps;
}

// Rate of a moment's joint about a node, rad/s: mean and half of what it changes by.
NodePower Transcription::joint_rate(int node, int moment) const {
  NodePower rate = NodePower::Zero();
  if (node == 0) rate = 0.5 * stretch() * start_rate_[moment] * NodePower(1.0, -1.0);
  for (const auto& [step, side] : steps_about(node))
    rate += 0.5 / h_ * point_[joint_turn_variable(step, moment)] * NodePower(1.0, side);
  return rate;
}

BallTurn Transcription::turn_over(int k, const Joint& joint) const {
  return {child_to_parent(k, joint), child_to_parent(k + 1, joint)};
}

// ---- the cost itself: Σ w_i s^(−r_i) f_i ----

// Of a joint's squared turn over a step, twice.
double Transcription::rate_weight(double stretch) const {
  return maneuver_.cost_weights.angular_velocity / (h_ * cost_unit()) * std::pow(stretch, -rate_slows);
}

Transcription::OtherCosts Transcription::other_costs(const VectorXd& x) const {
  OtherCosts costs;
  if (joint_turn_variable_ < 0) return costs;
  const CostWeights& weights = maneuver_.cost_weights;
  const double s = stretch(x);
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      costs.power +=
          power_time(k) * (std::pow(x[power_variable(k, j)], 2) + std::pow(x[change_variable(k, j)], 2) / 3.0);
      if (worked_) costs.work += power_time(k) * work_at(x, k, j);
    }
  for (int k = 0; k < steps_; ++k)
    costs.smoothness +=
        0.5 / h_ *
        (x.segment(control_variable(k + 1), controls_) - x.segment(control_variable(k), controls_)).squaredNorm();
  costs.angular_velocity = 0.5 * rate_weight(s) * x.segment(joint_turn_variable_, steps_ * controls_).squaredNorm();
  costs.work *= weights.work / scale_ * std::pow(s, -work_slows);
  costs.power *= unit * weights.power * std::pow(s, -other_slows);
  costs.smoothness *= unit * weights.smoothness * std::pow(s, -other_slows);
  if (whole_variable_ >= 0)
    costs.transport =
        weights.transport / scale_ * std::pow(s, -work_slows) * x[whole_variable_] / x[whole_variable_ + 1];
  return costs;
}

void Transcription::add_cost_gradient(const VectorXd& x, VectorXd& g) const {
  if (joint_turn_variable_ < 0) return;
  const CostWeights& weights = maneuver_.cost_weights;
  const OtherCosts costs = other_costs(x);
  const double s = stretch(x), slow = std::pow(s, -work_slows) / scale_, slower = unit * std::pow(s, -other_slows);
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const double squares = 2.0 * slower * weights.power * power_time(k);
      g[power_variable(k, j)] += squares * x[power_variable(k, j)];
      g[change_variable(k, j)] += squares / 3.0 * x[change_variable(k, j)];
      if (!worked_) continue;
      const double rate = slow * weights.work * power_time(k), sign = x[sign_variable(k, j)];
      g[size_variable(k, j)] += 0.5 * rate * (1.0 + sign * sign);
      g[sign_variable(k, j)] += rate * x[size_variable(k, j)] * sign;
    }
  for (int k = 0; k < steps_; ++k) {
    const VectorXd change = slower * weights.smoothness / h_ *
                            (x.segment(control_variable(k + 1), controls_) - x.segment(control_variable(k), controls_));
    g.segment(control_variable(k + 1), controls_) += change;
    g.segment(control_variable(k), controls_) -= change;
  }
  g.segment(joint_turn_variable_, steps_ * controls_) +=
      rate_weight(s) * x.segment(joint_turn_variable_, steps_ * controls_);
  if (whole_variable_ >= 0) {
    g[whole_variable_] += costs.transport / x[whole_variable_];
    g[whole_variable_ + 1] -= costs.transport / x[whole_variable_ + 1];
  }
  if (stretch_variable_ >= 0)
    g[stretch_variable_] -= work_slows * (costs.work + costs.transport) +
                            other_slows * (costs.power + costs.smoothness) + rate_slows * costs.angular_velocity;
}

// Of the work at a node, ½e(1 + S²).
void Transcription::emit_work_hessian(double factor, int node, std::size_t powered, BlockSink& sink) const {
  const int size = size_variable(node, powered), sign = sign_variable(node, powered);
  sink.add(sign, sign, scalar(factor * point_[size]));
  sink.add(sign, size, scalar(factor * point_[sign]));
}

void Transcription::emit_cost_hessian(double factor, BlockSink& sink) const {
  if (joint_turn_variable_ < 0) return;
  const CostWeights& weights = maneuver_.cost_weights;
  const OtherCosts costs = other_costs(point_);
  const double s = stretch(), slow = factor / scale_ * std::pow(s, -work_slows),
               slower = factor * unit * std::pow(s, -other_slows);
  const auto by_stretch = [&](int variable, double value) {
    if (stretch_variable_ >= 0)
      sink.add(std::max(stretch_variable_, variable), std::min(stretch_variable_, variable), scalar(value));
  };
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const double bend = 2.0 * slower * weights.power * power_time(k);
      for (const auto& [power, share] :
           {std::pair(power_variable(k, j), 1.0), std::pair(change_variable(k, j), 1.0 / 3.0)}) {
        sink.add(power, power, scalar(share * bend));
        by_stretch(power, -other_slows * share * bend * point_[power]);
      }
      if (!worked_) continue;
      const double rate = slow * weights.work * power_time(k);
      const int size = size_variable(k, j), sign = sign_variable(k, j);
      emit_work_hessian(rate, k, j, sink);
      by_stretch(size, -0.5 * work_slows * rate * (1.0 + std::pow(point_[sign], 2)));
      by_stretch(sign, -work_slows * rate * point_[size] * point_[sign]);
    }
  const double stiff = slower * weights.smoothness / h_;
  for (int k = 0; k < steps_ && weights.smoothness > 0.0; ++k)
    for (int m = 0; m < controls_; ++m) {
      const int here = control_variable(k) + m, there = control_variable(k + 1) + m;
      const double change = -other_slows * stiff * (point_[there] - point_[here]);
      sink.add(here, here, scalar(stiff));
      sink.add(there, there, scalar(stiff));
      sink.add(there, here, scalar(-stiff));
      by_stretch(there, change);
      by_stretch(here, -change);
    }
  const double by_rate = factor * rate_weight(s);
  for (int turn = joint_turn_variable_; turn < power_variable_ && weights.angular_velocity > 0.0; ++turn) {
    sink.add(turn, turn, scalar(by_rate));
    by_stretch(turn, -rate_slows * by_rate * point_[turn]);
  }
  if (whole_variable_ >= 0) {
    const double work = point_[whole_variable_], distance = point_[whole_variable_ + 1];
    const double value = factor * costs.transport;
    sink.add(whole_variable_ + 1, whole_variable_, scalar(-value / (work * distance)));
    sink.add(whole_variable_ + 1, whole_variable_ + 1, scalar(2.0 * value / (distance * distance)));
    by_stretch(whole_variable_, -work_slows * value / work);
    by_stretch(whole_variable_ + 1, work_slows * value / distance);
  }
  by_stretch(stretch_variable_, factor * (work_slows * work_slows * (costs.work + costs.transport) +
                                          other_slows * other_slows * (costs.power + costs.smoothness) +
                                          rate_slows * rate_slows * costs.angular_velocity));
}

// ---- what the variables are ----

void Transcription::cost_values(VectorXd& c) const {
  if (joint_turn_variable_ < 0) return;
  int row = cost_row_;
  for (int k = 0; k < steps_; ++k)
    for (int j : powered_) {
      const Joint& joint = system_.joint(j);
      const BallTurn turn = turn_over(k, joint);
      for (Eigen::Index m = 0; m < joint.actuation.cols(); ++m)
        c[row++] = counted_along(joint, m).dot(turn.psi()) -
                   point_[joint_turn_variable(k, system_.joint(j).first_control + static_cast<int>(m))];
    }
  double whole = 0.0;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const auto [first, count] = controls_of(powered_[j]);
      const double power = point_[power_variable(k, j)], change = point_[change_variable(k, j)];
      NodePower gap(-power, -change);
      for (int m = first; m < first + count; ++m) gap += point_[control_variable(k) + m] * joint_rate(k, m);
      c.segment<2>(row) = gap;
      row += 2;
      if (!worked_) continue;
      const double size = point_[size_variable(k, j)];
      c[row++] = size * point_[sign_variable(k, j)] - power;
      c[row++] = size - change;
      c[row++] = size + change;
      c[row++] = point_[sign_variable(k, j)];
      whole += power_time(k) * work_at(point_, k, j);
    }
  if (whole_variable_ < 0) return;
  c[row++] = whole - point_[whole_variable_];
  c[row] = 0.5 * (position(steps_) - position(0)).squaredNorm() - 0.5 * std::pow(point_[whole_variable_ + 1], 2);
}

std::vector<Transcription::Charted> Transcription::charted(int k, const Joint& joint) const {
  std::vector<Charted> all = charted_at(k, joint);
  for (Charted& after : charted_at(k + 1, joint)) {
    after.coordinate += 6;
    all.push_back(std::move(after));
  }
  return all;
}

void Transcription::emit_cost_rows_jacobian(BlockSink& sink) const {
  if (joint_turn_variable_ < 0) return;
  int row = cost_row_;
  for (int k = 0; k < steps_; ++k)
    for (int j : powered_) {
      const Joint& joint = system_.joint(j);
      const Eigen::Matrix<double, 3, 12> rate = turn_over(k, joint).derivative();
      const std::vector<Charted> charts = charted(k, joint);
      for (Eigen::Index m = 0; m < joint.actuation.cols(); ++m, ++row) {
        emit_charted(row, rate.transpose() * counted_along(joint, m), charts, sink);
        sink.add(row, joint_turn_variable(k, system_.joint(j).first_control + static_cast<int>(m)), scalar(-1.0));
      }
    }
  std::vector<std::pair<int, double>> whole;  // variables and what the whole work changes by with them
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const auto [first, count] = controls_of(powered_[j]);
      for (int m = first; m < first + count; ++m) {
        const double control = point_[control_variable(k) + m];
        const NodePower rate = joint_rate(k, m);
        for (int kind : {0, 1}) sink.add(row + kind, control_variable(k) + m, scalar(rate[kind]));
        for (const auto& [step, side] : steps_about(k))
          for (int kind : {0, 1})
            sink.add(row + kind, joint_turn_variable(step, m), scalar((kind == 0 ? 0.5 : 0.5 * side) / h_ * control));
        if (k > 0 || stretch_variable_ < 0) continue;
        const double faster = 0.5 * stretch() * start_rate_[m] * control;
        sink.add(row, stretch_variable_, scalar(faster));
        sink.add(row + 1, stretch_variable_, scalar(-faster));
      }
      sink.add(row++, power_variable(k, j), scalar(-1.0));
      sink.add(row++, change_variable(k, j), scalar(-1.0));
      if (!worked_) continue;
      const int size = size_variable(k, j), sign = sign_variable(k, j);
      sink.add(row, size, scalar(point_[sign]));
      sink.add(row, sign, scalar(point_[size]));
      sink.add(row++, power_variable(k, j), scalar(-1.0));
      for (double side : {-1.0, 1.0}) {
        sink.add(row, size, scalar(1.0));
        sink.add(row++, change_variable(k, j), scalar(side));
      }
      sink.add(row++, sign, scalar(1.0));
      whole.emplace_back(size, power_time(k) * 0.5 * (1.0 + std::pow(point_[sign], 2)));
      whole.emplace_back(sign, power_time(k) * point_[size] * point_[sign]);
    }
  if (whole_variable_ < 0) return;
  for (const auto& [variable, time] : whole) sink.add(row, variable, scalar(time));
  sink.add(row++, whole_variable_, scalar(-1.0));
  sink.add(row, position_variable(steps_), (position(steps_) - position(0)).transpose());
  sink.add(row, whole_variable_ + 1, scalar(-point_[whole_variable_ + 1]));
}

void Transcription::emit_cost_rows_hessian(const VectorXd& multiplier, BlockSink& sink) const {
  if (joint_turn_variable_ < 0) return;
  int row = cost_row_;
  for (int k = 0; k < steps_; ++k)
    for (int j : powered_) {
      const Joint& joint = system_.joint(j);
      const BallTurn turn = turn_over(k, joint);
      Vector3d pull = Vector3d::Zero();
      for (Eigen::Index m = 0; m < joint.actuation.cols(); ++m) pull += multiplier[row++] * counted_along(joint, m);
      emit_charted(1.0, turn.derivative().transpose() * pull, turn.curvature(pull), charted(k, joint), sink);
    }
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const auto [first, count] = controls_of(powered_[j]);
      const double lambda[2] = {multiplier[row], multiplier[row + 1]};
      row += 2;
      for (int m = first; m < first + count; ++m) {
        const int control = control_variable(k) + m;
        for (const auto& [step, side] : steps_about(k))
          sink.add(joint_turn_variable(step, m), control, scalar(0.5 / h_ * (lambda[0] + side * lambda[1])));
        if (k > 0 || stretch_variable_ < 0) continue;
        const double faster = 0.5 * stretch() * start_rate_[m] * (lambda[0] - lambda[1]);
        sink.add(stretch_variable_, control, scalar(faster));
        sink.add(stretch_variable_, stretch_variable_, scalar(faster * point_[control]));
      }
      if (!worked_) continue;
      sink.add(sign_variable(k, j), size_variable(k, j), scalar(multiplier[row]));
      row += 4;
    }
  if (whole_variable_ < 0) return;
  const double whole = multiplier[row++], lambda = multiplier[row];
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) emit_work_hessian(whole * power_time(k), k, j, sink);
  sink.add_symmetric(position_variable(steps_), position_variable(steps_), lambda * Matrix3d::Identity());
  sink.add(whole_variable_ + 1, whole_variable_ + 1, scalar(-lambda));
}

// ---- points and answers ----

void Transcription::pack_costs(VectorXd& x) {
  if (joint_turn_variable_ < 0) return;
  point_ = x;
  for (int k = 0; k < steps_; ++k)
    for (int j : powered_) {
      const Joint& joint = system_.joint(j);
      const Vector3d psi = turn_over(k, joint).psi();
      for (Eigen::Index m = 0; m < joint.actuation.cols(); ++m)
        x[joint_turn_variable(k, system_.joint(j).first_control + static_cast<int>(m))] =
            counted_along(joint, m).dot(psi);
    }
  point_ = x;
  double whole = 0.0;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const auto [first, count] = controls_of(powered_[j]);
      NodePower power = NodePower::Zero();
      for (int m = first; m < first + count; ++m) power += x[control_variable(k) + m] * joint_rate(k, m);
      x[power_variable(k, j)] = power[0];
      x[change_variable(k, j)] = power[1];
      whole += power_time(k) * mean_work(power);
      if (!worked_) continue;
      const double size = power.lpNorm<Eigen::Infinity>();
      x[size_variable(k, j)] = size;
      x[sign_variable(k, j)] = size > 0.0 ? power[0] / size : 0.0;
    }
  if (whole_variable_ >= 0) {
    x[whole_variable_] = whole;
    x[whole_variable_ + 1] = (position(steps_) - position(0)).norm();
  }
  point_.resize(0);
}

double Transcription::cost(const VectorXd& x) {
  VectorXd exact = x;
  pack_costs(exact);
  return objective(exact) * cost_unit();
}

std::optional<CostParts> Transcription::cost_parts(const VectorXd& x) {
  if (joint_turn_variable_ < 0) return std::nullopt;
  VectorXd exact = x;
  pack_costs(exact);
  CostParts parts;
  const double s = stretch(x);
  for (int k = 0; k <= steps_; ++k) {
    parts.effort += 0.5 * maneuver_.node_weight[k] / maneuver_.effort *
                    x.segment(control_variable(k), controls_).squaredNorm() * control_unit() * control_unit();
    for (std::size_t j = 0; j < powered_.size(); ++j) {
      const NodePower power = control_unit() * NodePower(exact[power_variable(k, j)], exact[change_variable(k, j)]);
      parts.work += power_time(k) * mean_work(power);
      parts.power += power_time(k) * (power[0] * power[0] + power[1] * power[1] / 3.0);
    }
  }
  parts.angular_velocity = 0.5 / h_ / s * exact.segment(joint_turn_variable_, steps_ * controls_).squaredNorm();
  for (int k = 0; k < steps_; ++k)
    parts.smoothness +=
        0.5 / h_ * control_unit() * control_unit() *
        (x.segment(control_variable(k + 1), controls_) - x.segment(control_variable(k), controls_)).squaredNorm();
  parts.effort *= std::pow(s, -3.0);
  parts.work *= std::pow(s, -work_slows);
  parts.power *= std::pow(s, -other_slows);
  parts.smoothness *= std::pow(s, -other_slows);
  parts.time = duration(x);
  parts.transport = maneuver::work_per_distance(
      parts.work, (x.segment<3>(position_variable(steps_)) - position(0)).norm(), system_.length_unit());
  return parts;
}

// Where e vanishes S is anything: the slopes are what the rows e S = p and e ± d ≥ 0 are worth, of what the work is. Where the
// power is at the edge of a change of sign, as at an end at rest, an interior point's are rough but for what they sum to: those
// that belong to the power are taken. Where work is worth nothing yet, in a search that ended before its multipliers were found, those
// of the power are all that there is.
WorkMultipliers Transcription::work_multipliers(const VectorXd& x, const VectorXd& multiplier) const {
  WorkMultipliers result;
  if (!worked_) return result;
  result.set_zero(system_.joint_count(), steps_ + 1);
  result.weight = 1.0;
  int row = cost_row_ + steps_ * controls_;
  double worth = maneuver_.cost_weights.work / scale_ * std::pow(stretch(x), -work_slows);
  if (whole_variable_ >= 0) worth += multiplier[cost_row_ + cost_row_count() - 2];
  const int nodes = (steps_ + 1) * static_cast<int>(powered_.size());
  const double largest = std::max(x.segment(power_variable_, nodes).lpNorm<Eigen::Infinity>(), 1e-300);
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t j = 0; j < powered_.size(); ++j, row += 6) {
      if (power_time(k) == 0.0) continue;
      const double own = power_time(k) * worth;
      WorkSlopes slopes(-multiplier[row + 2] / own, (multiplier[row + 4] - multiplier[row + 3]) / own);
      if (!(own > 0.0 && slopes.allFinite())) slopes.setZero();
      const NodePower power(x[power_variable(k, j)], x[change_variable(k, j)]);
      for (int n = 0; n < settlings; ++n) slopes = work_term(power / largest, slopes, 1.0).slope;
      result.set(powered_[j], k, slopes);
    }
  return result;
}

}  // namespace lamprey::transcription
