// Starts with momentum by the program's own solver: its answers are Ipopt's, momentum stays what it was, limits are kept, and a Solver
// goes on from states that drift.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "maneuver/feedback.hpp"
#include "maneuver/simulate.hpp"
#include "mechanics/continuous.hpp"
#include "model/input_error.hpp"
#include "search/first_motion.hpp"
#include "search/solve.hpp"
#include "search/solver.hpp"
#include "shape/reach.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using maneuver::Problem;
using maneuver::Solution;
using optimizer::Termination;

Problem drifting(const std::string& path, int steps) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + path);
  problem.steps = steps;
  problem.search.starts = 1;
  return problem;
}
Problem drifting_turn() { return drifting("/bench/problems/drifting_turn.toml", 80); }
Problem drifting_in_space() { return drifting("/examples/drifting.toml", 100); }

study::Answer answer_to_drift(const Problem& problem, search::Backend solver = search::Backend::automatic) {
  search::SolveOptions options;
  options.refinement = false;
  options.solver = solver;
  return study::answer(model::System(problem.swimmer), problem, options);
}

void expect_drift_proved(const study::Answer& answer) {
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.goal_error, 1e-10);
  EXPECT_LE(answer.certificate.kkt, 1e-9);
  EXPECT_LE(answer.certificate.momentum_drift, 1e-11);
  EXPECT_LE(answer.certificate.iterates_momentum, 1e-11);
}

// In a plane with one joint, with two of them within limits, in space within limits and without.
TEST(DriftingSwimmer, has_one_answer_by_both_solvers) {
  Problem free_in_space = drifting_in_space();
  free_in_space.limits = {};
  for (const Problem& problem : {drifting_turn(), drifting("/bench/problems/drifting_within_limits.toml", 80),
                                 drifting_in_space(), free_in_space}) {
    const study::Answer own = answer_to_drift(problem, search::Backend::newton);
    expect_drift_proved(own);
    const model::System system(problem.swimmer);
    search::SolveOptions options;
    options.refinement = false;
    options.solver = search::Backend::ipopt;
    options.first = search::first_motion(system, problem, own.solution);
    const study::Answer other = study::answer(system, problem, options);
    EXPECT_EQ(other.solution.status, maneuver::Status::optimal) << other.solution.message;
    EXPECT_NEAR(other.solution.cost / own.solution.cost, 1.0, 1e-8);
    EXPECT_GT(own.solution.cost, 0.0);
  }
}

TEST(DriftingSwimmer, keeps_limits_that_hold) {
  for (const Problem& problem : {drifting("/bench/problems/drifting_within_limits.toml", 80), drifting_in_space()}) {
    const study::Answer answer = answer_to_drift(problem);
    expect_drift_proved(answer);
    EXPECT_EQ(answer.solution.solver.name, "lamprey newton");
    Problem free = problem;
    free.limits = {};
    EXPECT_GT(answer.solution.cost, 1.001 * answer_to_drift(free).solution.cost) << "limits hold nowhere";
  }
}

// No joint moves at the end: all bodies turn alike, and what is left of the momentum is what the whole carries.
TEST(DriftingSwimmer, ends_with_still_joints_where_it_is_asked_to) {
  for (Problem problem : {drifting("/examples/drifting_to_rest.toml", 100), drifting_in_space(), drifting_turn()}) {
    problem.goal->rest = false;
    problem.goal->joints_rest = true;
    const study::Answer answer = answer_to_drift(problem);
    expect_drift_proved(answer);
    EXPECT_LE(answer.certificate.rest_error, 1e-12);
    const Solution& solution = answer.solution;
    const Vector3d whole = solution.rotation.back()[0] * solution.angular_velocity.back()[0];
    double fastest = 0.0;
    for (const auto& node : solution.angular_velocity)
      for (const Vector3d& own : node) fastest = std::max(fastest, own.norm());
    for (std::size_t i = 1; i < solution.rotation.back().size(); ++i) {
      const Vector3d own = solution.rotation.back()[i] * solution.angular_velocity.back()[i];
      EXPECT_LE((own - whole).norm(), 1e-10 * fastest);
    }
    Problem free = problem;
    free.goal->joints_rest = false;
    EXPECT_GT(solution.cost, 1.01 * answer_to_drift(free).solution.cost) << "joints end still by themselves";
  }
}

