#include "certificate/second_order.hpp"

#include <Eigen/Cholesky>

#include "certificate/cost_order.hpp"
#include "certificate/gait_ends.hpp"
#include "certificate/optimality.hpp"
#include "certificate/step_curvature.hpp"
#include "maneuver/row_space.hpp"

namespace lamprey::certificate {

namespace {

using model::at;

constexpr double dependent_goal_row = 1e-9;  // of the longest
constexpr double costates_hold = 1e-4;       // residual: beyond it multipliers are no costates
constexpr double penalty_per_cost = 1e4;     // of the end rows
constexpr double start_share = 1e-3;         // of the effort: a gait's start moved by 1 rad, in the metric
constexpr double bound_penalty = 1e6;        // of limits and waypoints that pull, against the cost or a moment's weight

MatrixXd moments_by_node(const StoredMotion& motion) {
  return control_space(motion).value.reshaped(motion.system.control_count(), motion.steps + 1);
}

double cost_of(const StoredMotion& motion) {
  const VectorXd weights = node_weights(motion);
  return 0.5 * moments_by_node(motion).colwise().squaredNorm().dot(weights);
}

// Curvature of the goal's rotations of led bodies along constant freedoms, [turns][turns]; at the goal that of a body
// that turns on its own vanishes.
MatrixXd goal_curvature(const StoredMotion& motion, const VectorXd& multipliers) {
  const model::System& system = motion.system;
  const Eigen::Index turns = system.velocity_count() - 3;
  const mechanics::Rotations& R = motion.solution.rotation.back();
  MatrixXd form = MatrixXd::Zero(turns, turns);
  if (system.only_free_joints()) return form;
  const auto asked = asked_rotations(system, motion.problem);
  mechanics::Freedoms first(R.size()), second(R.size());
  mechanics::Vectors first_turns(R.size()), changes(R.size());
  VectorXd unit(system.velocity_count());
  for (Eigen::Index a = 0; a < turns; ++a)
    for (Eigen::Index b = 0; b < turns; ++b) {
      mechanics::unpack(system, unit.setUnit(a), first);
      mechanics::unpack(system, unit.setUnit(b), second);
      mechanics::body_turns(system, R, first, first_turns);
      mechanics::body_turn_changes(system, R, first, first_turns, second, changes);
      Eigen::Index row = 0;
      for (std::size_t i = 0; i < R.size(); ++i) {
        if (!asked[i]) continue;
        form(a, b) += multipliers.segment<3>(row).dot(changes[i]);
        row += 3;
      }
    }
  return 0.5 * (form + form.transpose());
}

// Turns and shift by y at a node, [turns + 3][reached].
MatrixXd configuration(const EffortChain& effort, Eigen::Index size, int node) {
  return effort.tangents.scale.head(size).asDiagonal() * effort.basis[at(node)].topRows(size);
}

// The Lagrangian's gradient by what bounds look at: that by moments added, that by states returned, [N + 1][n].
std::vector<VectorXd> pull_on_states(const StoredMotion& motion, const std::vector<PullingBound>& bounds,
                                     Inputs& by_input) {
  const Eigen::Index place = motion.system.velocity_count();
  std::vector<VectorXd> by_state(at(motion.steps + 1), VectorXd::Zero(2 * place));
  for (const PullingBound& bound : bounds) {
    if (bound.of_moments) {
      by_input[at(bound.node)] -= bound.pull * bound.gradient;
      continue;
    }
    by_state[at(bound.node)].head(place) -= bound.pull * bound.gradient.head(place);
    const Eigen::Index before = bound.gradient.size() - place;
    if (before > 0) by_state[at(bound.node - 1)].head(before) -= bound.pull * bound.gradient.tail(before);
  }
  return by_state;
}

// Curvature of a bound that pulls, and a penalty that keeps it.
void add_bound(const StoredMotion& motion, const EffortChain& effort, const PullingBound& bound,
               std::optional<Eigen::Index> duration, Chain& chain) {
  const Eigen::Index place = motion.system.velocity_count(), before = bound.gradient.size() - place;
  const bool with_before = !bound.of_moments && before > 0;
  ChainStage& stage = chain.stage[effort.first + at(with_before ? bound.node - 1 : bound.node)];
  const Eigen::Index size = bound.gradient.size(), reached = effort.basis.back().cols();
  const Eigen::Index states = stage.A.rows(), controls = stage.B.cols(), timed = duration ? 1 : 0;
  MatrixXd map = MatrixXd::Zero(size + timed, states + controls);
  if (bound.of_moments) {
    map.topRightCorner(size, controls).setIdentity();
  } else {
    const MatrixXd here = configuration(effort, place, bound.node);
    if (!with_before) {
      map.topLeftCorner(size, reached) = here;
    } else {
      map.topLeftCorner(place, reached) = here * stage.A.topLeftCorner(reached, reached);
      map.topRightCorner(place, controls) = here * stage.B.topRows(reached);
      if (bound.node > 1 || effort.first > 0)
        map.block(place, 0, before, reached) = configuration(effort, place, bound.node - 1).topRows(before);
    }
  }
  VectorXd gradient(size + timed);
  MatrixXd curvature(size + timed, size + timed);
  gradient.head(size) = bound.gradient;
  curvature.topLeftCorner(size, size) = bound.curvature;
  if (timed > 0) {
    map(size, *duration) = 1.0;
    gradient[size] = bound.by_time;
    curvature.row(size).head(size) = bound.by_time_mixed.transpose();
    curvature.col(size).head(size) = bound.by_time_mixed;
    curvature(size, size) = bound.by_time_twice;
  }
  const VectorXd row = map.transpose() * gradient;
  const double length = row.head(reached).squaredNorm() + row.tail(controls).squaredNorm();  // in units of its own
  MatrixXd form = -bound.pull * (map.transpose() * curvature * map);
  if (length > 0.0)
    form += bound_penalty * (bound.of_moments ? stage.weight : cost_of(motion)) / length * row * row.transpose();
  stage.Q += form.topLeftCorner(states, states);
  stage.S += form.bottomLeftCorner(controls, states);
  stage.R += form.bottomRightCorner(controls, controls);
}

// The logarithm τ of a free time step as a last state that no stage changes, impulses h²u held in the place of moments:
// the motion knows nothing of it, the effort falls with exp(−3τ) (equation 6.16).
void add_duration(const StoredMotion& motion, std::size_t first, Chain& chain) {
  const MatrixXd moments = moments_by_node(motion);
  const Eigen::Index last = chain.end_form.rows();
  widen(chain, last + 1);
  for (ChainStage& stage : chain.stage) stage.A(last, last) = 1.0;
  for (int k = 0; k <= motion.steps; ++k) {
    ChainStage& stage = chain.stage[first + at(k)];
    stage.Q(last, last) = 4.5 * stage.weight * moments.col(k).squaredNorm();
    stage.S.col(last) = -3.0 * stage.weight * moments.col(k);
  }
  chain.end_form(last, last) = motion.problem.time_weight * motion.time_step * motion.steps;
}

// The stage before the first that sets τ, by what it makes of the moments: du = −2u dτ.
void begin_with_duration(const StoredMotion& motion, Eigen::Index duration, Chain& chain) {
  const Eigen::Index states = chain.end_form.rows();
  ChainStage stage;
  stage.A = stage.Q = MatrixXd::Zero(states, states);
  stage.B = MatrixXd::Zero(states, 1);
  stage.B(duration, 0) = 1.0 / std::sqrt(8.0 * cost_of(motion));
  stage.S = MatrixXd::Zero(1, states);
  stage.R = MatrixXd::Zero(1, 1);
  stage.weight = 1.0;
  chain.stage.insert(chain.stage.begin(), stage);
}

void add_rows(GoalRows& goal, const MatrixXd& rows) {
  const Eigen::Index all = goal.value.size() + rows.rows();
  goal.value.conservativeResize(all);
  goal.value.tail(rows.rows()).setZero();
  goal.unit.conservativeResize(all);
  goal.unit.tail(rows.rows()).setOnes();
  goal.by_end_state.conservativeResize(all, Eigen::NoChange);
  goal.by_end_state.bottomRows(rows.rows()) = rows;
}

// What is free at a gait's start, turns in rad and momenta that each alone would turn by 1 rad in the whole time, and the
// rows that close it after those of the goal. False where moments reach too little of it to tell.
bool set_free_start(const StoredMotion& motion, const std::vector<integrator::State>& states, EffortChain& effort) {
  const VectorXd& scale = effort.tangents.scale;
  const MatrixXd inertia = mechanics::generalized_inertia(motion.system, states.front().rotation);
  const VectorXd unit = (motion.time_step * motion.steps *
                         inertia.llt().solve(MatrixXd::Identity(inertia.rows(), inertia.cols())).diagonal())
                            .segment(3, shape_freedoms(motion))
                            .cwiseInverse();
  const MatrixXd closure = closure_rows(motion, states.back(), unit);
  const MatrixXd directions = scale.cwiseInverse().asDiagonal() * periodic_start(motion, states.front(), unit);
  effort.basis.front() = basis_at_start(effort.tangents, effort.basis);
  const std::optional<MatrixXd> kept =
      start_within_reach(effort.tangents, effort.basis, directions, closure * scale.asDiagonal());
  if (!kept) return false;
  effort.start = directions * *kept;
  GoalRows& goal = effort.goal;
  const Eigen::Index asked = goal.value.size(), all = asked + closure.rows();
  add_rows(goal, closure);
  effort.goal_by_carried = MatrixXd::Zero(all, kept->cols());
  effort.goal_by_carried.bottomRows(kept->rows()) = -*kept;
  effort.closure = asked;
  return true;
}

// Costs beside effort tell the moments at a gait's two ends apart, which are one number: their difference rides along and
// vanishes at the end.
void tie_moments(const StoredMotion& motion, EffortChain& effort) {
  const Eigen::Index controls = motion.system.control_count(), before = effort.chain.end_form.rows();
  Chain& chain = effort.chain;
  widen(chain, before + controls);
  for (ChainStage& stage : chain.stage) stage.A.bottomRightCorner(controls, controls).setIdentity();
  chain.stage.front().B.bottomRows(controls).setIdentity();
  chain.stage.back().B.bottomRows(controls) = -MatrixXd::Identity(controls, controls);
  GoalRows& goal = effort.goal;
  const Eigen::Index asked = goal.value.size(), carried = effort.goal_by_carried.cols();
  add_rows(goal, MatrixXd::Zero(controls, goal.by_end_state.cols()));
  effort.goal_by_carried.conservativeResize(asked + controls, carried + controls);
  effort.goal_by_carried.bottomRows(controls).setZero();
  effort.goal_by_carried.rightCols(controls).setZero();
  effort.goal_by_carried.bottomRightCorner(controls, controls).setIdentity();
}

// The stage before the first that sets a gait's first state.
void begin_with_start(const StoredMotion& motion, EffortChain& effort) {
  const Eigen::Index width = effort.chain.end_form.rows(), carried = effort.start.cols();
  ChainStage stage;
  stage.A = stage.Q = MatrixXd::Zero(width, width);
  stage.B.resize(width, carried);
  stage.B << effort.basis.front().transpose() * effort.start, MatrixXd::Identity(carried, carried),
      MatrixXd::Zero(width - effort.basis.front().cols() - carried, carried);
  stage.S = MatrixXd::Zero(carried, width);
  stage.weight = 2.0 * start_share * cost_of(motion);
  stage.R = stage.weight * MatrixXd::Identity(carried, carried);
  effort.chain.stage.insert(effort.chain.stage.begin(), stage);
  effort.first = 1;
}

}  // namespace

std::optional<EffortChain> effort_chain(const StoredMotion& motion, double momentum_scale) {
  EffortChain effort;
  effort.tangents = step_tangents(motion);
  const StepTangents& tangents = effort.tangents;
  for (const MatrixXd& A : tangents.A)
    if (!A.allFinite()) return std::nullopt;
  effort.basis = reached_bases(tangents);
  if (effort.basis.empty()) return std::nullopt;
  const std::vector<integrator::State> states = node_states(motion);
  effort.goal = goal_rows(motion.system, motion.problem, states.back(), momentum_scale);
  effort.goal.by_end_state = effort.goal.unit.cwiseInverse().asDiagonal() * effort.goal.by_end_state;
  if (periodic(motion) && !set_free_start(motion, states, effort)) return std::nullopt;
  const MatrixXd& last = effort.basis.back();
  const Eigen::Index reached = last.cols(), carried = effort.start.cols(), width = reached + carried;
  const Eigen::Index controls = motion.system.control_count();

  const VectorXd weights = node_weights(motion);
  const double moment = std::sqrt(moments_by_node(motion).squaredNorm() / (motion.steps + 1));
  Chain& chain = effort.chain;
  for (int k = 0; k <= motion.steps; ++k) {
    const MatrixXd& next = k < motion.steps ? effort.basis[at(k + 1)] : last;
    ChainStage stage;
    stage.A = MatrixXd::Identity(width, width);
    auto onwards = stage.A.topLeftCorner(reached, reached);
    if (effort.basis[at(k)].size() == 0)
      onwards.setZero();
    else if (k < motion.steps)
      onwards = next.transpose() * tangents.A[at(k)] * effort.basis[at(k)];
    stage.B = MatrixXd::Zero(width, controls);
    stage.B.topRows(reached) = next.transpose() * tangents.B[at(k)];
    stage.weight = weights[k];
    stage.Q = MatrixXd::Zero(width, width);
    stage.Q.topLeftCorner(reached, reached).diagonal().setConstant(weights[k] * moment * moment);
    stage.S = MatrixXd::Zero(controls, width);
    stage.R = weights[k] * MatrixXd::Identity(controls, controls);
    chain.stage.push_back(stage);
  }
  chain.end_form = MatrixXd::Zero(width, width);
  if (periodic(motion) && motion.problem.cost_weights.any()) tie_moments(motion, effort);
  if (periodic(motion)) begin_with_start(motion, effort);

  MatrixXd rows(effort.goal.value.size(), chain.end_form.rows());
  rows << effort.goal.by_end_state * tangents.scale.asDiagonal() * last, effort.goal_by_carried;
  if (rows.rows() > 0) effort.independent = maneuver::independent_rows(rows, dependent_goal_row);
  chain.end_rows = maneuver::span_of_rows(rows(effort.independent, Eigen::all), 0.0).transpose();
  return effort;
}

Costates costates_by_least_squares(const StoredMotion& motion, const EffortChain& effort,
                                   const std::vector<PullingBound>& bounds) {
  const Chain& chain = effort.chain;
  const MatrixXd moments = moments_by_node(motion);
  const VectorXd& scale = effort.tangents.scale;
  const Eigen::Index states = chain.end_form.rows(), reach = effort.basis.back().cols();
  ChainGradient gradient;
  for (int k = 0; k <= motion.steps; ++k)
    gradient.by_input.emplace_back(chain.stage[effort.first + at(k)].weight * moments.col(k));
  const bool beside = motion.problem.cost_weights.any();
  const CostGradient others = beside ? cost_gradient_beside_effort(motion) : CostGradient();
  for (std::size_t k = 0; k < others.by_control.size(); ++k) gradient.by_input[k] += others.by_control[k];
  double whole = 0.0;
  for (const VectorXd& entry : gradient.by_input) whole = std::max(whole, entry.lpNorm<Eigen::Infinity>());
  std::vector<VectorXd> pulled = pull_on_states(motion, bounds, gradient.by_input);
  for (std::size_t k = 0; k < others.by_state.size(); ++k) pulled[k] += others.by_state[k];
  if (!bounds.empty() || beside) {
    gradient.by_state.assign(chain.stage.size(), VectorXd::Zero(states));
    for (std::size_t k = 0; k < pulled.size(); ++k)
      if (effort.basis[k].size() > 0)
        gradient.by_state[effort.first + k].head(reach) = effort.basis[k].transpose() * scale.cwiseProduct(pulled[k]);
  }
  if (effort.first > 0) gradient.by_input.insert(gradient.by_input.begin(), VectorXd::Zero(effort.start.cols()));
  ChainSolver solver(chain, penalty_per_cost * cost_of(motion));
  solver.factor(0.0);
  const Inputs change = solver.solve(gradient);
  const std::vector<VectorXd> reached = solver.costates(gradient, change);

  Costates result{std::vector<VectorXd>(at(motion.steps + 1)), VectorXd::Zero(effort.goal.value.size()), 0.0};
  double left = 0.0;
  for (std::size_t k = effort.first; k < change.size(); ++k)
    left = std::max(left, chain.stage[k].weight * change[k].lpNorm<Eigen::Infinity>());
  result.residual = whole > 0.0 ? left / whole : 0.0;
  if (effort.first > 0) result.residual = std::max(result.residual, change.front().lpNorm<Eigen::Infinity>());

  const MatrixXd rows = effort.goal.by_end_state(effort.independent, Eigen::all) * scale.asDiagonal();
  VectorXd costate = VectorXd::Zero(scale.size());
  if (rows.rows() > 0) {
    MatrixXd independent(rows.rows(), states);
    independent << rows * effort.basis.back(), effort.goal_by_carried(effort.independent, Eigen::all);
    const VectorXd multipliers = maneuver::least_squares(independent.transpose(), reached.back());
    for (std::size_t r = 0; r < effort.independent.size(); ++r)
      result.goal[effort.independent[r]] = multipliers[static_cast<Eigen::Index>(r)];
    costate = rows.transpose() * multipliers;
  }
  costate += scale.cwiseProduct(pulled.back());
  result.at_node.back() = costate.cwiseQuotient(scale);
  for (int k = motion.steps - 1; k >= 0; --k) {
    costate = (effort.tangents.A[at(k)].transpose() * costate + scale.cwiseProduct(pulled[at(k)])).eval();
    const MatrixXd& basis = effort.basis[at(k)];
    if (basis.size() > 0) costate += basis * (reached[effort.first + at(k)].head(reach) - basis.transpose() * costate);
    result.at_node[at(k)] = costate.cwiseQuotient(scale);
  }
  return result;
}

Chain lagrangian_chain(const StoredMotion& motion, EffortChain effort, const Costates& costates,
                       const std::vector<PullingBound>& bounds) {
  const model::System& system = motion.system;
  const Eigen::Index turns = system.velocity_count() - 3, motions = 2 * turns + 3;
  const Eigen::Index reached = effort.basis.back().cols(), controls = system.control_count();
  Chain chain = std::move(effort.chain);
  StepCurvature curvature(system);
  mechanics::Interval interval(system.body_count());
  MatrixXd map(motions, reached + controls), half(motions, reached + controls);
  MatrixXd here = MatrixXd::Zero(turns + 3, reached);
  if (effort.first > 0) here = configuration(effort, turns + 3, 0);
  for (int k = 0; k < motion.steps; ++k) {
    ChainStage& stage = chain.stage[effort.first + at(k)];
    const MatrixXd there = configuration(effort, turns + 3, k + 1);
    read_interval(motion, k, interval);
    curvature.evaluate(
        {system, motion.lagrangian, motion.time_step, interval, motion.control[at(k)], motion.control[at(k + 1)]},
        costates.at_node[at(k)], costates.at_node[at(k + 1)]);
    map.topRows(turns) << here.topRows(turns), MatrixXd::Zero(turns, controls);
    map.bottomLeftCorner(turns + 3, reached).noalias() = there * stage.A.topLeftCorner(reached, reached);
    map.bottomRightCorner(turns + 3, controls).noalias() = there * stage.B.topRows(reached);
    map.bottomLeftCorner(3, reached) -= here.bottomRows(3);
    half.noalias() = curvature.by_motion() * map;
    const MatrixXd form = map.transpose() * half;
    stage.Q.setZero();
    stage.Q.topLeftCorner(reached, reached) = form.topLeftCorner(reached, reached);
    auto mixed = stage.S.leftCols(reached);
    mixed += form.bottomLeftCorner(controls, reached);
    stage.R += form.bottomRightCorner(controls, controls);
    mixed.noalias() += curvature.by_control() * here.topRows(turns);
    chain.stage[effort.first + at(k + 1)].S.leftCols(reached).noalias() +=
        curvature.by_next_control() * there.topRows(turns);
    here = there;
  }
  chain.stage.back().Q.setZero();
  MatrixXd at_end = goal_curvature(motion, costates.goal);
  if (effort.first > 0) {
    at_end += closure_curvature(motion, costates.goal.segment(effort.closure, 2 * shape_freedoms(motion)));
    const MatrixXd start = effort.tangents.scale.asDiagonal() * effort.start;
    chain.stage.front().R = start_curvature(motion, node_states(motion).front(), start, costates.at_node.front());
  }
  chain.end_form.setZero();
  chain.end_form.topLeftCorner(reached, reached) = here.topRows(turns).transpose() * at_end * here.topRows(turns);
  std::optional<Eigen::Index> duration;
  if (motion.problem.duration.free && !duration_pulls(motion)) duration = chain.end_form.rows();
  if (duration) add_duration(motion, effort.first, chain);
  for (const PullingBound& bound : bounds) add_bound(motion, effort, bound, duration, chain);
  if (motion.problem.cost_weights.any())
    add_costs(motion, effort, kinks_of(motion, powers_of(motion)), duration, chain);
  if (duration) begin_with_duration(motion, *duration, chain);
  return chain;
}

std::optional<SecondOrder> second_order(const StoredMotion& motion, double momentum_scale) {
  std::optional<EffortChain> effort = effort_chain(motion, momentum_scale);
  if (!effort) return std::nullopt;
  const Kinks kinks = motion.problem.cost_weights.any() ? kinks_of(motion, powers_of(motion)) : Kinks();
  if (!kinks.known || !ends_fit_costs(motion)) return std::nullopt;
  const std::vector<PullingBound> bounds = pulling_bounds(motion);
  const Costates costates = costates_by_least_squares(motion, *effort, bounds);
  if (!(costates.residual <= costates_hold)) return std::nullopt;
  effort->tangents.A.clear();
  const Chain chain = lagrangian_chain(motion, std::move(*effort), costates, bounds);
  ChainSolver solver(chain, penalty_per_cost * cost_of(motion));
  SecondOrder result;
  result.smallest_eigenvalue = smallest_eigenvalue(chain, solver).value;
  if (std::isnan(result.smallest_eigenvalue)) return std::nullopt;
  result.positive = solver.factor(curvature_mark) == 0;
  result.negative_eigenvalues = solver.factor(0.0);
  // a multiplier at its bound where the power vanishes too: what costs less on the smooth branch need not cost less
  if (kinks.weak && !result.positive) return std::nullopt;
  return result;
}

}  // namespace lamprey::certificate
