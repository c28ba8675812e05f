#include "optimality/second_order.hpp"

#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "algebra/row_space.hpp"
#include "evidence/cost_check.hpp"
#include "evidence/joints_at_rest.hpp"
#include "optimality/compliance_in_time.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/cost_order.hpp"
#include "optimality/eigenvalues.hpp"
#include "optimality/first_order.hpp"
#include "optimality/gait_ends.hpp"
#include "optimality/gait_phase.hpp"
#include "optimality/spline_order.hpp"
#include "optimality/step_curvature.hpp"

namespace lamprey::optimality {

namespace {

using model::at;

constexpr double least_row = 1e-9;  // of a bound's gradient, that changes of the moments make of it: less is round-off
constexpr double needed_pull = 10.0;  // over what the conditions of first order are missed by

// Curvature of the goal's rotations of led bodies, and of ball joints on them, along constant freedoms, [turns][turns]; at the goal
// that of a body that turns on its own vanishes.
MatrixXd curvature_of_attitudes(const StoredMotion& motion, const VectorXd& multipliers) {
  const model::System& system = motion.system;
  const Eigen::Index turns = system.velocity_count() - 3;
  const mechanics::Rotations& R = motion.solution.rotation.back();
  MatrixXd form = MatrixXd::Zero(turns, turns);
  if (system.only_free_joints()) return form;
  const auto asked = evidence::asked_rotations(system, motion.problem);
  const std::vector<evidence::AskedJoint> joints = evidence::asked_joints(system, motion.problem);
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
      for (const evidence::AskedJoint& asked_joint : joints) {
        const model::Joint& joint = system.joint(asked_joint.joint);
        const int freedoms = system.body(joint.child).freedoms;
        // where it keeps its rotation what does not commute in it vanishes; angles of other joints are freedoms
        if (freedoms == 3) {
          const Vector3d bent = changes[at(joint.child)] - asked_joint.rotation.transpose() * changes[at(joint.parent)];
          form(a, b) += multipliers.segment<3>(row).dot(bent);
        }
        row += freedoms;
      }
    }
  return 0.5 * (form + form.transpose());
}

// Of all goal rows, whose last are of rest, along freedoms and position, [turns + 3] squared.
MatrixXd goal_curvature(const StoredMotion& motion, const VectorXd& multipliers) {
  const model::System& system = motion.system;
  const Eigen::Index place = system.velocity_count();
  MatrixXd form = MatrixXd::Zero(place, place);
  form.topLeftCorner(place - 3, place - 3) = curvature_of_attitudes(motion, multipliers);
  if (motion.problem.goal->joints_rest)
    form -= evidence::curvature_at_rest(system, motion.problem, motion.solution.rotation.back(),
                                        motion.solution.position.back(), multipliers.tail(place - 6));
  return form;
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

// A pull says that its bound holds where the conditions of optimality would be missed without it: where what it does to the
// gradient by moments is well above what these miss anyway (equation 6.6). Others may be anybody's numbers.
void free_needless_bounds(const EffortChain& effort, double missed, std::vector<PullingBound>& bounds) {
  const Eigen::Index reached = effort.basis.back().cols(), inputs = effort.input.size();
  const auto stage = [&](int node) -> const ChainStage& { return effort.chain.stage[effort.first + at(node)]; };
  const auto nodes = static_cast<int>(effort.basis.size());
  std::vector<MatrixXd> gram(at(nodes), MatrixXd::Zero(reached, reached));  // of what earlier moments do to the states
  for (int k = 0; k + 1 < nodes; ++k) {
    const auto A = stage(k).A.topLeftCorner(reached, reached);
    const auto B = stage(k).B.topRows(reached);
    gram[at(k + 1)] = A * gram[at(k)] * A.transpose() + B * B.transpose();
  }
  const auto row = [&](const auto& gradient, int node) -> VectorXd {
    const MatrixXd& basis = effort.basis[at(node)];
    if (basis.size() == 0) return VectorXd::Zero(reached);
    const Eigen::Index size = gradient.size();
    return basis.topRows(size).transpose() * effort.tangents.scale.head(size).cwiseProduct(gradient);
  };
  // a mean over all moments, so at most what it does to one of them
  const auto image = [&](const PullingBound& bound) {
    if (bound.of_moments) return bound.gradient.lpNorm<Eigen::Infinity>();
    const Eigen::Index place = effort.tangents.scale.size() / 2, before = bound.gradient.size() - place;
    const VectorXd here = row(bound.gradient.head(place), bound.node);
    if (before <= 0) return std::sqrt(here.dot(gram[at(bound.node)] * here) / static_cast<double>(inputs));
    const ChainStage& last = stage(bound.node - 1);
    const VectorXd carried =
        row(bound.gradient.tail(before), bound.node - 1) + last.A.topLeftCorner(reached, reached).transpose() * here;
    const double own = (last.B.topRows(reached).transpose() * here).squaredNorm();
    return std::sqrt((own + carried.dot(gram[at(bound.node - 1)] * carried)) / static_cast<double>(inputs));
  };
  for (PullingBound& bound : bounds)
    if (bound.holds && !bound.equality) bound.holds = std::abs(bound.pull) * image(bound) > needed_pull * missed;
}

// Curvature of a bound that pulls, and the row that keeps it where it holds.
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
      map.topLeftCorner(place, states) = here * stage.A.topRows(reached);
      map.topRightCorner(place, controls) = here * stage.B.topRows(reached);
      if (effort.basis[at(bound.node - 1)].size() > 0)
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
  const MatrixXd form = -bound.pull * (map.transpose() * curvature * map);
  const double reached_by = std::hypot(row.head(states).norm(),
                                       bound.of_moments ? row.norm() : input_unit(stage) * row.tail(controls).norm());
  if (bound.holds && reached_by > least_row * gradient.norm()) keep_rows(row.normalized().transpose(), stage);
  stage.Q += form.topLeftCorner(states, states);
  stage.S += form.bottomLeftCorner(controls, states);
  stage.R += form.bottomRightCorner(controls, controls);
}

// The logarithm τ of a free time step as a last state that no stage changes, impulses h²u held in the place of moments:
// the motion knows nothing of it, the effort falls with exp(−3τ) (equation 6.16).
void add_duration(const StoredMotion& motion, const EffortChain& effort, Chain& chain) {
  const Eigen::Index last = chain.end_form.rows();
  widen(chain, last + 1);
  for (ChainStage& stage : chain.stage) stage.A(last, last) = 1.0;
  for (int k = 0; k <= motion.steps; ++k) {
    ChainStage& stage = chain.stage[effort.first + at(k)];
    stage.Q(last, last) = 4.5 * stage.weight * effort.input.col(k).squaredNorm();
    stage.S.col(last) = -3.0 * stage.weight * effort.input.col(k);
  }
  chain.end_form(last, last) = motion.problem.time_weight * motion.time_step * motion.steps;
}

// A start in motion: its momenta hμ grow with τ (equation 6.27).
void add_moving_start(const StoredMotion& motion, const Costates& costates, Eigen::Index duration, Chain& chain) {
  const VectorXd momentum = evidence::start_of(motion.system, motion.problem.start).momentum;
  chain.stage.front().Q(duration, duration) += costates.at_node.front().tail(momentum.size()).dot(momentum);
}

// Joints that end at rest on a whole that drifts: so does what hμ has to be there (equation 6.28).
void add_resting_end(const StoredMotion& motion, const EffortChain& effort, const VectorXd& multipliers,
                     Eigen::Index duration, Chain& chain) {
  const model::System& system = motion.system;
  const evidence::CarriedAtRest carried = evidence::carried_at_rest(
      system, motion.problem, motion.solution.rotation.back(), motion.solution.position.back());
  const Eigen::Index rest = carried.momentum.size(), reached = effort.basis.back().cols();
  const VectorXd pull = multipliers.tail(rest);
  const VectorXd mixed = -configuration(effort, system.velocity_count(), motion.steps).transpose() *
                         (carried.by_configuration.transpose() * pull);
  chain.end_form.row(duration).head(reached) += mixed.transpose();
  chain.end_form.col(duration).head(reached) += mixed;
  chain.end_form(duration, duration) -= carried.momentum.dot(pull);
  MatrixXd rows = MatrixXd::Zero(effort.goal.value.size(), chain.end_form.rows());
  rows.leftCols(reached) = effort.goal.by_end_state * effort.tangents.scale.asDiagonal() * effort.basis.back();
  rows.col(duration).tail(rest) = -carried.momentum.cwiseQuotient(effort.goal.unit.tail(rest));
  chain.end_rows = algebra::span_of_rows(rows(effort.independent, Eigen::all), 0.0).transpose();
}

// The stage before the first that sets τ, by what it makes of the moments: du = −2u dτ.
void begin_with_duration(double cost, const VectorXd& start_by_duration, Eigen::Index duration, Chain& chain) {
  const Eigen::Index states = chain.end_form.rows();
  ChainStage stage;
  stage.A = stage.Q = MatrixXd::Zero(states, states);
  stage.B = MatrixXd::Zero(states, 1);
  stage.B(duration, 0) = 1.0;
  stage.B.col(0).head(start_by_duration.size()) = start_by_duration;
  stage.B /= std::sqrt(8.0 * cost);
  stage.S = MatrixXd::Zero(1, states);
  stage.R = MatrixXd::Zero(1, 1);
  stage.weight = 1.0;
  chain.stage.insert(chain.stage.begin(), stage);
}

}  // namespace

