// The test of second order at solved maneuvers, against dense linear algebra on second derivatives from elsewhere: those
// of the transcription, in other unknowns, and differences of the gradient.
#include "optimality/second_order.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "algebra/row_space.hpp"
#include "certificate/certify.hpp"
#include "evidence/balance.hpp"
#include "evidence/control_space.hpp"
#include "evidence/cost_check.hpp"
#include "evidence/goal_check.hpp"
#include "file/problem_file.hpp"
#include "integrator/step_derivatives.hpp"
#include "marched_answers.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/first_order.hpp"
#include "optimality/limit_pulls.hpp"
#include "search/solver.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"
#include "transcription/goal_rank.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::tests {
namespace {

using evidence::StoredMotion;
using model::at;
using optimality::SecondOrder;

maneuver::Solution solved(const maneuver::Problem& problem) {
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  return answer.solution;
}

SecondOrder second_order_of(const maneuver::Problem& problem, const maneuver::Solution& solution) {
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, problem, solution);
  const double scale = evidence::check_balance(motion).scale;
  const double kkt = optimality::kkt_residual(motion, evidence::control_space(motion), scale);
  return optimality::second_order(motion, scale, kkt).value_or(SecondOrder());
}

maneuver::Problem in_the_plane(int count) {
  maneuver::Problem problem = chain_problem(count, 1.0);
  problem.goal->turn = Vector3d(0, 0, 0.3);
  problem.goal->move = {0.5, std::nullopt, std::nullopt};
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  problem.search.starts = 4;
  return problem;
}

maneuver::Problem with_all_axes(maneuver::Problem problem) {
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes.reset();
  return problem;
}

maneuver::Problem with_no_limits(maneuver::Problem problem) {
  problem.limits = maneuver::Limits();
  return problem;
}

maneuver::Problem in_space(int count) {
  maneuver::Problem problem = chain_problem(count, 1.0);
  problem.goal->turn = Vector3d(0.05, -0.03, 0.08);
  problem.goal->move = {0.1, std::nullopt, std::nullopt};
  problem.search.starts = 4;
  return problem;
}

maneuver::Problem of_mixed_joints(int count) {
  maneuver::Problem problem;
  problem.swimmer = swimmer_of_mixed_joints();
  problem.swimmer.joints[1].damping = 0.3;
  problem.start.rotation.assign(4, Vector3d::Zero());
  problem.start.angular_velocity.assign(4, Vector3d::Zero());
  problem.steps = count;
  problem.scheme = maneuver::Scheme::midpoint;
  problem.goal = maneuver::Goal{};
  problem.goal->turn = Vector3d(0.1, 0.2, -0.1);
  problem.goal->move = {0.1, std::nullopt, std::nullopt};
  problem.search.starts = 4;
  return problem;
}

struct Marched {
  VectorXd gradient;  // of the cost less what limits pull
  MatrixXd goal;      // rows by the moments
};

Marched marched(const maneuver::Problem& problem, const VectorXd& value,
                const std::vector<maneuver::LimitMultiplier>& limits) {
  const model::System system(problem.swimmer);
  MarchedAnswer answer = march(problem, moments_along_joints(system, value, problem.steps));
  answer.solution.limit_multipliers = limits;
  const StoredMotion motion(system, answer.problem, answer.solution);
  const auto space = evidence::control_space(motion);
  const auto goal = evidence::goal_rows(system, problem, evidence::node_states(motion).back(), 1.0);
  Marched result{optimality::cost_gradient(motion, space),
                 optimality::control_jacobian(motion, space, goal.by_end_state)};
  const optimality::LimitPulls pulls = optimality::limit_pulls(motion);
  const Eigen::Index controls = system.control_count();
  for (int k = 0; k <= problem.steps && pulls.any; ++k) {
    result.gradient.segment(controls * k, controls) -= pulls.by_control[at(k)];
    if (k == 0 || pulls.by_state[at(k)].isZero(0.0)) continue;
    const auto swept = integrator::gradient_sweep(
        system, motion.lagrangian, motion.time_step,
        [&](int step, mechanics::Interval& interval) { evidence::read_interval(motion, step, interval); },
        motion.control, {0, k}, pulls.by_state[at(k)].transpose());
    result.gradient.head(swept.by_control.cols()) -= swept.by_control.transpose();
  }
  return result;
}

