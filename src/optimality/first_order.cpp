#include "optimality/first_order.hpp"

#include <algorithm>
#include <cstdint>

#include "algebra/row_space.hpp"
#include "evidence/cost_check.hpp"
#include "evidence/goal_check.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/step_polynomial.hpp"
#include "mechanics/joint_moments.hpp"
#include "optimality/compliance_in_time.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/curvature.hpp"
#include "optimality/gait_ends.hpp"
#include "optimality/limit_pulls.hpp"

namespace lamprey::optimality {

namespace {

using model::at;
using model::System;

constexpr double dependent_row = 1e-11;  // of the largest pivot
constexpr int most_segments = 20;        // a growth of 1e20 over the whole is 10 over each
constexpr double coasting = 1e-3;        // of what would bring a motion to rest in its time: moments that hardly act
constexpr double worth_of_round_off =
    1e-7;  // of a momentum, or what turns by 1 rad in a step, over a step: of moments whose round-off is a share of 1e-8
constexpr double round_off_alone = 1e-12;  // of the same: moments of a motion that goes on by itself

// Rows by the moments at all nodes turned into rows by the free numbers.
MatrixXd by_free_numbers(const StoredMotion& motion, const evidence::ControlSpace& space, const MatrixXd& by_nodes) {
  if (space.basis.size() == 0) return by_nodes;
  const int controls = motion.system.control_count();
  MatrixXd by_points(by_nodes.rows(), controls * space.basis.cols());
  for (Eigen::Index r = 0; r < by_nodes.rows(); ++r) {
    const VectorXd row = by_nodes.row(r);
    by_points.row(r) = (row.reshaped(controls, motion.steps + 1) * space.basis).reshaped().transpose();
  }
  return by_points;
}

integrator::SweptGradients sweep(const StoredMotion& motion, integrator::StepRange range, const MatrixXd& end_rows) {
  return integrator::gradient_sweep(
      motion.system, motion.lagrangian, motion.time_step,
      [&motion](int k, mechanics::Interval& interval) { evidence::read_interval(motion, k, interval); }, motion.control,
      range, end_rows);
}

}  // namespace

VectorXd state_scale(const StoredMotion& motion, double duration) {
  const VectorXd inertia = mechanics::generalized_inertia(motion.system, motion.solution.rotation.front()).diagonal();
  VectorXd turn = VectorXd::Ones(inertia.size());
  turn.tail<3>().setConstant(motion.system.length_unit());
  VectorXd scale(2 * inertia.size());
  scale << turn, inertia.cwiseProduct(turn) / duration;
  return scale;
}

double worth_by_duration(const StoredMotion& motion) {
  const double cost = evidence::cost_of_free_duration(motion), moments = evidence::actuated_moments(motion).lpNorm<1>();
  if (cost == 0.0) return 0.0;
  const double duration = motion.steps * motion.time_step, effort = motion.problem.effort;
  const double as_dear = effort > 0.0 ? effort * motion.time_step * std::sqrt(2.0 * cost / (effort * duration)) : 0.0;
  if (moments == 0.0) return as_dear;
  const bool few_suffice =
      effort > 0.0 && !motion.problem.limits.of_moments();  // else what they cost may be next to nothing
  return few_suffice ? std::min(cost / moments, as_dear) : cost / moments;
}

namespace {

bool begins_in_motion(const maneuver::Start& start) {
  return !start.linear_velocity.isZero(0.0) || std::any_of(start.angular_velocity.begin(), start.angular_velocity.end(),
                                                           [](const Vector3d& rate) { return !rate.isZero(0.0); });
}

}  // namespace

double gradient_of_coasting(const StoredMotion& motion) {
  evidence::Largest momentum;
  for (const integrator::State& state : evidence::node_states(motion)) {
    momentum.add(state.momentum.head(state.momentum.size() - 3).lpNorm<Eigen::Infinity>());
    momentum.add(motion.system.length_unit() * state.momentum.tail<3>().lpNorm<Eigen::Infinity>());
  }
  const double duration = motion.steps * motion.time_step;
  const double weight = node_weights(motion).maxCoeff();
  if (evidence::periodic(motion)) return coasting * weight * momentum.value() / duration;
  if (!begins_in_motion(motion.problem.start)) return 0.0;
  evidence::Largest inertia;
  for (const model::Body& body : motion.system.bodies()) inertia.add(body.inertia_matrix.norm());
  const double round_off = momentum.value() + inertia.value() / motion.time_step;
  const double worth = weight * round_off / motion.time_step;
  const double spent = weight * evidence::actuated_moments(motion).lpNorm<Eigen::Infinity>();
  if (spent <= round_off_alone * worth) return worth_of_round_off * worth;
  // else what is asked of the gradient still holds of that of the moments, to what a proof rests on
  return std::min(worth_of_round_off * worth, spent * std::max(proof_mark / motion.problem.search.tolerance, 1.0));
}

double gradient_by_later_turns(const StoredMotion& motion) {
  const double weight = motion.problem.cost_weights.angular_velocity;
  if (weight == 0.0) return 0.0;
  const System& system = motion.system;
  const mechanics::Rotations& first = motion.solution.rotation.front();
  const std::vector<mechanics::Vectors> turns = evidence::powers_of(motion).turn;
  MatrixXd turned = MatrixXd::Zero(system.control_count(), motion.steps + 1);
  for (int k = 0; k < motion.steps; ++k)
    turned.col(k + 1) = turned.col(k) + mechanics::along_actuation(system, turns[at(k)]);
  const VectorXd most = turned.rowwise().maxCoeff() - turned.rowwise().minCoeff();
  const VectorXd answer = mechanics::answers_to_moments(system, first);
  evidence::Largest gradient;
  for (Eigen::Index c = 0; c < most.size(); ++c) gradient.add(most[c] * answer[c]);
  return weight * motion.time_step * gradient.value();
}

double least_gradient(const StoredMotion& motion) {
  return std::max({worth_by_duration(motion), gradient_of_coasting(motion), gradient_by_later_turns(motion),
                   gradient_by_displacement(motion)});
}

MatrixXd control_jacobian(const StoredMotion& motion, const evidence::ControlSpace& space, const MatrixXd& end_rows) {
  return by_free_numbers(motion, space, sweep(motion, {0, motion.steps}, end_rows).by_control);
}

namespace {

// What beside the moments is free, as columns after them: the logarithm of a free duration, a periodic motion's first
// shape and its momentum.
struct FreeColumns {
  bool duration = false;
  MatrixXd start;  // [n][columns] directions of the first state
  Eigen::Index count() const { return (duration ? 1 : 0) + start.cols(); }
};

// Rows of a range's end state, pulled back to its start and the moments on the way; and by the logarithm of the time
// step, by what momenta and impulses scale with, h μ and h² u (equation 10.8), and by what springs and dampers feel (6.24).
struct RangeRows {
  integrator::SweptGradients swept;
  VectorXd by_log_time_step;  // [rows]
};

struct Tables {
  const StoredMotion& motion;
  std::vector<integrator::State> state;  // [N + 1]
  MatrixXd moment;                       // [controls][N + 1]
  std::vector<TimedImpulses> timed;      // [N], empty where no step's length is felt
};

// What springs and dampers add to the rows by the logarithm of the time step.
VectorXd compliance_by_log_time_step(const Tables& tables, integrator::StepRange range, const MatrixXd& rows) {
  VectorXd result = VectorXd::Zero(rows.rows());
  if (tables.timed.empty()) return result;
  const Eigen::Index momenta = tables.motion.system.velocity_count();
  MatrixXd carried = rows;
  for (int k = range.last - 1; k >= range.first; --k) {
    result += carried.rightCols(momenta) * tables.timed[at(k)].plus;
    carried = sweep(tables.motion, {k, k + 1}, carried).by_start;
    result -= carried.rightCols(momenta) * tables.timed[at(k)].minus;
  }
  return result;
}

RangeRows pull_back(const Tables& tables, integrator::StepRange range, const MatrixXd& rows) {
  RangeRows result{sweep(tables.motion, range, rows), {}};
  const Eigen::Index momenta = tables.motion.system.velocity_count();
  result.by_log_time_step =
      result.swept.by_start.rightCols(momenta) * tables.state[at(range.first)].momentum +
      2.0 * result.swept.by_control * tables.moment.middleCols(range.first, range.nodes()).reshaped() -
      rows.rightCols(momenta) * tables.state[at(range.last)].momentum;
  result.by_log_time_step += compliance_by_log_time_step(tables, range, rows);
  return result;
}

// The conditions of optimality: gradient + shift is a combination of the rows, all by the moments at the nodes and the
// free columns. Costates at the ends of short segments are unknowns tied by the segments' transition, so that no
// perturbation grows far; what limits pull at enters ties and gradient with their given multipliers.
struct Conditions {
  MatrixXd rows;   // [combinations][moments + free columns]
  VectorXd shift;  // [moments + free columns]
};

Conditions spanning_conditions(const Tables& tables, const MatrixXd& end_rows, const MatrixXd& end_rows_by_start,
                               const LimitPulls& pulls, const FreeColumns& free) {
  const StoredMotion& motion = tables.motion;
  const int controls = motion.system.control_count();
  const Eigen::Index moments = Eigen::Index{controls} * (motion.steps + 1);
  const int segments = std::min(most_segments, motion.steps);
  const auto node = [&](int s) { return static_cast<int>(std::int64_t{motion.steps} * s / segments); };
  const VectorXd scale = state_scale(motion, motion.time_step * node(1));
  const int size = static_cast<int>(scale.size());
  // unknowns: scaled costates at the inner segment ends, then the goal's multipliers
  const auto unknowns = static_cast<int>(end_rows.rows()) + size * (segments - 1);
  MatrixXd ties = MatrixXd::Zero(size * (segments - 1), unknowns);
  VectorXd pulled = VectorXd::Zero(ties.rows());
  MatrixXd by_columns = MatrixXd::Zero(unknowns, moments + free.count());
  Conditions conditions{MatrixXd(), VectorXd::Zero(by_columns.cols())};
  const Eigen::Index first_start = moments + (free.duration ? 1 : 0);
  for (int s = 0; s < segments; ++s) {
    const bool last = s + 1 == segments;
    const MatrixXd rows = last ? end_rows : MatrixXd(scale.cwiseInverse().asDiagonal());
    const RangeRows range = pull_back(tables, {node(s), node(s + 1)}, rows);
    auto own = by_columns.middleRows(size * s, rows.rows());
    own.middleCols(controls * node(s), range.swept.by_control.cols()) += range.swept.by_control;
    if (free.duration) own.col(moments) += range.by_log_time_step;
    if (s == 0 && free.start.cols() > 0) own.rightCols(free.start.cols()) += range.swept.by_start * free.start;
    MatrixXd carried = MatrixXd::Zero(1, size);
    for (int k = node(s + 1) - 1; k >= node(s) && pulls.any; --k) {
      carried += pulls.by_state[at(k + 1)].transpose();
      if (carried.isZero(0.0)) continue;
      const RangeRows step = pull_back(tables, {k, k + 1}, carried);
      conditions.shift.segment(controls * k, 2 * controls) -= step.swept.by_control.transpose();
      if (free.duration) conditions.shift[moments] -= step.by_log_time_step[0];
      carried = step.swept.by_start;
    }
    if (s == 0) {
      if (pulls.any) carried += pulls.by_state.front().transpose();
      if (free.start.cols() > 0) conditions.shift.tail(free.start.cols()) -= (carried * free.start).transpose();
      continue;
    }
    ties.block(size * (s - 1), size * (s - 1), size, size).setIdentity();
    ties.block(size * (s - 1), size * s, size, rows.rows()) = -(scale.asDiagonal() * range.swept.by_start.transpose());
    pulled.segment(size * (s - 1), size) = scale.asDiagonal() * carried.transpose();
  }
  if (end_rows_by_start.size() > 0)
    by_columns.block(size * (segments - 1), first_start, end_rows.rows(), free.start.cols()) += end_rows_by_start;
  if (pulls.any) {
    for (int k = 0; k <= motion.steps; ++k) conditions.shift.segment(controls * k, controls) -= pulls.by_control[at(k)];
    if (free.duration) conditions.shift[moments] -= pulls.by_log_time_step;
    if (!pulled.isZero(0.0)) {  // one choice of costates that the limits pull at; the ties' null space holds all others
      const VectorXd costates = algebra::shortest_solution(ties, pulled);
      conditions.shift -= by_columns.transpose() * costates;
    }
  }
  conditions.rows = algebra::null_space(ties).transpose() * by_columns;
  return conditions;
}

Tables tables_of(const StoredMotion& motion) {
  return {motion, evidence::node_states(motion), evidence::actuated_moments(motion).transpose(),
          timed_impulses(motion)};
}

// Gradient of the cost by all free numbers of an answer, and the conditions that hold them.
struct FirstOrder {
  VectorXd gradient;
  Conditions conditions;
};

// What is free beside the moments, and the rows that tie it: a period's first state and the duration.
struct FreeEnds {
  FreeColumns free;
  MatrixXd end_rows;           // goal, and closure of a period, by the end state
  MatrixXd end_rows_by_start;  // by the free start; empty where it is none
};

FreeEnds free_ends(const StoredMotion& motion, const Tables& tables, const MatrixXd& goal_rows, double momentum_scale) {
  FreeEnds ends{{}, goal_rows, {}};
  ends.free.duration = motion.problem.duration.free;
  if (!evidence::periodic(motion)) return ends;
  const VectorXd unit = VectorXd::Constant(shape_freedoms(motion), momentum_scale);
  ends.free.start = periodic_start(motion, tables.state.front(), unit);
  const MatrixXd closure = closure_rows(motion, tables.state.back(), unit);
  ends.end_rows.resize(goal_rows.rows() + closure.rows(), goal_rows.cols());
  ends.end_rows << goal_rows, closure;
  const Eigen::Index starts = ends.free.start.cols();
  ends.end_rows_by_start.setZero(ends.end_rows.rows(), starts);
  ends.end_rows_by_start.bottomRightCorner(starts, starts) = -MatrixXd::Identity(starts, starts);
  return ends;
}

// The last moments of a period are the first: one number for both.
void join_ends_of_period(Eigen::Index controls, Eigen::Index moments, FirstOrder& order) {
  const auto join = [](auto&& first, auto&& last) {
    first += last;
    last.setZero();
  };
  const Eigen::Index last = moments - controls;
  join(order.gradient.head(controls), order.gradient.segment(last, controls));
  join(order.conditions.shift.head(controls), order.conditions.shift.segment(last, controls));
  join(order.conditions.rows.leftCols(controls), order.conditions.rows.middleCols(last, controls));
}

// A state or the duration changes all nodes' moments: by what that costs it counts, as a moment does by its own; of what costs
// something where moments cost nothing, as all of it.
void weigh_free_numbers(const StoredMotion& motion, const VectorXd& moments, Eigen::Index free, FirstOrder& order) {
  const auto by_moments = order.gradient.head(moments.size());
  const double costs = by_moments.cwiseProduct(moments).lpNorm<1>() + evidence::cost_of_free_duration(motion);
  const double unit = std::max(by_moments.lpNorm<Eigen::Infinity>(), worth_by_duration(motion));
  const double share = costs > 0.0 ? (unit > 0.0 ? unit : 1.0) / costs : 0.0;
  order.gradient.tail(free) *= share;
  order.conditions.shift.tail(free) *= share;
  order.conditions.rows.rightCols(free) *= share;
}

// With one value at each node, `moments`; costs beside effort pull as limits do.
FirstOrder first_order_of_nodes(const StoredMotion& motion, const Tables& tables, const FreeEnds& ends,
                                const VectorXd& moments, const VectorXd& effort_gradient) {
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  const bool beside = weights.any() || weights.of_displacement();
  const CostGradient others = beside ? cost_gradient_beside_effort(motion) : CostGradient();
  LimitPulls pulls = limit_pulls(motion);
  pulls.any = pulls.any || beside;
  for (std::size_t k = 0; k < others.by_state.size(); ++k) pulls.by_state[k] -= others.by_state[k];
  FirstOrder order{effort_gradient,
                   spanning_conditions(tables, ends.end_rows, ends.end_rows_by_start, pulls, ends.free)};
  const Eigen::Index count = moments.size(), free = ends.free.count();
  order.gradient.conservativeResize(count + free);
  order.gradient.tail(free).setZero();
  if (ends.free.duration)
    order.gradient[count] = 0.5 * effort_gradient.dot(moments) +
                            motion.problem.time_weight * motion.time_step * motion.steps + others.by_log_time_step;
  const Eigen::Index controls = motion.system.control_count();
  for (std::size_t k = 0; k < others.by_control.size(); ++k)
    order.gradient.segment(controls * static_cast<Eigen::Index>(k), controls) += others.by_control[k];
  if (weights.any() && evidence::periodic(motion)) join_ends_of_period(controls, count, order);
  weigh_free_numbers(motion, moments, free, order);
  return order;
}

}  // namespace

// What is won by the way, pulled back from the end: rest, without moments, is stationary against it. Where moments move the whole to
// second order alone, as from a straight shape, that is round-off: at least a small share of what the impulse of 1 N m at a node would
// win all through the duration, were it a push at the swimmer's unit of length.
double gradient_by_displacement(const StoredMotion& motion) {
  constexpr double least_share = 1e-7;
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  if (!weights.of_displacement()) return 0.0;
  double mass = 0.0;
  for (const model::Body& body : motion.system.bodies()) mass += body.mass_matrix.norm();
  const double way = motion.time_step * motion.time_step * motion.steps / (mass * motion.system.length_unit());
  const Tables tables = tables_of(motion);
  LimitPulls pulls;
  pulls.any = true;
  pulls.by_state.assign(at(motion.steps + 1), VectorXd::Zero(integrator::StateLayout{motion.system}.size()));
  pulls.by_control.assign(at(motion.steps + 1), VectorXd::Zero(motion.system.control_count()));
  pulls.by_state.back() = -gradient_of_displacement(motion);
  const MatrixXd none(0, pulls.by_state.back().size());
  const double gradient = spanning_conditions(tables, none, {}, pulls, {}).shift.lpNorm<Eigen::Infinity>();
  return std::max(gradient, least_share * weights.displacement.norm() * way);
}

double round_off_of_kkt(const StoredMotion& motion, const evidence::ControlSpace& space, double moment_round_off) {
  const double smoothness = motion.problem.cost_weights.smoothness;
  if (smoothness == 0.0 || space.basis.size() > 0) return moment_round_off;
  VectorXd gradient = cost_gradient(motion, space);
  const CostGradient others = cost_gradient_beside_effort(motion);
  const Eigen::Index controls = motion.system.control_count();
  for (std::size_t k = 0; k < others.by_control.size(); ++k)
    gradient.segment(controls * static_cast<Eigen::Index>(k), controls) += others.by_control[k];
  const double whole = std::max(gradient.lpNorm<Eigen::Infinity>(), least_gradient(motion));
  const double of_differences = 4.0 * smoothness / motion.time_step * space.value.lpNorm<Eigen::Infinity>();
  return moment_round_off * std::max(1.0, whole > 0.0 ? of_differences / whole : 1.0);
}

MatrixXd spanning_rows(const StoredMotion& motion, const evidence::ControlSpace& space, const MatrixXd& end_rows) {
  return by_free_numbers(motion, space, spanning_conditions(tables_of(motion), end_rows, {}, {}, {}).rows);
}

double kkt_residual(const StoredMotion& motion, const evidence::ControlSpace& space, double momentum_scale) {
  const Tables tables = tables_of(motion);
  const evidence::GoalRows goal =
      evidence::goal_rows(motion.system, motion.problem, tables.state.back(), momentum_scale);
  const MatrixXd end_rows = goal.unit.cwiseInverse().asDiagonal() * goal.by_end_state;
  const VectorXd by_numbers = cost_gradient(motion, space);
  FirstOrder order;
  if (space.basis.size() > 0) {  // splines, of effort alone
    order.gradient = by_numbers;
    order.conditions.rows = spanning_rows(motion, space, end_rows);
    order.conditions.shift.setZero(by_numbers.size());
  } else {
    const FreeEnds ends = free_ends(motion, tables, end_rows, momentum_scale);
    order = first_order_of_nodes(motion, tables, ends, space.value, by_numbers);
  }
  evidence::Largest left, whole;
  // multipliers, which may be large along an unstable motion, are not formed
  for (double entry :
       algebra::beyond_rows(order.gradient + order.conditions.shift, order.conditions.rows, dependent_row))
    left.add(std::abs(entry));
  for (double entry : order.gradient) whole.add(std::abs(entry));
  whole.add(least_gradient(motion));
  return left.relative_to(whole.value());
}

namespace {

// Rows by the state at the end of a range of steps, carried to its beginning and to the coefficients on the way.
struct StageSweep {
  MatrixXd by_start;         // [rows][2 velocity_count]
  MatrixXd by_coefficients;  // [rows][steps · inputs]
};

StageSweep sweep(const StoredMotion& motion, const StageMotion& stages, integrator::StepRange range,
                 const MatrixXd& end_rows) {
  const int controls = motion.system.control_count(), inputs = stages.terms * controls;
  StageSweep result{end_rows, MatrixXd::Zero(end_rows.rows(), inputs * (range.last - range.first))};
  integrator::TangentWorkspace work(motion.system);
  integrator::StepTangent tangent(motion.system);
  std::vector<VectorXd> value;
  for (double fraction : stages.fraction) value.push_back(maneuver::legendre(fraction, stages.terms));
  for (int k = range.last - 1; k >= range.first; --k)
    for (int s = stages.stages - 1; s >= 0; --s) {
      const mechanics::ForcedStep stage = evidence::forced_stage(motion, stages, k, s);
      integrator::linearize_step(motion.system, motion.lagrangian, stage.time_step, stage.interval, stage.control,
                                 stage.control_next, work, tangent);
      integrator::PulledBack pulled = integrator::pull_back(tangent, result.by_start);
      for (int term = 0; term < stages.terms; ++term)
        result.by_coefficients.middleCols(inputs * (k - range.first) + term * controls, controls) +=
            value[at(s)][term] * pulled.by_control + value[at(s + 1)][term] * pulled.by_next_control;
      result.by_start.swap(pulled.by_state);
    }
  return result;
}

// Rows that span those of the end rows by all coefficients, as those by the moments at the nodes do.
MatrixXd spanning_rows(const StoredMotion& motion, const StageMotion& stages, const MatrixXd& end_rows) {
  const int inputs = stages.terms * motion.system.control_count();
  const int segments = std::min(most_segments, motion.steps);
  const auto node = [&](int s) { return static_cast<int>(std::int64_t{motion.steps} * s / segments); };
  const VectorXd scale = state_scale(motion, motion.time_step * node(1));
  const int size = static_cast<int>(scale.size());
  // unknowns: scaled costates at the inner segment ends, then the goal's multipliers
  const auto unknowns = static_cast<int>(end_rows.rows()) + size * (segments - 1);
  MatrixXd ties = MatrixXd::Zero(size * (segments - 1), unknowns);
  MatrixXd rows_of_all = MatrixXd::Zero(unknowns, inputs * motion.steps);
  for (int s = 0; s < segments; ++s) {
    const bool last = s + 1 == segments;
    const MatrixXd rows = last ? end_rows : MatrixXd(scale.cwiseInverse().asDiagonal());
    const StageSweep swept = sweep(motion, stages, {node(s), node(s + 1)}, rows);
    rows_of_all.block(size * s, inputs * node(s), rows.rows(), swept.by_coefficients.cols()) = swept.by_coefficients;
    if (s == 0) continue;
    ties.block(size * (s - 1), size * (s - 1), size, size).setIdentity();
    ties.block(size * (s - 1), size * s, size, rows.rows()) = -(scale.asDiagonal() * swept.by_start.transpose());
  }
  return algebra::null_space(ties).transpose() * rows_of_all;
}

}  // namespace

MatrixXd coefficient_jacobian(const StoredMotion& motion, const StageMotion& stages, const MatrixXd& end_rows) {
  return sweep(motion, stages, {0, motion.steps}, end_rows).by_coefficients;
}

double kkt_residual(const StoredMotion& motion, const StageMotion& stages, double momentum_scale) {
  const int inputs = stages.terms * motion.system.control_count();
  VectorXd gradient(inputs * motion.steps);
  for (int k = 0; k < motion.steps; ++k)
    gradient.segment(inputs * k, inputs) = motion.problem.effort * motion.time_step * stages.polynomial[at(k)];
  const evidence::GoalRows goal =
      evidence::goal_rows(motion.system, motion.problem, stages.node.back(), momentum_scale);
  const MatrixXd rows = spanning_rows(motion, stages, goal.unit.cwiseInverse().asDiagonal() * goal.by_end_state);
  evidence::Largest left, whole;
  for (double entry : algebra::beyond_rows(gradient, rows, dependent_row)) left.add(std::abs(entry));
  for (double entry : gradient) whole.add(std::abs(entry));
  return left.relative_to(whole.value());
}

}  // namespace lamprey::optimality