void spread_costates(const EffortChain& effort, const std::vector<VectorXd>& reached,
                     const std::vector<VectorXd>& pulled, Costates& costates) {
  const VectorXd& scale = effort.tangents.scale;
  const Eigen::Index reach = effort.basis.back().cols(), states = reached.back().size();
  const auto nodes = static_cast<int>(effort.basis.size());
  costates.at_node.resize(at(nodes));
  costates.goal.setZero(effort.goal.value.size());
  const MatrixXd rows = effort.goal.by_end_state(effort.independent, Eigen::all) * scale.asDiagonal();
  VectorXd costate = VectorXd::Zero(scale.size());
  if (rows.rows() > 0) {
    MatrixXd independent(rows.rows(), states);
    independent.leftCols(reach) = rows * effort.basis.back();
    if (states > reach) independent.rightCols(states - reach) = effort.goal_by_carried(effort.independent, Eigen::all);
    const VectorXd multipliers = algebra::least_squares(independent.transpose(), reached.back());
    for (std::size_t r = 0; r < effort.independent.size(); ++r)
      costates.goal[effort.independent[r]] = multipliers[static_cast<Eigen::Index>(r)];
    costate = rows.transpose() * multipliers;
  }
  costate += scale.cwiseProduct(pulled.back());
  costates.at_node.back() = costate.cwiseQuotient(scale);
  for (int k = nodes - 2; k >= 0; --k) {
    costate = (effort.tangents.A[at(k)].transpose() * costate + scale.cwiseProduct(pulled[at(k)])).eval();
    const MatrixXd& basis = effort.basis[at(k)];
    if (basis.size() > 0) costate += basis * (reached[effort.first + at(k)].head(reach) - basis.transpose() * costate);
    costates.at_node[at(k)] = costate.cwiseQuotient(scale);
  }
}