// All eigenvalues by the definition: Hessian of cost + multipliers · goal by extrapolated central differences of its
// gradient, the null space of the goal's rows, the metric of the effort.
VectorXd dense_eigenvalues(const maneuver::Problem& problem, const maneuver::Solution& solution) {
  const model::System system(problem.swimmer);
  const StoredMotion motion(system, problem, solution);
  const VectorXd value = evidence::control_space(motion).value;
  const Eigen::Index size = value.size(), controls = system.control_count();
  const std::vector<maneuver::LimitMultiplier>& limits = solution.limit_multipliers;
  const Marched here = marched(problem, value, limits);
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> rows(here.goal.transpose());
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> ranked = rows;
  ranked.setThreshold(1e-9);
  const VectorXd multipliers = ranked.solve(-here.gradient);
  EXPECT_LE((here.gradient + here.goal.transpose() * multipliers).norm(), 1e-6 * here.gradient.norm());
  std::vector<VectorXd> kept;
  for (Eigen::Index r = 0; r < here.goal.rows(); ++r) kept.emplace_back(here.goal.row(r));
  const VectorXd free = marched(problem, value, {}).gradient;
  for (const maneuver::LimitMultiplier& own : limits)  // a row for each node that pulls
    for (std::size_t k = 0; k < own.multiplier.size(); ++k) {
      if (own.multiplier[k] <= 0.0) continue;
      maneuver::LimitMultiplier single = own;
      for (double& entry : single.multiplier) entry = 0.0;
      single.multiplier[k] = 1.0;
      kept.push_back((free - marched(problem, value, {single}).gradient).normalized());
    }
  MatrixXd all(static_cast<Eigen::Index>(kept.size()), size);
  for (std::size_t r = 0; r < kept.size(); ++r) all.row(static_cast<Eigen::Index>(r)) = kept[r];
  Eigen::FullPivLU<MatrixXd> lu(all);
  lu.setThreshold(1e-9);
  const MatrixXd Z = lu.kernel();

  const double step = 2e-4 * value.lpNorm<Eigen::Infinity>();
  const auto gradient = [&](Eigen::Index column, double length) -> VectorXd {
    const Marched there = marched(problem, value + length * VectorXd::Unit(size, column), limits);
    return there.gradient + there.goal.transpose() * multipliers;
  };
  MatrixXd hessian(size, size);
  for (Eigen::Index c = 0; c < size; ++c) {
    const auto quotient = [&](double length) -> VectorXd {
      return (gradient(c, length) - gradient(c, -length)) / (2.0 * length);
    };
    hessian.col(c) = (4.0 * quotient(0.5 * step) - quotient(step)) / 3.0;
  }
  VectorXd metric(size);
  const VectorXd weights = optimality::node_weights(motion);
  for (Eigen::Index c = 0; c < size; ++c) metric[c] = weights[c / controls];
  const MatrixXd reduced = Z.transpose() * hessian * Z;
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(
             0.5 * (reduced + reduced.transpose()), Z.transpose() * metric.asDiagonal() * Z, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

// The same by the transcription's Hessian on the null space of its constraints.
VectorXd transcribed_eigenvalues(const maneuver::Problem& problem, const maneuver::Solution& solution) {
  const model::System system(problem.swimmer);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, problem.steps);
  const StoredMotion motion(system, problem, solution);
  const MatrixXd moments = evidence::actuated_moments(motion);
  maneuver::NodePath path;
  path.rotation = solution.rotation;
  path.position = solution.position;
  for (int k = 0; k <= problem.steps; ++k) {
    path.control.emplace_back(moments.row(k));
    if (k == problem.steps) break;
    path.cayley.emplace_back();
    for (std::size_t i = 0; i < solution.rotation[at(k)].size(); ++i)
      path.cayley.back().push_back(
          lie::inverse_cayley(solution.rotation[at(k)][i].transpose() * solution.rotation[at(k + 1)][i]));
  }
  transcription::Transcription program(system, maneuver, transcription::independent_goal_rows(system, maneuver, path));
  const VectorXd point = program.pack(path);
  const auto dense = [](const optimizer::SparsePattern& pattern, const VectorXd& values, int height, int width) {
    MatrixXd m = MatrixXd::Zero(height, width);
    for (int n = 0; n < pattern.size(); ++n) m(pattern.rows[at(n)], pattern.columns[at(n)]) += values[n];
    return m;
  };
  const int variables = program.variable_count(), constraints = program.constraint_count();
  VectorXd values(program.jacobian_pattern().size()), gradient(variables), residual(constraints);
  program.constraints(point, residual);
  EXPECT_LE(residual.lpNorm<Eigen::Infinity>(), 1e-8);
  program.jacobian(point, values);
  const MatrixXd J = dense(program.jacobian_pattern(), values, constraints, variables);
  program.gradient(point, gradient);
  const VectorXd multipliers = algebra::least_squares(J.transpose(), -gradient);
  EXPECT_LE((gradient + J.transpose() * multipliers).norm(), 1e-7 * gradient.norm());
  const MatrixXd Z = algebra::null_space(J);
  const auto reduced = [&](double factor, const VectorXd& weights) -> MatrixXd {
    values.resize(program.hessian_pattern().size());
    program.hessian(point, factor, weights, values);
    const MatrixXd lower = dense(program.hessian_pattern(), values, variables, variables);
    const MatrixXd whole = lower.selfadjointView<Eigen::Lower>();
    return Z.transpose() * whole * Z;
  };
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(
             reduced(1.0, multipliers), reduced(1.0, VectorXd::Zero(constraints)), Eigen::EigenvaluesOnly)
      .eigenvalues();
}

void expect_eigenvalues(const maneuver::Problem& problem, const maneuver::Solution& solution, const VectorXd& values) {
  const SecondOrder found = second_order_of(problem, solution);
  EXPECT_NEAR(found.smallest_eigenvalue, values[0], tolerance(1e-6) * std::max(1.0, std::abs(values[0])));
  ASSERT_TRUE(found.negative_eigenvalues.has_value());
  EXPECT_EQ(*found.negative_eigenvalues, (values.array() < 0.0).count());
  EXPECT_EQ(found.positive, values[0] > 1e-6);
}

TEST(SecondOrder, in_the_plane_and_out_of_it_is_that_of_the_transcription) {
  const maneuver::Problem problem = in_the_plane(24);
  const maneuver::Solution solution = solved(problem);
  const VectorXd values = transcribed_eigenvalues(problem, solution);
  EXPECT_GT(values[0], 0.0);
  expect_eigenvalues(problem, solution, values);
  const maneuver::Problem free = with_all_axes(problem);
  const VectorXd free_values = transcribed_eigenvalues(free, solution);
  EXPECT_LT(free_values[0], 0.0) << "a saddle once it may leave the plane";
  expect_eigenvalues(free, solution, free_values);
}

TEST(SecondOrder, in_space_is_that_of_the_transcription) {
  for (const maneuver::Scheme scheme : {maneuver::Scheme::paper, maneuver::Scheme::trapezoid}) {
    maneuver::Problem problem = in_space(24);
    problem.scheme = scheme;
    const maneuver::Solution solution = solved(problem);
    expect_eigenvalues(problem, solution, transcribed_eigenvalues(problem, solution));
  }
}

TEST(SecondOrder, of_mixed_joints_with_springs_and_dampers_is_that_of_differences_of_the_gradient) {
  const maneuver::Problem problem = of_mixed_joints(24);
  const maneuver::Solution solution = solved(problem);
  expect_eigenvalues(problem, solution, dense_eigenvalues(problem, solution));
}

// A ball joint alone, below a body that another joint leads: what all joints keep would turn as one body.
TEST(SecondOrder, where_a_joint_is_told_how_to_end_is_that_of_differences_of_the_gradient) {
  maneuver::Problem problem = of_mixed_joints(24);
  problem.goal->turn.reset();
  problem.goal->angle = {{problem.swimmer.joints[2].name, {0.4, 0.8, -0.6}}};
  const maneuver::Solution solution = solved(problem);
  expect_eigenvalues(problem, solution, dense_eigenvalues(problem, solution));
}

TEST(SecondOrder, where_the_shape_of_the_start_is_asked_for_is_that_of_the_transcription) {
  maneuver::Problem problem = in_space(24);
  problem.goal->turn.reset();
  problem.goal->shape_of_start = true;
  const maneuver::Solution solution = solved(problem);
  expect_eigenvalues(problem, solution, transcribed_eigenvalues(problem, solution));
}

TEST(SecondOrder, on_splines_is_that_of_the_transcription) {
  for (const maneuver::CostRule rule : {maneuver::CostRule::rectangle, maneuver::CostRule::trapezoid}) {
    maneuver::Problem problem = in_space(24);
    problem.control = maneuver::ControlKind::spline;
    problem.points = 6;
    problem.rule = rule;
    const maneuver::Solution solution = solved(problem);
    expect_eigenvalues(problem, solution, transcribed_eigenvalues(problem, solution));
  }
}

TEST(SecondOrder, on_splines_in_the_plane_is_a_saddle_out_of_it) {
  maneuver::Problem problem = in_the_plane(24);
  problem.control = maneuver::ControlKind::spline;
  problem.points = 7;
  const maneuver::Solution solution = solved(problem);
  expect_eigenvalues(problem, solution, transcribed_eigenvalues(problem, solution));
  const maneuver::Problem free = with_all_axes(problem);
  const VectorXd values = transcribed_eigenvalues(free, solution);
  EXPECT_LT(values[0], 0.0);
  expect_eigenvalues(free, solution, values);
}

// As many points as nodes leave moments as free as nodes do.
TEST(SecondOrder, of_as_many_points_as_nodes_is_that_of_moments_at_the_nodes) {
  maneuver::Problem of_one_body = of_mixed_joints(20);  // a led one, whose turn curves the goal
  of_one_body.goal->turn.reset();
  of_one_body.goal->rotation[of_one_body.swimmer.joints[1].child] = Vector3d(0.4, 0.5, -0.3);
  for (const maneuver::Problem& problem : {in_the_plane(20), of_mixed_joints(20), of_one_body}) {
    const maneuver::Solution solution = solved(problem);
    for (const maneuver::Problem& by_nodes : {problem, with_all_axes(problem)}) {
      maneuver::Problem on_splines = by_nodes;
      on_splines.control = maneuver::ControlKind::spline;
      on_splines.points = problem.steps + 1;
      const SecondOrder expected = second_order_of(by_nodes, solution), found = second_order_of(on_splines, solution);
      ASSERT_TRUE(expected.negative_eigenvalues.has_value());
      EXPECT_NEAR(found.smallest_eigenvalue / expected.smallest_eigenvalue, 1.0, tolerance(1e-6));
      EXPECT_EQ(found.positive, expected.positive);
      EXPECT_EQ(found.negative_eigenvalues, expected.negative_eigenvalues);
    }
  }
}

// Half of what the unlimited maneuver swings and a little less than what it takes: both limits pull.
TEST(SecondOrder, with_limits_that_pull_is_that_of_differences_of_the_gradient) {
  maneuver::Problem problem = in_the_plane(24);
  problem.goal->turn = Vector3d(0, 0, 0.15);
  problem.goal->move = {0.1, std::nullopt, std::nullopt};
  const maneuver::Solution unlimited = solved(problem);
  double swing = 0.0, torque = 0.0;
  for (const auto& R : unlimited.rotation) swing = std::max(swing, lie::rotation_angle(R[0].transpose() * R[1]));
  for (const auto& u : unlimited.control) torque = std::max({torque, u[0].norm(), u[1].norm()});
  problem.limits.swing["front"] = 0.9 * swing;
  problem.limits.torque = 0.95 * torque;
  const model::System system(problem.swimmer);
  search::Solver solver(system, problem, unlimited);  // on to the limited minimum next to it
  ASSERT_EQ(solver.solve().termination, optimizer::Termination::converged);
  const maneuver::Solution solution = solver.solution();
  int swings = 0, torques = 0;
  for (const maneuver::LimitMultiplier& own : solution.limit_multipliers)
    for (double multiplier : own.multiplier)
      if (multiplier > 0.0) ++(own.key == "limits.torque" ? torques : swings);
  EXPECT_GT(swings, 0);
  EXPECT_GT(torques, 0);
  const VectorXd values = dense_eigenvalues(problem, solution);
  const SecondOrder found = second_order_of(problem, solution);
  EXPECT_NEAR(found.smallest_eigenvalue, values[0], tolerance(1e-4) * std::abs(values[0])) << "kept by a penalty";
  EXPECT_EQ(found.positive, values[0] > 1e-6);
  EXPECT_GT(std::abs(second_order_of(with_no_limits(problem), unlimited).smallest_eigenvalue - values[0]), 5e-4);
}

// The paper's translation: a minimum in the plane, a saddle in space with as many directions of descent as an independent
// program found.
maneuver::Problem of_free_duration(maneuver::Problem problem, double time_weight) {
  problem.duration.free = true;
  problem.duration.min = 0.1 * problem.duration.value;
  problem.duration.max = 10.0 * problem.duration.value;
  problem.time_weight = time_weight;
  return problem;
}

// Equation 6.16: without limits on moments and rates the duration's eigenvalue 3/2 stands beside those of the given one.
TEST(SecondOrder, of_a_free_duration_without_limits_is_that_of_the_best_duration) {
  const maneuver::Problem given = in_the_plane(20);
  const maneuver::Problem free = of_free_duration(given, 3.0 * solved(given).cost / given.duration.value);
  const maneuver::Solution solution = solved(free);
  maneuver::Problem best = given;
  best.duration.value = solution.time.back();
  const SecondOrder with = second_order_of(free, solution), without = second_order_of(best, solution);
  EXPECT_TRUE(with.positive);
  EXPECT_NEAR(with.smallest_eigenvalue, std::min(without.smallest_eigenvalue, 1.5), 2e-3);
}

// The least cost as a function of the logarithm of the duration: its second derivative by differences of solved problems,
// and by the form, where the other inputs make the best of a unit of τ.
void expect_curvature_of_least_cost(const maneuver::Problem& free, const maneuver::Solution& solution,
                                    double accuracy = 0.01) {
  const model::System system(free.swimmer);
  const StoredMotion motion(system, free, solution);
  ASSERT_FALSE(evidence::duration_holds(motion));
  const auto least_cost = [&](double tau) {  // of the minimum that this one becomes
    maneuver::Problem problem = free;
    problem.duration = {};
    problem.duration.value = solution.time.back() * std::exp(tau);
    search::Solver solver(system, problem, solution);
    EXPECT_EQ(solver.solve().termination, optimizer::Termination::converged);
    return solver.cost();
  };
  const double step = 0.005, here = least_cost(0.0);
  EXPECT_NEAR(here, solution.cost, 1e-7 * here);
  const double expected = (least_cost(step) + least_cost(-step) - 2.0 * here) / (step * step);

  const auto chain_of = [&](const StoredMotion& stored) {
    auto effort = optimality::effort_chain(stored, evidence::check_balance(stored).scale);
    const auto bounds = optimality::pulling_bounds(stored);
    return optimality::lagrangian_chain(stored, *effort, optimality::costates_by_least_squares(stored, *effort, bounds),
                                        bounds);
  };
  const optimality::Chain chain = chain_of(motion);
  maneuver::Problem without_costs = free;
  without_costs.cost_weights = {};  // whose states follow the duration's
  const Eigen::Index duration = chain_of(StoredMotion(system, without_costs, solution)).end_form.rows() - 1;
  optimality::ChainSolver solver(chain, 1e4 * solution.cost);
  EXPECT_EQ(solver.factor(0.0), 0);
  optimality::ChainGradient pull;
  for (const optimality::ChainStage& stage : chain.stage) pull.by_input.emplace_back(VectorXd::Zero(stage.B.cols()));
  pull.by_input[0][0] = 1.0;
  const double unit = chain.stage[0].B(duration, 0);  // τ by the first input
  const double found = -1.0 / (solver.solve(pull)[0][0] * unit * unit);
  EXPECT_NEAR(found / expected, 1.0, tolerance(accuracy));
}

// A start in motion has more momentum by impulses in longer steps: of the whole, or of joints alone; what joints at rest leave, too.
TEST(SecondOrder, of_a_free_duration_from_a_start_in_motion_is_that_of_the_least_cost_by_the_duration) {
  const auto solved_in_free_time = [](maneuver::Problem problem) {
    problem.search.starts = 2;
    const model::System system(problem.swimmer);
    return search::solve(system, problem, search::SolveOptions()).front();
  };
  for (const char* name : {"drifting", "drifting_to_rest", "joints"}) {
    SCOPED_TRACE(name);
    const bool joints = std::string(name) == "joints";
    maneuver::Problem problem =
        joints ? in_the_plane(40) : file::read_problem(LAMPREY_SOURCE_DIR "/examples/" + std::string(name) + ".toml");
    if (joints) bend_at_start(problem, {Vector3d(0.0, 0.0, 0.4), Vector3d(0.0, 0.0, -0.7)});
    problem.steps = 60;
    problem.limits = {};
    const maneuver::Solution given = solved_in_free_time(problem);
    const maneuver::Problem free = of_free_duration(problem, 0.7 * given.cost / problem.duration.value);
    expect_curvature_of_least_cost(free, solved_in_free_time(free));
  }
  // Joints' rates at the start are given: powers there fall otherwise with the duration than those of steps.
  const auto with = [](double maneuver::CostWeights::*weight, double value) {
    maneuver::CostWeights weights;
    weights.*weight = value;
    return weights;
  };
  for (const maneuver::CostWeights& weights :
       {with(&maneuver::CostWeights::angular_velocity, 1.0), with(&maneuver::CostWeights::smoothness, 0.1),
        with(&maneuver::CostWeights::power, 1.0), with(&maneuver::CostWeights::work, 1.0),
        with(&maneuver::CostWeights::transport, 0.3)}) {
    maneuver::Problem problem = in_the_plane(8);
    bend_at_start(problem, {Vector3d(0.0, 0.0, 3.0), Vector3d(0.0, 0.0, -2.0)});
    problem.goal->move = {};
    const maneuver::Solution given = solved_in_free_time(problem);
    problem.cost_weights = weights;
    const maneuver::Problem free = of_free_duration(problem, 0.7 * given.cost / problem.duration.value);
    expect_curvature_of_least_cost(free, solved_in_free_time(free), 1e-4);
  }
}

TEST(SecondOrder, of_a_free_duration_with_limits_is_that_of_the_least_cost_by_the_duration) {
  maneuver::Problem given = in_the_plane(20);
  given.search.starts = 3;
  const double time_weight = 2.0 * solved(given).cost / given.duration.value;
  double largest = 0.0;
  for (const auto& moments : solved(of_free_duration(given, time_weight)).control)
    for (const Vector3d& moment : moments) largest = std::max(largest, moment.norm());
  given.limits.torque = 0.7 * largest;
  const maneuver::Problem free = of_free_duration(given, time_weight);
  const maneuver::Solution solution = solved(free);
  const model::System system(free.swimmer);
  ASSERT_FALSE(optimality::pulling_bounds(StoredMotion(system, free, solution)).empty());
  expect_curvature_of_least_cost(free, solution);
}

TEST(SecondOrder, of_the_papers_translation_counts_fourteen_directions_out_of_the_plane) {
  maneuver::Problem problem = chain_problem(40, 1.0);
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move = {2.0, std::nullopt, std::nullopt};
  problem.search.starts = 8;
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  const model::System system(problem.swimmer);
  const study::Answer answer = study::answer(system, problem, {});
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
  ASSERT_TRUE(answer.certificate.all_axes.has_value());
  EXPECT_LE(answer.certificate.all_axes->kkt, tolerance(1e-10));
  EXPECT_EQ(answer.certificate.all_axes->second_order.negative_eigenvalues, 14);
  EXPECT_FALSE(answer.certificate.all_axes->second_order.positive);
}

// Two bodies on one axis: nothing curves but the steps themselves.
TEST(SecondOrder, of_a_turn_about_one_axis_is_pure_effort_to_second_order_in_the_step) {
  maneuver::Problem problem;
  problem.swimmer.density = 0.0;
  for (const char* name : {"body", "head"}) {
    model::BodyDescription body;
    body.name = name;
    body.semi_axes = Vector3d(0.3, 0.2, 0.1);
    body.mass = 2.0;
    problem.swimmer.bodies.push_back(body);
  }
  model::JointDescription hinge;
  hinge.name = "neck";
  hinge.kind = model::JointKind::hinge;
  hinge.parent = "body";
  hinge.child = "head";
  hinge.parent_offset = Vector3d(0, 0, 0.15);
  hinge.child_offset = Vector3d(0, 0, -0.15);
  hinge.axis = Vector3d(0, 0, 1);
  problem.swimmer.joints.push_back(hinge);
  problem.start.rotation.assign(2, Vector3d::Zero());
  problem.start.angular_velocity.assign(2, Vector3d::Zero());
  problem.goal = maneuver::Goal{};
  problem.goal->rotation["head"] = Vector3d(0, 0, 0.6);
  std::vector<double> off;
  for (int count : {20, 40}) {
    problem.steps = count;
    off.push_back(1.0 - second_order_of(problem, solved(problem)).smallest_eigenvalue);
  }
  EXPECT_LE(std::abs(off[1]), 0.02);
  EXPECT_NEAR(std::log2(off[0] / off[1]), 2.0, 0.2);
}

TEST(SecondOrder, does_not_depend_on_the_frame) {
  maneuver::Problem problem = in_space(24);
  problem.goal->move = {};
  const maneuver::Solution solution = solved(problem);
  const Matrix3d turn = lie::exp(Vector3d(0.4, -1.1, 0.7));
  maneuver::Problem turned = problem;
  maneuver::Solution moved = solution;
  for (std::size_t i = 0; i < 3; ++i) {
    const Matrix3d start = lie::exp(problem.start.rotation[i]);
    turned.start.rotation[i] = lie::log(turn * start);
    turned.goal->rotation[problem.swimmer.bodies[i].name] = lie::log(turn * lie::exp(*problem.goal->turn) * start);
  }
  turned.goal->turn.reset();
  turned.start.position = Vector3d(3.0, -2.0, 1.0);
  for (std::size_t k = 0; k < moved.rotation.size(); ++k) {
    for (Matrix3d& R : moved.rotation[k]) R = turn * R;
    moved.position[k] = turned.start.position + turn * (solution.position[k] - problem.start.position);
  }
  const SecondOrder here = second_order_of(problem, solution), there = second_order_of(turned, moved);
  EXPECT_NEAR(here.smallest_eigenvalue, there.smallest_eigenvalue, tolerance(1e-7));
  EXPECT_NE(here.smallest_eigenvalue, there.smallest_eigenvalue) << "bit-equal: the same path ran twice";
}

}  // namespace
}  // namespace lamprey::tests
