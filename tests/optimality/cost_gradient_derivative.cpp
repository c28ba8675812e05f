#include "optimality/cost_gradient.hpp"

#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "difference_order.hpp"
#include "evidence/cost_check.hpp"
#include "integrator/step_derivatives.hpp"
#include "marched_answers.hpp"

namespace lamprey::tests {
namespace {

using evidence::StoredMotion;
using model::at;

constexpr int few_steps = 8;

// Stored nodes moved at random and what the gradient says of it.
void check_gradient(MarchedAnswer answer, const maneuver::CostWeights& weights, bool periodic, unsigned seed) {
  answer.problem.goal = maneuver::Goal{};
  answer.problem.goal->periodic = periodic;
  answer.problem.cost_weights = weights;
  answer.problem.effort = 1e-9;  // its gradient has a test of its own
  const model::System system(answer.problem.swimmer);
  if (system.control_count() == 0) return;
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto gradient = optimality::cost_gradient_beside_effort(motion);
  Random random(seed);
  const integrator::StateLayout layout{system};
  std::vector<mechanics::Freedoms> turns;
  std::vector<VectorXd> moments;
  NodeMoments before, along;
  double slope = 0.0;
  const Vector3d shift = random.vector(0.3);
  for (int k = 0; k <= few_steps; ++k) {
    turns.push_back(random_freedoms(random, system, 1.0));
    moments.emplace_back(system.control_count());
    for (double& entry : moments.back()) entry = random.normal();
    before.push_back(motion.control[at(k)]);
    along.push_back(moments_along_joints(system, moments.back(), 0).front());
    slope += gradient.by_control[at(k)].dot(moments.back());
    for (int i = 0; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms; ++f)
        slope += gradient.by_state[at(k)][layout.freedom(i) + f] * turns.back()[at(i)][f];
  }
  slope += gradient.by_state.back().segment<3>(layout.position()).dot(shift) + gradient.by_log_time_step;
  ASSERT_NE(slope, 0.0);
  const auto cost_at = [&](double t) {
    MarchedAnswer moved = answer;
    for (int k = 0; k <= few_steps; ++k) {
      mechanics::Freedoms turn = turns[at(k)];
      for (Vector3d& own : turn) own *= t;
      moved.solution.rotation[at(k)] = turned(system, answer.solution.rotation[at(k)], turn);
      mechanics::Moments u = before[at(k)];
      for (std::size_t j = 0; j < u.size(); ++j) u[j] += t * along[at(k)][j];
      moved.solution.control[at(k)] = mechanics::applied_moments(system, moved.solution.rotation[at(k)], u);
      moved.solution.time[at(k)] *= std::exp(t);
    }
    moved.solution.position.back() += t * shift;
    return VectorXd::Constant(1, evidence::check_cost(StoredMotion(system, moved.problem, moved.solution)).cost);
  };
  if (weights.power + weights.smoothness + weights.angular_velocity > 0.0) {
    expect_second_order_differences(cost_at, VectorXd::Constant(1, slope), 1e-6);
  } else {  // short of the kinks, where nothing but round-off would be left of the order
    const auto difference = [&](double t) { return (cost_at(t) - cost_at(-t))[0] / (2.0 * t); };
    const double t = 1e-5;
    EXPECT_NEAR((4.0 * difference(t) - difference(2.0 * t)) / 3.0, slope, tolerance(2e-6) * std::abs(slope));
  }
}

TEST(CostGradient, matches_central_differences_of_the_cost_for_every_joint_and_weight) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const MarchedAnswer answer = any_tree(seed, integrator::Scheme::trapezoid, few_steps);
    for (const bool periodic : {false, true})
      for (const maneuver::CostWeights& weights : {maneuver::CostWeights{.work = 3.0},
                                                   {.power = 2.0},
                                                   {.smoothness = 0.1},
                                                   {.angular_velocity = 50.0},
                                                   {.transport = 2.0},
                                                   {.displacement = Vector3d(5.0, -3.0, 2.0)}}) {
        SCOPED_TRACE(::testing::Message()
                     << "seed " << seed << ", periodic " << periodic << ", work " << weights.work << ", power "
                     << weights.power << ", smoothness " << weights.smoothness << ", angular velocity "
                     << weights.angular_velocity << ", displacement " << weights.displacement.transpose());
        check_gradient(answer, weights, periodic, seed);
      }
  }
}

TEST(CostGradient, a_part_of_the_cost_that_older_files_do_not_tell_is_no_error) {
  MarchedAnswer answer = march(chain_problem(few_steps, 0.3), smooth_moments(few_steps, 60.0));
  answer.problem.cost_weights.work = 1.0;
  const model::System system(answer.problem.swimmer);
  const evidence::CostCheck check = evidence::check_cost(StoredMotion(system, answer.problem, answer.solution));
  answer.solution.cost = check.cost;
  answer.solution.cost_parts = check.parts;
  const auto error = [&] { return certificate::certify(system, answer.problem, answer.solution).cost_error; };
  EXPECT_LE(error(), 1e-12);
  answer.solution.cost_parts->angular_velocity = std::nan("");
  EXPECT_LE(error(), 1e-12);
  answer.solution.cost_parts->angular_velocity = 2.0 * check.parts.angular_velocity;
  EXPECT_GT(error(), 0.5);
}

TEST(CostGradient, a_stored_multiplier_that_is_not_the_powers_sign_is_told) {
  MarchedAnswer answer = march(chain_problem(few_steps, 0.3), smooth_moments(few_steps, 60.0));
  answer.problem.cost_weights.work = 1.0;
  const model::System system(answer.problem.swimmer);
  EXPECT_LE(evidence::check_cost(StoredMotion(system, answer.problem, answer.solution)).signs, tolerance(1e-12));
  answer.solution.work_multipliers.assign(2, std::vector<double>(few_steps + 1, 1.0));
  EXPECT_GT(evidence::check_cost(StoredMotion(system, answer.problem, answer.solution)).signs, 1e-2);
}

}  // namespace
}  // namespace lamprey::tests