TEST(DriftingSwimmer, of_no_momentum_ends_at_rest_with_its_joints) {
  Problem problem =
      drifting("/bench/problems/drifting_within_limits.toml", 80);  // a single hinge turns nowhere from rest
  problem.limits = {};
  problem.start.linear_velocity.setZero();
  problem.goal->rest = true;
  const study::Answer at_rest = answer_to_drift(problem);
  problem.goal->rest = false;
  problem.goal->joints_rest = true;
  const study::Answer still = answer_to_drift(problem);
  expect_drift_proved(still);
  EXPECT_EQ(still.solution.cost, at_rest.solution.cost);
}

TEST(DriftingSwimmer, whose_joints_end_still_is_not_given_to_ipopt) {
  Problem problem = drifting_turn();
  problem.goal->joints_rest = true;
  for (const search::Backend backend : {search::Backend::ipopt, search::Backend::both}) {
    try {
      answer_to_drift(problem, backend);
      FAIL() << "taken";
    } catch (const model::InputError& error) {
      EXPECT_EQ(error.key, "goal.rest");
    }
  }
}

// Where no first guess arrives neither: its transcription knows of rest alone, which momentum forbids.
TEST(DriftingSwimmer, whose_joints_end_still_keeps_its_own_miss_where_nothing_arrives) {
  Problem problem = drifting("/examples/drifting_to_rest.toml", 60);
  problem.limits.torque = 0.05;
  const study::Answer answer = answer_to_drift(problem);
  EXPECT_NE(answer.solution.status, maneuver::Status::optimal);
  EXPECT_EQ(answer.solution.solver.name, "lamprey newton");
  EXPECT_LE(answer.certificate.equation_residual, 1e-9);
  EXPECT_NE(answer.solution.message.find("limits.torque"), std::string::npos) << answer.solution.message;
}

TEST(DriftingSwimmer, glides_on_where_its_joints_are_still_by_themselves) {
  Problem problem = drifting("/examples/drifting_to_rest.toml", 60);
  problem.limits = {};
  problem.goal->turn.reset();
  problem.goal->move = {1.2, std::nullopt, std::nullopt};
  const study::Answer answer = answer_to_drift(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.rest_error, 1e-12);
  EXPECT_LT(answer.solution.cost, 1e-20);
  EXPECT_EQ(answer.solution.solver.name, "without moments");
}

// What goes to and fro gets nowhere, but where its momentum takes it.
TEST(DriftingSwimmer, of_a_single_angle_that_cannot_turn_round_may_end_elsewhere_in_its_first_shape) {
  Problem problem = drifting_turn();
  problem.limits.angle[problem.swimmer.joints[0].name] = {{-1.0, 1.0}};
  expect_drift_proved(answer_to_drift(problem));
  problem.start.linear_velocity.setZero();
  EXPECT_EQ(answer_to_drift(problem).solution.status, maneuver::Status::infeasible);
}

// Out of its plane neither moments nor momentum take a planar swimmer; where momentum leaves the plane they may.
TEST(DriftingSwimmer, stays_in_the_plane_of_its_momentum) {
  Problem problem = drifting_turn();
  problem.goal->move = {std::nullopt, std::nullopt, 0.1};
  const study::Answer answer = answer_to_drift(problem);
  EXPECT_EQ(answer.solution.status, maneuver::Status::infeasible);
  EXPECT_NE(answer.solution.message.find("in the plane normal to e₃"), std::string::npos) << answer.solution.message;
  problem.goal->turn.reset();
  problem.goal->move = {std::nullopt, std::nullopt, 0.06};
  problem.start.linear_velocity[2] = 0.02;
  EXPECT_EQ(answer_to_drift(problem).solution.status, maneuver::Status::optimal);
}

