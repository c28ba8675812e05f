#include "optimality/second_order.hpp"

#include <gtest/gtest.h>

#include "difference_order.hpp"
#include "evidence/control_space.hpp"
#include "evidence/goal_check.hpp"
#include "evidence/stage_motion.hpp"
#include "marched_answers.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/first_order.hpp"

namespace lamprey::tests {
namespace {

using evidence::StoredMotion;
using integrator::Scheme;
using model::at;
using optimality::Chain;
using optimality::ChainStage;

constexpr double momentum_unit = 3.0;  // kg m²/s, of the rows of rest

// The goal put where the motion ends.
void aim_at_the_end(MarchedAnswer& answer) {
  maneuver::Goal goal;
  goal.rest = true;
  for (std::size_t i = 0; i < answer.problem.swimmer.bodies.size(); ++i)
    goal.rotation[answer.problem.swimmer.bodies[i].name] = lie::log(answer.solution.rotation.back()[i]);
  for (std::size_t c = 0; c < 3; ++c)
    goal.move[c] = answer.solution.position.back()[static_cast<Eigen::Index>(c)] -
                   answer.problem.start.position[static_cast<Eigen::Index>(c)];
  answer.problem.goal = goal;
}

// Gradient by the moments of cost + multipliers · goal rows.
VectorXd lagrangian_gradient(const maneuver::Problem& problem, const NodeMoments& moments,
                             const VectorXd& multipliers) {
  const MarchedAnswer answer = march(problem, moments);
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto space = evidence::control_space(motion);
  const auto goal = evidence::goal_rows(system, problem, evidence::node_states(motion).back(), momentum_unit);
  return optimality::cost_gradient(motion, space) +
         optimality::control_jacobian(motion, space, goal.by_end_state).transpose() *
             multipliers.cwiseQuotient(goal.unit);
}

// Costates of these multipliers by the plain sweep: these motions are short.
optimality::Costates swept_costates(const StoredMotion& motion, const optimality::EffortChain& effort,
                                    const VectorXd& multipliers) {
  const auto& [scale, A, B, impulse] = effort.tangents;
  optimality::Costates costates{std::vector<VectorXd>(at(motion.steps + 1)), multipliers, 0.0};
  VectorXd costate = scale.asDiagonal() * effort.goal.by_end_state.transpose() * multipliers;
  for (int k = motion.steps; k >= 0; --k) {
    costates.at_node[at(k)] = costate.cwiseQuotient(scale);
    if (k > 0) costate = (A[at(k - 1)].transpose() * costate).eval();
  }
  return costates;
}

// Rate of the gradient along a direction, as the chain says.
VectorXd hessian_product(const Chain& chain, const VectorXd& direction) {
  const auto stages = static_cast<int>(chain.stage.size());
  const auto controls = chain.stage.front().B.cols();
  std::vector<VectorXd> y = {VectorXd::Zero(chain.end_form.rows())};
  const auto part = [&](int k) -> VectorXd { return direction.segment(controls * k, controls); };
  for (int k = 0; k < stages; ++k) y.push_back(chain.stage[at(k)].A * y.back() + chain.stage[at(k)].B * part(k));
  VectorXd product(direction.size()), costate = chain.end_form * y.back();
  for (int k = stages - 1; k >= 0; --k) {
    const ChainStage& stage = chain.stage[at(k)];
    product.segment(controls * k, controls) = stage.S * y[at(k)] + stage.R * part(k) + stage.B.transpose() * costate;
    costate = (stage.A.transpose() * costate + stage.Q * y[at(k)] + stage.S.transpose() * part(k)).eval();
  }
  return product;
}

void check_hessian(MarchedAnswer answer, unsigned seed, double size, bool joints_alone = false) {
  aim_at_the_end(answer);
  answer.problem.goal->rest = !joints_alone;
  answer.problem.goal->joints_rest = joints_alone;
  const model::System system(answer.problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto effort = optimality::effort_chain(motion, momentum_unit);
  ASSERT_TRUE(effort.has_value());
  Random random(seed);
  VectorXd multipliers(effort->goal.value.size());
  for (double& entry : multipliers) entry = random.normal();
  const VectorXd value = evidence::control_space(motion).value;
  ASSERT_GT(value.size(), 0);
  VectorXd direction(value.size());
  for (double& entry : direction) entry = size * random.normal();
  const Chain chain = optimality::lagrangian_chain(motion, *effort, swept_costates(motion, *effort, multipliers), {});
  expect_second_order_differences(
      [&](double t) {
        return lagrangian_gradient(answer.problem, moments_along_joints(system, value + t * direction, motion.steps),
                                   multipliers);
      },
      hessian_product(chain, direction), 1e-7);
}

TEST(LagrangianChain, matches_central_differences_of_the_gradient_along_the_chain) {
  for (const Scheme scheme : {Scheme::paper, Scheme::trapezoid, Scheme::midpoint}) {
    maneuver::Problem problem = chain_problem(15, 0.3);
    problem.scheme = scheme;
    check_hessian(march(problem, smooth_moments(15, 60.0)), 7, 60.0);
  }
}

TEST(LagrangianChain, matches_them_with_joints_springs_dampers_and_coupled_inertia_of_any_kind) {
  int trees = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Scheme scheme = seed % 3 == 0 ? Scheme::paper : seed % 3 == 1 ? Scheme::trapezoid : Scheme::midpoint;
    const MarchedAnswer answer = any_tree(seed, scheme, 14);
    if (model::System(answer.problem.swimmer).control_count() == 0) continue;
    SCOPED_TRACE(seed);
    check_hessian(answer, seed, 3.0);
    check_hessian(answer, seed, 3.0, true);  // they drift
    ++trees;
  }
  EXPECT_GT(trees, 8);
}

// The chain's form at some inputs.
double form_at(const Chain& chain, const std::vector<VectorXd>& input) {
  VectorXd y = VectorXd::Zero(chain.end_form.rows());
  double value = 0.0;
  for (std::size_t k = 0; k < chain.stage.size(); ++k) {
    const ChainStage& stage = chain.stage[k];
    value += y.dot(stage.Q * y) + 2.0 * input[k].dot(stage.S * y) + input[k].dot(stage.R * input[k]);
    y = (stage.A * y + stage.B * input[k]).eval();
  }
  return value + y.dot(chain.end_form * y);
}

// Cost + multipliers · goal rows, those of rest as impulses, at other impulses h²u in other steps: h exp(τ).
class LagrangianInFreeTime {
 public:
  LagrangianInFreeTime(const maneuver::Problem& problem, VectorXd multipliers)
      : problem_(problem), system_(problem.swimmer), multipliers_(std::move(multipliers)) {}

