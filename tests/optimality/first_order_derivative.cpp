#include "optimality/first_order.hpp"

#include <gtest/gtest.h>
#include <Eigen/QR>

#include "algebra/row_space.hpp"
#include "certificate/certify.hpp"
#include "difference_order.hpp"
#include "evidence/control_space.hpp"
#include "evidence/goal_check.hpp"
#include "marched_answers.hpp"
#include "optimality/cost_gradient.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using evidence::ControlSpace;
using evidence::StoredMotion;

constexpr int steps = 20;

maneuver::Problem problem_with(maneuver::ControlKind kind) {
  maneuver::Problem problem = chain_problem(steps, 0.2);
  problem.control = kind;
  problem.points = kind == maneuver::ControlKind::spline ? 6 : 0;
  return problem;
}

// Moments at the nodes from the free numbers of the space.
NodeMoments moments_of(const ControlSpace& space, const VectorXd& value, int nodes) {
  const MatrixXd free = value.reshaped(6, value.size() / 6);
  const MatrixXd at_nodes = space.basis.size() == 0 ? free : MatrixXd(free * space.basis.transpose());
  NodeMoments moments;
  for (int k = 0; k < nodes; ++k) moments.push_back({at_nodes.col(k).head<3>(), at_nodes.col(k).tail<3>()});
  return moments;
}

VectorXd goal_values(const maneuver::Problem& problem, const NodeMoments& moments) {
  const MarchedAnswer answer = march(problem, moments);
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  return evidence::goal_rows(system, problem, evidence::node_states(motion).back(), 1.0).value;
}

class Optimality : public ::testing::TestWithParam<maneuver::ControlKind> {};

TEST_P(Optimality, goal_rows_match_central_differences_of_the_march_at_second_order) {
  const maneuver::Problem problem = problem_with(GetParam());
  const MarchedAnswer start = march(problem, smooth_moments(steps, 40.0));
  const model::System system(problem.swimmer);
  const ControlSpace space = evidence::control_space(StoredMotion(system, start.problem, start.solution));
  const MarchedAnswer answer = march(problem, moments_of(space, space.value, steps + 1));
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto rows = evidence::goal_rows(system, problem, evidence::node_states(motion).back(), 1.0);
  ASSERT_EQ(rows.value.size(), 9 + 1 + 6);
  const MatrixXd jacobian = optimality::control_jacobian(motion, space, rows.by_end_state);
  Random random(3);
  VectorXd direction(space.value.size());
  for (double& entry : direction) entry = 100.0 * random.normal();
  for (const auto& [first, count] :
       {std::pair{0, 9}, {9, 1}, {10, 6}})  // angles, displacement, momenta: each by its own size
    expect_second_order_differences(
        [&, from = first, size = count](double t) -> VectorXd {
          return goal_values(problem, moments_of(space, space.value + t * direction, steps + 1)).segment(from, size);
        },
        (jacobian * direction).segment(first, count), 1e-8);
}

// Of a tree that drifts, whose joints are to end at rest: what they carry then follows from where and how the whole ends.
TEST(JointsAtRest, have_rows_that_match_central_differences_of_the_march_at_second_order) {
  int trees = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    MarchedAnswer answer = any_tree(seed, integrator::Scheme::trapezoid, 14);
    const model::System system(answer.problem.swimmer);
    if (system.control_count() == 0) continue;
    SCOPED_TRACE(seed);
    answer.problem.goal = maneuver::Goal{};
    answer.problem.goal->rest = false;
    answer.problem.goal->joints_rest = true;
    const StoredMotion motion(system, answer.problem, answer.solution);
    const VectorXd value = evidence::control_space(motion).value;
    const auto rows = evidence::goal_rows(system, answer.problem, evidence::node_states(motion).back(), 1.0);
    ASSERT_EQ(rows.value.size(), system.velocity_count() - 6);
    Random random(seed);
    VectorXd direction(value.size());
    for (double& entry : direction) entry = 3.0 * random.normal();
    const MatrixXd jacobian = optimality::control_jacobian(motion, evidence::control_space(motion), rows.by_end_state);
    expect_second_order_differences(
        [&](double t) -> VectorXd {
          return goal_values(answer.problem, moments_along_joints(system, value + t * direction, motion.steps));
        },
        jacobian* direction, 1e-8);
    ++trees;
  }
  EXPECT_GT(trees, 6);
}

TEST_P(Optimality, cost_gradient_matches_the_cost) {
  const maneuver::Problem problem = problem_with(GetParam());
  const MarchedAnswer answer = march(problem, smooth_moments(steps, 40.0));
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const ControlSpace space = evidence::control_space(motion);
  const auto cost = [&](const VectorXd& value) {
    const NodeMoments u = moments_of(space, value, steps + 1);
    double sum = 0.0;
    for (int k = 0; k <= steps; ++k)
      for (const Vector3d& moment : u[static_cast<std::size_t>(k)])
        sum += 0.5 * (k == 0 || k == steps ? 0.5 : 1.0) * problem.time_step() * moment.squaredNorm();
    return sum;
  };
  const VectorXd gradient = optimality::cost_gradient(motion, space);
  const VectorXd direction = VectorXd::Random(space.value.size());
  const double slope = 0.5 * (cost(space.value + direction) - cost(space.value - direction));  // quadratic: exact
  ASSERT_NE(slope, 0.0);
  EXPECT_NEAR(gradient.dot(direction), slope, tolerance(1e-11) * cost(space.value));
}