// Where the goal is where it gets by itself, the answer is to do nothing; and next to it to do next to nothing.
TEST(DriftingSwimmer, does_nothing_where_it_gets_to_its_goal_by_itself) {
  for (Problem problem : {drifting_turn(), drifting_in_space()}) {
    problem.limits = {};
    const model::System system(problem.swimmer);
    const Solution coast =
        maneuver::simulate(system, problem, maneuver::no_control(system), maneuver::SimulateOptions());
    const std::string root = system.body(0).name;
    problem.goal->turn.reset();
    problem.goal->rotation.clear();
    double dearer = 0.0;
    for (const double beside : {1e-4, 1e-6, 0.0}) {
      problem.goal->rotation[root] = lie::log(coast.rotation.back()[0] * lie::exp(Vector3d(0.0, 0.0, beside)));
      const study::Answer answer = answer_to_drift(problem);
      EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << beside << answer.solution.message;
      EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << beside << answer.solution.message;
      if (dearer > 0.0 && beside > 0.0) {
        EXPECT_NEAR(dearer / answer.solution.cost, 1e4, 1e2);  // as the square
      }
      dearer = answer.solution.cost;
    }
    EXPECT_LT(dearer, 1e-20);
  }
  // straight ahead
  Problem straight = drifting_turn();
  straight.goal->turn.reset();
  straight.goal->move = {1.2, std::nullopt, std::nullopt};
  const study::Answer answer = answer_to_drift(straight);
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_LT(answer.solution.cost, 1e-20);
  EXPECT_LE(answer.certificate.momentum_drift, 1e-11);
}

TEST(DriftingSwimmer, goes_by_every_scheme_of_one_stage) {
  for (const maneuver::Scheme scheme : {maneuver::Scheme::midpoint, maneuver::Scheme::paper}) {
    Problem problem = drifting_turn();
    problem.scheme = scheme;
    expect_drift_proved(answer_to_drift(problem));
  }
}

TEST(DriftingSwimmer, may_have_joints_that_nothing_drives) {
  for (const bool still : {false, true}) {
    Problem problem = drifting("/bench/problems/drifting_within_limits.toml", 200);
    problem.goal->joints_rest = still;
    problem.limits = {};
    problem.goal->turn.reset();
    problem.goal->rotation[problem.swimmer.bodies[0].name] = Vector3d(0.0, 0.0, 0.4);
    problem.swimmer.joints[1].actuated = false;
    problem.swimmer.joints[1].stiffness = 0.5;
    problem.swimmer.joints[1].damping = 0.05;
    const study::Answer answer = answer_to_drift(problem);
    expect_drift_proved(answer);
    EXPECT_EQ(answer.solution.solver.name, "lamprey newton");
  }
}

TEST(DriftingSwimmer, answers_to_work_and_to_coupled_inertia) {
  for (const bool still : {false, true}) {
    Problem problem = drifting_in_space();
    problem.goal->joints_rest = still;
    problem.limits = {};
    problem.cost_weights.work = 0.5;
    Eigen::Matrix3d coupling = Eigen::Matrix3d::Zero();
    coupling(1, 2) = 0.3;
    problem.swimmer.bodies[0].coupling_matrix = coupling;
    const study::Answer answer = answer_to_drift(problem);
    expect_drift_proved(answer);
  }
}

struct SolvedDrift {
  Problem problem;
  model::System system;
  Solution solution;
  explicit SolvedDrift(const Problem& of)
      : problem(of), system(of.swimmer), solution(search::solve(system, of, search::SolveOptions()).front()) {}
};

mechanics::SpatialMomentum carried(const model::System& system, const integrator::State& state) {
  return mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
}