  double operator()(const VectorXd& impulses, double tau) const {
    maneuver::Problem problem = problem_;
    problem.duration.value *= std::exp(tau);
    const NodeMoments moments = moments_along_joints(system_, std::exp(-2.0 * tau) * impulses, problem.steps);
    const MarchedAnswer answer = march(problem, moments);
    const StoredMotion motion(system_, answer.problem, answer.solution);
    auto goal = evidence::goal_rows(system_, problem, evidence::node_states(motion).back(), momentum_unit);
    goal.value.tail(system_.velocity_count() - 6) *= std::exp(tau);
    const VectorXd used = evidence::control_space(motion).value;
    const VectorXd weights = optimality::node_weights(motion);
    double cost = problem.time_weight * problem.duration.value;
    for (Eigen::Index k = 0; k < weights.size(); ++k)
      cost += 0.5 * weights[k] * used.segment(k * system_.control_count(), system_.control_count()).squaredNorm();
    return cost + multipliers_.dot(goal.value.cwiseQuotient(goal.unit));
  }

 private:
  maneuver::Problem problem_;
  model::System system_;
  VectorXd multipliers_;
};

void check_in_free_time(MarchedAnswer answer, unsigned seed, double size, bool joints_alone) {
  aim_at_the_end(answer);
  answer.problem.goal->rest = !joints_alone;
  answer.problem.goal->joints_rest = joints_alone;
  maneuver::Problem& problem = answer.problem;
  problem.time_weight = 7.0;
  problem.duration.free = true;
  problem.duration.min = 0.1 * problem.duration.value;
  problem.duration.max = 10.0 * problem.duration.value;
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, problem, answer.solution);
  const auto effort = optimality::effort_chain(motion, momentum_unit);
  ASSERT_TRUE(effort.has_value());
  ASSERT_GT(effort->start_by_duration.size(), 0);
  Random random(seed);
  VectorXd multipliers(effort->goal.value.size());
  for (double& entry : multipliers) entry = random.normal();
  const VectorXd value = evidence::control_space(motion).value;
  VectorXd direction(value.size());
  for (double& entry : direction) entry = size * random.normal();
  const double tau = 0.3;
  const Chain chain = optimality::lagrangian_chain(motion, *effort, swept_costates(motion, *effort, multipliers), {});
  ASSERT_EQ(chain.stage.size(), at(problem.steps + 2));
  const auto controls = system.control_count();
  std::vector<VectorXd> input = {VectorXd::Constant(1, tau / chain.stage.front().B.col(0).tail<1>()[0])};
  for (int k = 0; k <= problem.steps; ++k) input.emplace_back(direction.segment(controls * k, controls));
  const LagrangianInFreeTime lagrangian(problem, multipliers);
  expect_second_order_curvature([&](double t) { return lagrangian(value + t * direction, t * tau); },
                                form_at(chain, input));
}

// A start in motion, with total momentum or joints alone: more impulse in longer steps.
TEST(LagrangianChain, of_a_start_in_motion_in_free_time_matches_second_differences) {
  int trees = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Scheme scheme = seed % 3 == 0 ? Scheme::paper : seed % 3 == 1 ? Scheme::trapezoid : Scheme::midpoint;
    MarchedAnswer answer = any_tree(seed, scheme, 14);
    if (model::System(answer.problem.swimmer).control_count() == 0) continue;
    SCOPED_TRACE(seed);
    check_in_free_time(answer, seed, 3.0, false);
    check_in_free_time(answer, seed, 3.0, true);
    ++trees;
  }
  EXPECT_GT(trees, 8);
}

