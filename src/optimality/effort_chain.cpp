#include "optimality/effort_chain.hpp"

#include <Eigen/Cholesky>

#include "algebra/row_space.hpp"
#include "optimality/compliance_in_time.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/gait_ends.hpp"

namespace lamprey::optimality {

namespace {

using model::at;

constexpr double dependent_goal_row = 1e-9;  // of the longest
constexpr double start_share = 1e-3;         // of the effort: a gait's start moved by 1 rad, in the metric
constexpr double time_beside_reach = 1e-6;   // of the largest, what a duration may move that moments do not reach
constexpr double start_beside_reach = 1e-7;  // of the momentum at the start, what round-off makes of it

bool find_reach(StepTangents tangents, EffortChain& effort) {
  for (const MatrixXd& A : tangents.A)
    if (!A.allFinite()) return false;
  effort.basis = reached_bases(tangents);
  effort.tangents = std::move(tangents);
  return !effort.basis.empty();
}

// Momentum that a motion of free duration begins with is more impulse over longer steps. Moments do not reach the whole of it
// where that is total momentum.
void set_moving_start(const StoredMotion& motion, EffortChain& effort) {
  if (!motion.problem.duration.free) return;
  const VectorXd momentum = evidence::start_of(motion.system, motion.problem.start).momentum;
  if (momentum.isZero(0.0)) return;
  const VectorXd& scale = effort.tangents.scale;
  VectorXd carried = VectorXd::Zero(scale.size());
  carried.tail(momentum.size()) = momentum.cwiseQuotient(scale.tail(momentum.size()));
  effort.basis.front() = basis_at_start(effort.tangents, effort.basis);
  const auto along = [&] { return VectorXd(effort.basis.front().transpose() * carried); };
  if ((carried - effort.basis.front() * along()).norm() > start_beside_reach * carried.norm())
    take_in(effort.tangents, carried, effort.basis);
  effort.start_by_duration = along();
}

// What a free duration moves through springs and dampers. False where moments do not reach it.
bool find_time(const StoredMotion& motion, EffortChain& effort) {
  double largest = 0.0, beside = 0.0;
  std::vector<VectorXd> steps = steps_by_duration(motion, effort.tangents);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const MatrixXd& basis = effort.basis[k + 1];
    effort.by_duration.emplace_back(basis.transpose() * steps[k]);
    largest = std::max(largest, steps[k].norm());
    beside = std::max(beside, (steps[k] - basis * effort.by_duration.back()).norm());
  }
  return beside <= time_beside_reach * largest;
}

void set_goal(const StoredMotion& motion, const integrator::State& last, double momentum_scale, EffortChain& effort) {
  effort.goal = evidence::goal_rows(motion.system, motion.problem, last, momentum_scale);
  effort.goal.by_end_state = effort.goal.unit.cwiseInverse().asDiagonal() * effort.goal.by_end_state;
}

// A stage for each input, with what a gait's start carries to the end.
void add_stages(const VectorXd& weights, EffortChain& effort) {
  const StepTangents& tangents = effort.tangents;
  const MatrixXd& last = effort.basis.back();
  const Eigen::Index reached = last.cols(), width = reached + effort.start.cols(), inputs = effort.input.rows();
  const double size = std::sqrt(effort.input.squaredNorm() / static_cast<double>(effort.input.cols()));
  for (std::size_t k = 0; k < tangents.B.size(); ++k) {
    const bool steps_on = k < tangents.A.size();
    const MatrixXd& next = steps_on ? effort.basis[k + 1] : last;
    const double weight = weights[static_cast<Eigen::Index>(k)];
    ChainStage stage;
    stage.A = MatrixXd::Identity(width, width);
    auto onwards = stage.A.topLeftCorner(reached, reached);
    if (effort.basis[k].size() == 0)
      onwards.setZero();
    else if (steps_on)
      onwards = next.transpose() * tangents.A[k] * effort.basis[k];
    stage.B = MatrixXd::Zero(width, inputs);
    stage.B.topRows(reached) = next.transpose() * tangents.B[k];
    stage.weight = weight;
    stage.Q = MatrixXd::Zero(width, width);
    stage.Q.topLeftCorner(reached, reached).diagonal().setConstant(weight * size * size);
    stage.S = MatrixXd::Zero(inputs, width);
    stage.R = weight * MatrixXd::Identity(inputs, inputs);
    effort.chain.stage.push_back(stage);
    effort.cost += 0.5 * weight * effort.input.col(static_cast<Eigen::Index>(k)).squaredNorm();
  }
  effort.chain.end_form = MatrixXd::Zero(width, width);
}

void keep_goal(EffortChain& effort) {
  MatrixXd rows(effort.goal.value.size(), effort.chain.end_form.rows());
  rows.leftCols(effort.basis.back().cols()) =
      effort.goal.by_end_state * effort.tangents.scale.asDiagonal() * effort.basis.back();
  if (effort.goal_by_carried.size() > 0) rows.rightCols(effort.goal_by_carried.cols()) = effort.goal_by_carried;
  if (rows.rows() > 0) effort.independent = algebra::independent_rows(rows, dependent_goal_row);
  effort.chain.end_rows = algebra::span_of_rows(rows(effort.independent, Eigen::all), 0.0).transpose();
}

void add_rows(evidence::GoalRows& goal, const MatrixXd& rows) {
  const Eigen::Index all = goal.value.size() + rows.rows();
  goal.value.conservativeResize(all);
  goal.value.tail(rows.rows()).setZero();
  goal.unit.conservativeResize(all);
  goal.unit.tail(rows.rows()).setOnes();
  goal.by_end_state.conservativeResize(all, Eigen::NoChange);
  goal.by_end_state.bottomRows(rows.rows()) = rows;
}

// What is free at a gait's start, turns in rad and momenta that each alone would turn by 1 rad in the whole time, and the
// rows that close it after those of the goal. Where what moments do not reach of it cannot be set aside, the chain takes it in.
void set_free_start(const StoredMotion& motion, const std::vector<integrator::State>& states, EffortChain& effort) {
  const VectorXd& scale = effort.tangents.scale;
  const MatrixXd inertia = mechanics::generalized_inertia(motion.system, states.front().rotation);
  const VectorXd unit = (motion.time_step * motion.steps *
                         inertia.llt().solve(MatrixXd::Identity(inertia.rows(), inertia.cols())).diagonal())
                            .segment(3, shape_freedoms(motion))
                            .cwiseInverse();
  const MatrixXd closure = closure_rows(motion, states.back(), unit);
  const MatrixXd directions = scale.cwiseInverse().asDiagonal() * periodic_start(motion, states.front(), unit);
  effort.basis.front() = basis_at_start(effort.tangents, effort.basis);
  std::optional<MatrixXd> kept =
      start_within_reach(effort.tangents, effort.basis, directions, closure * scale.asDiagonal());
  if (!kept) {
    take_in(effort.tangents, directions, effort.basis);
    kept = MatrixXd::Identity(directions.cols(), directions.cols());
  }
  effort.start = directions * *kept;
  evidence::GoalRows& goal = effort.goal;
  const Eigen::Index asked = goal.value.size(), all = asked + closure.rows();
  add_rows(goal, closure);
  effort.goal_by_carried = MatrixXd::Zero(all, kept->cols());
  effort.goal_by_carried.bottomRows(kept->rows()) = -*kept;
  effort.closure = asked;
}

// Costs beside effort tell the moments at a gait's two ends apart, which are one number: their difference rides along and
// vanishes at the end, in units of the largest moment.
void tie_moments(const StoredMotion& motion, EffortChain& effort) {
  const Eigen::Index controls = motion.system.control_count(), before = effort.chain.end_form.rows();
  const double largest = effort.input.lpNorm<Eigen::Infinity>();
  const MatrixXd by_moments = MatrixXd::Identity(controls, controls) / (largest > 0.0 ? largest : 1.0);
  Chain& chain = effort.chain;
  widen(chain, before + controls);
  for (ChainStage& stage : chain.stage) stage.A.bottomRightCorner(controls, controls).setIdentity();
  chain.stage.front().B.bottomRows(controls) = by_moments;
  chain.stage.back().B.bottomRows(controls) = -by_moments;
  evidence::GoalRows& goal = effort.goal;
  const Eigen::Index asked = goal.value.size(), carried = effort.goal_by_carried.cols();
  add_rows(goal, MatrixXd::Zero(controls, goal.by_end_state.cols()));
  effort.goal_by_carried.conservativeResize(asked + controls, carried + controls);
  effort.goal_by_carried.bottomRows(controls).setZero();
  effort.goal_by_carried.rightCols(controls).setZero();
  effort.goal_by_carried.bottomRightCorner(controls, controls).setIdentity();
}

// The stage before the first that sets a gait's first state.
void begin_with_start(EffortChain& effort) {
  const Eigen::Index width = effort.chain.end_form.rows(), carried = effort.start.cols();
  ChainStage stage;
  stage.A = stage.Q = MatrixXd::Zero(width, width);
  stage.B.resize(width, carried);
  stage.B << effort.basis.front().transpose() * effort.start, MatrixXd::Identity(carried, carried),
      MatrixXd::Zero(width - effort.basis.front().cols() - carried, carried);
  stage.S = MatrixXd::Zero(carried, width);
  stage.weight = 2.0 * start_share * effort.cost;
  stage.R = stage.weight * MatrixXd::Identity(carried, carried);
  effort.chain.stage.insert(effort.chain.stage.begin(), stage);
  effort.first = 1;
}

}  // namespace