TEST_P(Optimality, segments_span_the_same_rows_as_one_sweep) {
  const maneuver::Problem problem = problem_with(GetParam());
  const MarchedAnswer answer = march(problem, smooth_moments(steps, 40.0));
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const ControlSpace space = evidence::control_space(motion);
  const auto goal = evidence::goal_rows(system, problem, evidence::node_states(motion).back(), 1.0);
  const auto basis = [](const MatrixXd& rows) { return algebra::span_of_rows(rows, 1e-13); };
  const MatrixXd once = basis(optimality::control_jacobian(motion, space, goal.by_end_state));
  const MatrixXd segments = basis(optimality::spanning_rows(motion, space, goal.by_end_state));
  ASSERT_EQ(once.cols(), 16);
  ASSERT_EQ(segments.cols(), 16);
  EXPECT_LE((segments - once * (once.transpose() * segments)).norm(), tolerance(1e-8));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Optimality,
                         ::testing::Values(maneuver::ControlKind::steps, maneuver::ControlKind::spline),
                         named_by_value);

// A goal met by the moments of least effort: Newton's iteration on the goal rows with the cost's own metric, from a
// march. Not the certificate's formula: it forms multipliers, and marches.
TEST(Kkt, vanishes_at_moments_of_least_effort_and_sees_a_change_of_one_of_them) {
  maneuver::Problem problem = chain_problem(steps, 0.2);
  problem.goal->turn.reset();
  problem.goal->move = {};
  problem.goal->rest = false;
  NodeMoments moments = smooth_moments(steps, 10.0);
  const MarchedAnswer reached = march(problem, moments);
  problem.goal->rotation["front"] = lie::log(reached.solution.rotation.back()[1]);
  const model::System system(problem.swimmer);
  VectorXd weight = VectorXd::Constant(6 * (steps + 1), problem.time_step());
  weight.head(6) *= 0.5;
  weight.tail(6) *= 0.5;
  for (int iteration = 0; iteration < 12; ++iteration) {
    const MarchedAnswer answer = march(problem, moments);
    const StoredMotion motion(system, answer.problem, answer.solution);
    const ControlSpace space = evidence::control_space(motion);
    const auto rows = evidence::goal_rows(system, problem, evidence::node_states(motion).back(), 1.0);
    const MatrixXd A = optimality::control_jacobian(motion, space, rows.by_end_state);
    const MatrixXd A_weighted = A * weight.cwiseInverse().asDiagonal();
    const VectorXd multiplier = algebra::least_squares(A_weighted * A.transpose(), A * space.value - rows.value);
    moments = moments_of(space, A_weighted.transpose() * multiplier, steps + 1);
  }
  MarchedAnswer answer = march(problem, moments);
  const certificate::Options no_replay{.replay = false};
  const auto proof = certificate::certify(system, problem, answer.solution, no_replay);
  EXPECT_LE(proof.goal_error, tolerance(1e-12));
  EXPECT_LE(proof.kkt, tolerance(1e-10));
  double largest = 0.0;
  for (const auto& u : answer.solution.control)
    largest = std::max({largest, u[0].cwiseAbs().maxCoeff(), u[1].cwiseAbs().maxCoeff()});
  answer.solution.control[7][0].y() += 1e-3 * largest;
  const double changed = certificate::certify(system, problem, answer.solution, no_replay).kkt;
  EXPECT_GT(changed, 1e-4);
  EXPECT_LT(changed, 1e-2);
}

TEST(Kkt, of_moments_that_serve_no_goal_is_large) {
  const maneuver::Problem problem = problem_with(maneuver::ControlKind::steps);
  const MarchedAnswer answer = march(problem, smooth_moments(steps, 40.0));
  const auto proof = certificate::certify(model::System(problem.swimmer), problem, answer.solution, {.replay = false});
  EXPECT_GT(proof.kkt, 0.05);
  EXPECT_LE(proof.kkt, 1.0 + 1e-9);
}

TEST(Kkt, rows_that_no_planar_moment_moves_do_not_count) {
  maneuver::Problem problem = problem_with(maneuver::ControlKind::steps);
  for (auto& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  const MarchedAnswer answer = march(problem, smooth_moments(steps, 40.0, true));
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, answer.problem, answer.solution);
  const ControlSpace space = evidence::control_space(motion);
  const auto goal = evidence::goal_rows(system, problem, evidence::node_states(motion).back(), 1.0);
  EXPECT_EQ(algebra::span_of_rows(optimality::spanning_rows(motion, space, goal.by_end_state), 1e-11).cols(), 6);
}

}  // namespace
}  // namespace lamprey::tests