// Above order 2: by the coefficients of the steps' polynomials.
VectorXd lagrangian_gradient_of_stages(const maneuver::Problem& problem, const VectorXd& coefficients,
                                       const VectorXd& multipliers) {
  const MarchedAnswer answer = march_stages(problem, coefficients);
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto stages = evidence::march_again(motion);
  if (!stages) throw std::logic_error("the march cannot be repeated");
  const auto goal = evidence::goal_rows(system, problem, stages->node.back(), momentum_unit);
  return problem.effort * motion.time_step * coefficients +
         optimality::coefficient_jacobian(motion, *stages, goal.by_end_state).transpose() *
             multipliers.cwiseQuotient(goal.unit);
}

void check_hessian_of_stages(maneuver::Problem problem, unsigned seed, double size) {
  Random random(seed);
  const model::System system(problem.swimmer);
  const Eigen::Index width = maneuver::polynomial_terms(problem.scheme) * system.control_count();
  VectorXd coefficients(width * problem.steps), direction(coefficients.size());
  for (double& entry : coefficients) entry = 0.3 * size * random.normal();
  for (double& entry : direction) entry = 0.3 * size * random.normal();
  MarchedAnswer answer = march_stages(problem, coefficients);
  aim_at_the_end(answer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto stages = evidence::march_again(motion);
  ASSERT_TRUE(stages.has_value());
  EXPECT_LE(stages->momentum_error, 1e-9);
  const auto effort = optimality::effort_chain(motion, *stages, momentum_unit);
  ASSERT_TRUE(effort.has_value());
  VectorXd multipliers(effort->goal.value.size());
  for (double& entry : multipliers) entry = random.normal();
  const Chain chain =
      optimality::lagrangian_chain(motion, *stages, *effort, swept_costates(motion, *effort, multipliers));
  expect_second_order_differences(
      [&](double t) {
        return lagrangian_gradient_of_stages(answer.problem, coefficients + t * direction, multipliers);
      },
      hessian_product(chain, direction), 1e-7, 0.2);
}

TEST(LagrangianChain, above_order_2_matches_central_differences_of_the_gradient) {
  for (const Scheme scheme : {Scheme::order4, Scheme::order6}) {
    maneuver::Problem problem = chain_problem(14, 0.3);
    problem.scheme = scheme;
    check_hessian_of_stages(problem, 7, 60.0);
  }
}

TEST(LagrangianChain, above_order_2_matches_them_with_joints_of_any_kind) {
  int trees = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const maneuver::Problem problem = any_tree(seed, seed % 2 == 0 ? Scheme::order4 : Scheme::order6, 14).problem;
    if (model::System(problem.swimmer).control_count() == 0) continue;
    SCOPED_TRACE(seed);
    check_hessian_of_stages(problem, seed, 4.0);
    ++trees;
  }
  EXPECT_GT(trees, 5);
}

}  // namespace
}  // namespace lamprey::tests