// Bellman: what is left of an optimal motion is optimal, to what steps of another length make of it; and momentum is what it was.
TEST(SolverThatDrifts, goes_on_with_the_rest_of_its_answer) {
  const auto missed = [](int steps) {
    Problem problem = drifting_in_space();
    problem.limits = {};
    problem.steps = steps;
    const SolvedDrift solved(problem);
    search::Solver solver(solved.system, solved.problem, solved.solution);
    EXPECT_TRUE(solver.answers());
    const std::size_t from = static_cast<std::size_t>(steps) / 3;
    double rest = 0.0;
    for (std::size_t k = from; k + 1 < solved.solution.time.size(); ++k)
      for (std::size_t node : {k, k + 1})
        for (const Vector3d& moment : solved.solution.control[node])
          rest += 0.25 * (solved.solution.time[k + 1] - solved.solution.time[k]) * moment.squaredNorm();
    solver.advance(solved.solution.time[from]);
    const auto now = carried(solved.system, solver.maneuver().start),
               before = carried(solved.system, maneuver::start_state(solved.system, problem.start));
    const double scale = maneuver::bodies_momentum(solved.system, solver.maneuver().start);
    EXPECT_GT(before.angular.norm(), 1e-3 * scale);
    EXPECT_LT((now.linear - before.linear).norm(), 1e-12 * scale / solved.system.length_unit());
    EXPECT_LT((now.angular - before.angular).norm(), 1e-12 * scale);
    const optimizer::Outcome outcome = solver.solve();
    EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
    EXPECT_LE(outcome.iterations, 10);
    return std::abs(solver.cost() / rest - 1.0);
  };
  const double coarse = missed(90), fine = missed(180);
  EXPECT_LT(coarse, 0.05);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.5) << coarse << " " << fine;
}

// Pushed on the way: the plan made anew is the optimum of the problem that begins so.
TEST(SolverThatDrifts, takes_a_start_as_it_is_seen) {
  const SolvedDrift solved(drifting_in_space());
  search::Solver solver(solved.system, solved.problem, solved.solution);
  Problem pushed = solved.problem;
  pushed.start.linear_velocity += Vector3d(0.01, -0.005, 0.01);
  pushed.start.angular_velocity[0] += Vector3d(0.01, 0.0, -0.01);
  solver.set_start(maneuver::start_as_seen(solved.system, pushed.start));
  const optimizer::Outcome outcome = solver.solve();
  ASSERT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  certificate::Options options;
  options.replay = false;
  const certificate::Certificate proof = certificate::certify(solved.system, pushed, solver.solution(), options);
  EXPECT_LT(proof.goal_error, 1e-10);
  EXPECT_LT(proof.equation_residual, 1e-10);
  EXPECT_LT(proof.kkt, 1e-8);
  EXPECT_LT(proof.momentum_drift, 1e-11);
  EXPECT_GT(std::abs(solver.cost() / solved.solution.cost - 1.0), 1e-3);
  EXPECT_FALSE(solver.feedback().gain.empty());
}

// From momentum to rest where the goal is, and on to momentum again.
TEST(SolverThatDrifts, may_come_to_rest_and_drift_again) {
  Problem problem = drifting_in_space();
  problem.limits = {};
  const SolvedDrift solved(problem);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  maneuver::Start still = solved.problem.start;
  still.linear_velocity.setZero();
  for (Vector3d& rate : still.angular_velocity) rate.setZero();
  maneuver::Start there = still;
  for (Vector3d& rotation : there.rotation) rotation.setZero();
  for (int round = 0; round < 2; ++round) {
    solver.set_start(maneuver::start_as_seen(solved.system, there));
    ASSERT_EQ(solver.solve().termination, Termination::converged) << solver.solve().reason;
    EXPECT_EQ(solver.cost(), 0.0) << "rest is where the goal is";
    solver.set_start(maneuver::start_as_seen(solved.system, solved.problem.start));
    ASSERT_EQ(solver.solve().termination, Termination::converged) << solver.solve().reason;
    EXPECT_GT(solver.cost(), 0.1);
    const certificate::Certificate proof =
        certificate::certify(solved.system, solved.problem, solver.solution(), certificate::Options());
    EXPECT_LT(proof.kkt, 1e-8);
    EXPECT_LT(proof.momentum_drift, 1e-11);
    solver.set_start(maneuver::start_as_seen(solved.system, still));
    ASSERT_EQ(solver.solve().termination, Termination::converged) << solver.solve().reason;
    EXPECT_GT(solver.cost(), 0.1);
  }
}