std::optional<EffortChain> effort_chain(const StoredMotion& motion, double momentum_scale) {
  EffortChain effort;
  effort.input = evidence::actuated_moments(motion).transpose();
  if (!find_reach(step_tangents(motion), effort)) return std::nullopt;
  const std::vector<integrator::State> states = evidence::node_states(motion);
  set_goal(motion, states.back(), momentum_scale, effort);
  if (evidence::periodic(motion))
    set_free_start(motion, states, effort);
  else
    set_moving_start(motion, effort);
  if (!find_time(motion, effort)) return std::nullopt;
  add_stages(node_weights(motion), effort);
  if (evidence::periodic(motion) && motion.problem.cost_weights.any()) tie_moments(motion, effort);
  if (evidence::periodic(motion)) begin_with_start(effort);
  keep_goal(effort);
  return effort;
}

std::optional<EffortChain> effort_chain(const StoredMotion& motion, const StageMotion& stages, double momentum_scale) {
  EffortChain effort;
  effort.input.resize(stages.polynomial.front().size(), motion.steps);
  for (int k = 0; k < motion.steps; ++k) effort.input.col(k) = stages.polynomial[at(k)];
  if (!find_reach(step_tangents(motion, stages), effort)) return std::nullopt;
  set_goal(motion, stages.node.back(), momentum_scale, effort);
  add_stages(VectorXd::Constant(motion.steps, motion.problem.effort * motion.time_step), effort);
  keep_goal(effort);
  return effort;
}

}  // namespace lamprey::optimality