Costates costates_by_least_squares(const StoredMotion& motion, const EffortChain& effort,
                                   const std::vector<PullingBound>& bounds) {
  const Chain& chain = effort.chain;
  const VectorXd& scale = effort.tangents.scale;
  const Eigen::Index states = chain.end_form.rows(), reach = effort.basis.back().cols();
  ChainGradient gradient;
  for (int k = 0; k < effort.input.cols(); ++k)
    gradient.by_input.emplace_back(chain.stage[effort.first + at(k)].weight * effort.input.col(k));
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  const bool beside = weights.any() || weights.of_displacement();
  const CostGradient others = beside ? cost_gradient_beside_effort(motion) : CostGradient();
  for (std::size_t k = 0; k < others.by_control.size(); ++k) gradient.by_input[k] += others.by_control[k];
  double whole = least_gradient(motion);
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
  Costates result;
  ChainSolver solver(chain, penalty_per_cost * effort.cost);
  if (!solver.factor(0.0)) {
    result.residual = std::numeric_limits<double>::infinity();
    return result;
  }
  const Inputs change = solver.solve(gradient);

  double left = 0.0;
  for (std::size_t k = effort.first; k < change.size(); ++k)
    left = std::max(left, chain.stage[k].weight * change[k].lpNorm<Eigen::Infinity>());
  result.gradient = whole;
  result.residual = whole > 0.0 ? left / whole : 0.0;
  if (effort.first > 0) result.residual = std::max(result.residual, change.front().lpNorm<Eigen::Infinity>());
  spread_costates(effort, solver.costates(gradient, change), pulled, result);
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
  if (effort.basis.front().size() > 0) here = configuration(effort, turns + 3, 0);
  for (int k = 0; k < motion.steps; ++k) {
    ChainStage& stage = chain.stage[effort.first + at(k)];
    const MatrixXd there = configuration(effort, turns + 3, k + 1);
    evidence::read_interval(motion, k, interval);
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
  const VectorXd goal_multipliers = costates.goal.cwiseQuotient(effort.goal.unit);  // rad, m, kg m²/s
  MatrixXd at_end = goal_curvature(motion, goal_multipliers);
  if (effort.first > 0) {
    at_end.topLeftCorner(turns, turns) +=
        closure_curvature(motion, goal_multipliers.segment(effort.closure, 2 * shape_freedoms(motion)));
    const MatrixXd start = effort.tangents.scale.asDiagonal() * effort.start;
    chain.stage.front().R =
        start_curvature(motion, evidence::node_states(motion).front(), start, costates.at_node.front());
  }
  chain.end_form.setZero();
  chain.end_form.topLeftCorner(reached, reached) = here.transpose() * at_end * here;
  std::optional<Eigen::Index> duration;
  // where nothing is spent, and time costs nothing (else kkt tells), no other duration costs less, and nothing measures it
  if (motion.problem.duration.free && !evidence::duration_holds(motion) && effort.cost > 0.0)
    duration = chain.end_form.rows();
  if (duration) {
    add_duration(motion, effort, chain);
    add_compliance_in_time(motion, effort, costates.at_node, chain);
    if (effort.start_by_duration.size() > 0) add_moving_start(motion, costates, *duration, chain);
    if (motion.problem.goal->joints_rest) add_resting_end(motion, effort, goal_multipliers, *duration, chain);
  }
  for (const PullingBound& bound : bounds) add_bound(motion, effort, bound, duration, chain);
  if (motion.problem.cost_weights.any())
    add_costs(motion, effort, kinks_of(motion, evidence::powers_of(motion)), duration, chain);
  if (duration) begin_with_duration(effort.cost, effort.start_by_duration, *duration, chain);
  return chain;
}

// Of the chain of the steps of a scheme above order 2, the stages of each step condensed.
Chain lagrangian_chain(const StoredMotion& motion, const StageMotion& stages, EffortChain effort,
                       const Costates& costates) {
  const model::System& system = motion.system;
  const VectorXd& scale = effort.tangents.scale;
  const Eigen::Index turns = system.velocity_count() - 3, place = turns + 3;
  const Eigen::Index reached = effort.basis.back().cols(), inputs = effort.input.rows(), all = reached + inputs;
  Chain chain = std::move(effort.chain);
  StepCurvature curvature(system);
  MatrixXd motions(turns + place, all), half(motions.rows(), all), form(all, all);
  for (int k = 0; k < motion.steps; ++k) {
    const StepStages step = step_stages(motion, stages, k, scale);
    const std::vector<VectorXd> costate = step.pull_back(scale, costates.at_node[at(k + 1)]);
    // turns and shift at a stage's node by what arrives at the step and its coefficients
    const auto configuration_at = [&](int s) {
      MatrixXd by_both = MatrixXd::Zero(place, all);
      if (effort.basis[at(k)].size() > 0)
        by_both.leftCols(reached) = step.by_state[at(s)].topRows(place) * effort.basis[at(k)];
      by_both.rightCols(inputs) = step.by_coefficients[at(s)].topRows(place);
      return MatrixXd(scale.head(place).asDiagonal() * by_both);
    };
    form.setZero();
    MatrixXd here = configuration_at(0);
    for (int s = 0; s < stages.stages; ++s) {
      const MatrixXd there = configuration_at(s + 1);
      curvature.evaluate(evidence::forced_stage(motion, stages, k, s), costate[at(s)], costate[at(s + 1)]);
      motions << here.topRows(turns), there;
      motions.bottomRows(3) -= here.bottomRows(3);
      half.noalias() = curvature.by_motion() * motions;
      form.noalias() += motions.transpose() * half;
      const MatrixXd mixed = step.moment[at(s)].transpose() * (curvature.by_control() * here.topRows(turns)) +
                             step.moment[at(s + 1)].transpose() * (curvature.by_next_control() * there.topRows(turns));
      form.bottomRows(inputs) += mixed;
      form.rightCols(inputs) += mixed.transpose();
      here = there;
    }
    ChainStage& stage = chain.stage[at(k)];
    stage.Q = form.topLeftCorner(reached, reached);
    stage.S = form.bottomLeftCorner(inputs, reached);
    stage.R += form.bottomRightCorner(inputs, inputs);
  }
  const MatrixXd last = configuration(effort, place, motion.steps);
  chain.end_form = last.transpose() * goal_curvature(motion, costates.goal.cwiseQuotient(effort.goal.unit)) * last;
  return chain;
}

std::optional<SecondOrder> second_order(const StoredMotion& motion, double momentum_scale, double kkt) {
  std::optional<EffortChain> effort = effort_chain(motion, momentum_scale);
  if (!effort) return std::nullopt;
  if (motion.problem.control == maneuver::ControlKind::spline)
    return second_order_on_splines(motion, std::move(*effort));
  const Kinks kinks = motion.problem.cost_weights.any() ? kinks_of(motion, evidence::powers_of(motion)) : Kinks();
  if (!kinks.known || !ends_fit_costs(motion)) return std::nullopt;
  std::vector<PullingBound> bounds = pulling_bounds(motion);
  const Costates costates = costates_by_least_squares(motion, *effort, bounds);
  if (!(costates.residual <= costates_hold)) return std::nullopt;
  free_needless_bounds(*effort, kkt * costates.gradient, bounds);
  std::optional<Inputs> phase = phase_direction(motion, *effort);
  effort->tangents.A.clear();
  const double cost = effort->cost;
  const Chain chain = lagrangian_chain(motion, std::move(*effort), costates, bounds);
  if (phase && chain.stage.size() > phase->size())
    phase->insert(phase->begin(), VectorXd::Zero(1));  // no other duration
  const std::optional<SecondOrder> result = eigenvalues_of(chain, cost, phase);
  // a multiplier at its bound where the power vanishes too: what costs less on the smooth branch need not cost less
  if (result && kinks.weak && !result->positive) return std::nullopt;
  return result;
}

std::optional<SecondOrder> second_order(const StoredMotion& motion, const StageMotion& stages, double momentum_scale) {
  std::optional<EffortChain> effort = effort_chain(motion, stages, momentum_scale);
  if (!effort) return std::nullopt;
  const Costates costates = costates_by_least_squares(motion, *effort, {});
  if (!(costates.residual <= costates_hold)) return std::nullopt;
  const double cost = effort->cost;
  return eigenvalues_of(lagrangian_chain(motion, stages, std::move(*effort), costates), cost, std::nullopt);
}

}  // namespace lamprey::optimality