TEST(SolverThatDrifts, goes_on_from_where_it_was_pushed) {
  Problem problem = drifting_in_space();
  problem.limits = {};
  const SolvedDrift solved(problem);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  solver.advance(0.3);
  maneuver::Start pushed;
  const integrator::State& start = solver.maneuver().start;
  const Eigen::VectorXd velocity = integrator::velocity_of_state(solved.system, start);
  for (const Eigen::Matrix3d& R : start.rotation) pushed.rotation.push_back(lie::log(R));
  pushed.position = start.position;
  pushed.angular_velocity = mechanics::angular_velocities(solved.system, start.rotation, velocity);
  pushed.linear_velocity = velocity.tail<3>() + Vector3d(0.0, 0.02, 0.0);
  solver.set_start(maneuver::start_as_seen(solved.system, pushed));
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  solver.advance(0.2);
  ASSERT_EQ(solver.solve().termination, Termination::converged);
  const auto now = carried(solved.system, solver.maneuver().start),
             before = carried(solved.system, maneuver::start_as_seen(solved.system, pushed));
  EXPECT_LT((now.angular - before.angular).norm() + (now.linear - before.linear).norm(),
            1e-11 * maneuver::bodies_momentum(solved.system, start));
}

// Turns about e₃, displacements along e₁ and e₂.
Eigen::MatrixXd in_the_plane() {
  Eigen::MatrixXd pose = Eigen::MatrixXd::Zero(6, 3);
  pose(2, 0) = pose(3, 1) = pose(4, 2) = 1.0;
  return pose;
}

std::string refused_start(search::Solver& solver, const integrator::State& start) {
  try {
    solver.set_start(start);
  } catch (const model::InputError& error) {
    EXPECT_EQ(error.key, "start");
    return error.message;
  }
  return "";
}

TEST(SolverThatDrifts, says_which_momentum_it_does_not_take) {
  Problem problem = drifting_turn();
  const SolvedDrift solved(problem);
  search::Solver solver(solved.system, solved.problem, solved.solution);
  problem.start.linear_velocity = Vector3d(0.3, 0.05, 0.0);
  EXPECT_EQ(refused_start(solver, maneuver::start_as_seen(solved.system, problem.start)), "");
  problem.start.linear_velocity[2] = 1e-3;  // as measurements err
  problem.start.angular_velocity[0] = Vector3d(1e-3, 0.0, 0.1);
  EXPECT_EQ(refused_start(solver, maneuver::start_as_seen(solved.system, problem.start)), "");
  EXPECT_LT(shape::momentum_beside(solved.system, solver.maneuver().start, in_the_plane()), 1e-12);
  EXPECT_EQ(solver.solve().termination, Termination::converged);
  problem.start.linear_velocity[2] = 0.2;
  EXPECT_NE(refused_start(solver, maneuver::start_as_seen(solved.system, problem.start)).find("out of the plane"),
            std::string::npos);
  Problem still = file::read_problem(LAMPREY_SOURCE_DIR "/examples/translation.toml");
  still.steps = 60;
  still.search.starts = 1;
  const SolvedDrift at_rest(still);
  search::Solver other(at_rest.system, at_rest.problem, at_rest.solution);
  still.start.linear_velocity = Vector3d(0.1, 0.0, 0.0);
  EXPECT_NE(refused_start(other, maneuver::start_as_seen(at_rest.system, still.start)).find("start_without_momentum"),
            std::string::npos);
}

}  // namespace
}  // namespace lamprey::tests
