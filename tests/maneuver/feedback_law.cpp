#include "maneuver/feedback.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "maneuver/followed.hpp"
#include "maneuver/motor_limits.hpp"
#include "maneuver/tracking.hpp"
#include "mechanics/joint_moments.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using integrator::Scheme;
using maneuver::FeedbackWeights;
using maneuver::Solution;

VectorXd end_deviation(const Plan& plan, const Solution& marched) {
  const int last = plan.problem.steps;
  return integrator::deviation(plan.system, node_state(plan.system, plan.solution, last),
                               node_state(plan.system, marched, static_cast<int>(marched.time.size()) - 1));
}

class FeedbackOfSchemes : public ::testing::TestWithParam<Scheme> {};

TEST_P(FeedbackOfSchemes, leaves_a_motion_alone_that_is_on_its_plan) {
  for (unsigned seed : {3U, 4U}) {
    Plan plan = tree_in_motion(seed, 4, GetParam(), 20, 0.4);
    plan.solution.feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
    EXPECT_GT(plan.solution.feedback.gain[10].norm(), 1.0) << "no gains to speak of";
    const Solution marched = follow(plan.system, plan.problem, plan.law());
    // between nodes, where stages lie, the path is as near as its cubics come
    const bool stages = !integrator::single_step(GetParam());
    EXPECT_LE(end_deviation(plan, marched).norm(), tolerance(stages ? 5e-6 : 1e-11)) << "seed " << seed;
    for (std::size_t k = 0; k < marched.control.size(); ++k)
      for (std::size_t j = 0; j < marched.control[k].size(); ++j)
        EXPECT_LE((marched.control[k][j] - plan.solution.control[k][j]).norm(), tolerance(stages ? 5e-4 : 1e-9));
  }
}

maneuver::Problem with_weak_motors(maneuver::Problem problem) {
  problem.limits.torque = 0.6;
  problem.limits.torque_component = 0.4;
  return problem;
}

TEST_P(FeedbackOfSchemes, of_weak_motors_gives_no_more_than_these_and_tells_what_acted) {
  for (unsigned seed : {3U, 4U}) {
    Plan plan = tree_in_motion(seed, 4, GetParam(), 20, 0.4);
    plan.solution.feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
    maneuver::Problem problem = with_weak_motors(plan.problem);
    problem.start = maneuver::turned_start(plan.system, problem.start, 0.1, seed,
                                           maneuver::answered_turns(plan.system, plan.solution.feedback));
    const maneuver::MotorLimits motors(plan.system, problem);
    int cut = 0;
    std::vector<mechanics::Moments> acted;
    const integrator::MotorFunction given = [&](const mechanics::Moments& asked) {
      acted.push_back(motors.within(asked));
      cut += acted.back() == asked ? 0 : 1;
      EXPECT_LE(mechanics::along_actuation(plan.system, acted.back()).lpNorm<Eigen::Infinity>(),
                0.4 + tolerance(1e-12));
      return acted.back();
    };
    const Solution marched = follow(plan.system, problem, plan.law(), false, given);
    EXPECT_GT(cut, 5);
    for (const auto& moments : marched.control)
      for (const Vector3d& moment : moments) EXPECT_LE(moment.norm(), 0.6 + tolerance(1e-12));
    if (!integrator::single_step(GetParam())) continue;
    const std::size_t before = acted.size() - marched.time.size();  // asked for node 0 only to be stored
    const Solution again = maneuver::simulate(
        plan.system, problem,
        [&](double t) { return acted[before + static_cast<std::size_t>(std::lround(t / problem.time_step()))]; },
        maneuver::SimulateOptions{});
    EXPECT_LE((again.position.back() - marched.position.back()).norm(), tolerance(1e-10));
    for (std::size_t i = 0; i < again.rotation.back().size(); ++i)
      EXPECT_LE((again.rotation.back()[i] - marched.rotation.back()[i]).norm(), tolerance(1e-10));
    for (std::size_t k = 0; k < again.control.size(); ++k)
      for (std::size_t j = 0; j < again.control[k].size(); ++j)
        EXPECT_LE((again.control[k][j] - marched.control[k][j]).norm(), tolerance(1e-9));
  }
}

TEST(MotorLimits, leave_alone_what_they_allow_and_cut_the_rest_once) {
  const Plan plan = tree_in_motion(3, 4, Scheme::trapezoid, 4, 0.4);
  const maneuver::MotorLimits motors(plan.system, with_weak_motors(plan.problem));
  const maneuver::MotorLimits none(plan.system, plan.problem);
  EXPECT_TRUE(motors.any());
  EXPECT_FALSE(none.any());
  Random random(5);
  for (int n = 0; n < 50; ++n) {
    mechanics::Moments asked;
    for (int j = 0; j < plan.system.joint_count(); ++j) asked.push_back(random.vector(n < 25 ? 0.1 : 2.0));
    asked = integrator::exerted(plan.system, asked);
    const mechanics::Moments once = motors.within(asked);
    EXPECT_EQ(none.within(asked), asked);
    for (std::size_t j = 0; j < once.size(); ++j) {
      const Eigen::MatrixXd& actuation = plan.system.joint(static_cast<int>(j)).actuation;
      const VectorXd along = actuation.transpose() * asked[j];
      const bool allowed = asked[j].norm() <= 0.6 && (along.size() == 0 || along.lpNorm<Eigen::Infinity>() <= 0.4);
      EXPECT_EQ(once[j] == asked[j], allowed);
      EXPECT_LE((motors.within(once)[j] - once[j]).norm(), tolerance(1e-15));
      EXPECT_GE(once[j].dot(asked[j]), 0.0);
    }
  }
}

// One step from node k, moments of the plan plus du at its beginning, running to du_next at its end.
VectorXd step_from(const Plan& plan, int k, const VectorXd& off, const VectorXd& du, const VectorXd& du_next) {
  maneuver::Problem problem = plan.problem;
  const double begin = plan.time(k), h = plan.time(k + 1) - begin;
  problem.start = start_at(plan.system, deviated(plan.system, node_state(plan.system, plan.solution, k), off));
  problem.steps = 1;
  problem.duration.value = h;
  const Solution reached = maneuver::simulate(
      plan.system, problem,
      [&](double t) {
        mechanics::Moments u = plan.control(begin + t);
        const VectorXd added = (1.0 - t / h) * du + t / h * du_next;
        Eigen::Index column = 0;
        for (int j = 0; j < plan.system.joint_count(); ++j) {
          const auto& actuation = plan.system.joint(j).actuation;
          u[model::at(j)] += actuation * added.segment(column, actuation.cols());
          column += actuation.cols();
        }
        return u;
      },
      maneuver::SimulateOptions{});
  return integrator::deviation(plan.system, node_state(plan.system, plan.solution, k + 1),
                               node_state(plan.system, reached, 1));
}

// By central differences: deviation at node k + 1 by that at node k and by what moments at both nodes add.
struct StepMap {
  MatrixXd A, B, B_next;
};

StepMap step_map(const Plan& plan, int k) {
  constexpr double step = 2e-5;
  const int states = 2 * plan.system.velocity_count(), controls = plan.system.control_count();
  const VectorXd still = VectorXd::Zero(states), none = VectorXd::Zero(controls);
  StepMap map{MatrixXd(states, states), MatrixXd(states, controls), MatrixXd(states, controls)};
  const auto column = [&](const auto& f) { return VectorXd((f(step) - f(-step)) / (2.0 * step)); };
  for (int c = 0; c < states; ++c)
    map.A.col(c) = column([&](double t) { return step_from(plan, k, t * VectorXd::Unit(states, c), none, none); });
  for (int c = 0; c < controls; ++c) {
    map.B.col(c) = column([&](double t) { return step_from(plan, k, still, t * VectorXd::Unit(controls, c), none); });
    map.B_next.col(c) =
        column([&](double t) { return step_from(plan, k, still, none, t * VectorXd::Unit(controls, c)); });
  }
  return map;
}

// Cost of deviations at a node as chapter 11 states it, without its factor: all along, or at the end.
MatrixXd deviation_cost(const Plan& plan, int k, bool end, const FeedbackWeights& weights) {
  const int half = plan.system.velocity_count();
  double length = 0.0;
  for (const model::Body& body : plan.system.bodies()) length = std::max(length, body.semi_axes.maxCoeff());
  MatrixXd turns = MatrixXd::Zero(half - 3, half - 3);
  for (int i = 0; i < plan.system.body_count(); ++i) {
    const MatrixXd turn =
        mechanics::turn_by_freedoms(plan.system, plan.solution.rotation[static_cast<std::size_t>(k)], i);
    turns += turn.transpose() * turn;
  }
  MatrixXd cost = MatrixXd::Zero(2 * half, 2 * half);
  cost.topLeftCorner(half - 3, half - 3) = turns;
  cost.block<3, 3>(half - 3, half - 3) = Matrix3d::Identity() / (length * length);
  const double time = weights.rate * plan.problem.duration.value;
  if (end) cost.block(half, half, half - 3, half - 3) = time * time * turns;
  return cost;
}

double effort(const Plan& plan) {
  const double duration = plan.problem.duration.value;
  double sum = 0.0, inertia = 0.0;
  for (std::size_t k = 0; k < plan.solution.control.size(); ++k)
    for (const Vector3d& u : plan.solution.control[k])
      sum += plan.problem.time_step() * (k == 0 || k + 1 == plan.solution.control.size() ? 0.5 : 1.0) * u.squaredNorm();
  for (const model::Body& body : plan.system.bodies())
    inertia += body.inertia_matrix.trace() / 3.0 / plan.system.body_count();
  return sum + inertia * inertia / std::pow(duration, 3);
}

// All moments of a motion that starts off its plan, by one dense system and linear maps from differences, against what
// the gains answer along that very motion.
TEST_P(FeedbackOfSchemes, gains_are_the_optimal_answers_of_the_dense_problem) {
  const FeedbackWeights weights{.path = 0.3, .end = 0.1, .rate = 0.2};
  for (unsigned seed : {5U, 8U}) {
    const int steps = 8;
    Plan plan = tree_in_motion(seed, 3, GetParam(), steps, 0.4);
    const maneuver::Feedback feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution, weights);
    const int states = 2 * plan.system.velocity_count(), controls = plan.system.control_count();
    const int all = controls * (steps + 1);
    Random random(seed);
    VectorXd off(states);
    for (double& entry : off) entry = 0.1 * random.normal();
    const double scale = effort(plan), h = plan.problem.time_step();
    MatrixXd hessian = MatrixXd::Zero(all, all), by_moments = MatrixXd::Zero(states, all);
    VectorXd gradient = VectorXd::Zero(all);
    std::vector<MatrixXd> moved = {by_moments};
    std::vector<VectorXd> drift = {off};
    for (int k = 0; k < steps; ++k) {
      const StepMap map = step_map(plan, k);
      MatrixXd next = map.A * moved.back();
      next.middleCols(controls * k, controls) += map.B;
      next.middleCols(controls * (k + 1), controls) += map.B_next;
      moved.push_back(next);
      drift.push_back(map.A * drift.back());
    }
    for (int k = 0; k <= steps; ++k) {
      const double weight = k == 0 || k == steps ? 0.5 * h : h;
      MatrixXd cost = weight * scale / (plan.problem.duration.value * weights.path * weights.path) *
                      deviation_cost(plan, k, false, weights);
      if (k == steps) cost += scale / (weights.end * weights.end) * deviation_cost(plan, k, true, weights);
      const auto n = static_cast<std::size_t>(k);
      hessian += moved[n].transpose() * cost * moved[n];
      hessian.block(controls * k, controls * k, controls, controls).diagonal().array() += weight;
      gradient += moved[n].transpose() * cost * drift[n];
    }
    const VectorXd best = -hessian.ldlt().solve(gradient);
    const bool composed = !integrator::single_step(GetParam());  // then the last gain is that of the node before
    if (composed) {
      EXPECT_EQ(feedback.gain.back(), feedback.gain[static_cast<std::size_t>(steps - 1)]);
    }
    for (int k = 0; k <= (composed ? steps - 1 : steps); ++k) {
      const auto n = static_cast<std::size_t>(k);
      const VectorXd answer = feedback.gain[n] * (moved[n] * best + drift[n]);
      EXPECT_LE((answer - best.segment(controls * k, controls)).norm(), tolerance(1e-6) * best.norm())
          << "seed " << seed << ", node " << k;
    }
    EXPECT_GT(best.head(controls).norm(), 1e-3 * best.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, FeedbackOfSchemes,
                         ::testing::Values(Scheme::paper, Scheme::trapezoid, Scheme::midpoint, Scheme::order4),
                         named_by_value);

// The march under the law against linear maps from differences closed by the gains.
TEST(Feedback, closed_loop_follows_its_linear_prediction_to_second_order) {
  const int steps = 8;
  Plan plan = tree_in_motion(11, 3, Scheme::trapezoid, steps, 0.4);
  plan.solution.feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
  const integrator::FeedbackLaw law = plan.law();
  const int states = 2 * plan.system.velocity_count(), controls = plan.system.control_count();
  Random random(2);
  VectorXd start(states);
  for (double& entry : start) entry = random.normal();
  VectorXd predicted = start;
  for (int k = 0; k < steps; ++k) {
    const StepMap map = step_map(plan, k);
    const MatrixXd& K_next = plan.solution.feedback.gain[static_cast<std::size_t>(k) + 1];
    const VectorXd u = plan.solution.feedback.gain[static_cast<std::size_t>(k)] * predicted;
    const VectorXd before = map.A * predicted + map.B * u;  // what u_next adds depends on where it leads
    const VectorXd u_next =
        (MatrixXd::Identity(controls, controls) - K_next * map.B_next).partialPivLu().solve(K_next * before);
    predicted = before + map.B_next * u_next;
  }
  const auto error = [&](double size) {
    maneuver::Problem off = plan.problem;
    off.start = start_at(plan.system, deviated(plan.system, node_state(plan.system, plan.solution, 0), size * start));
    return (end_deviation(plan, follow(plan.system, off, law)) - size * predicted).norm();
  };
  const double coarse = error(2e-3), fine = error(1e-3);
  EXPECT_LE(fine, 1e-3 * predicted.norm());
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, tolerance(0.1));
}

TEST(Feedback, brings_back_what_the_plan_alone_lets_go_astray) {
  Plan plan = chain_in_motion(60.0, 200, 1.0);
  const integrator::FeedbackLaw none(
      integrator::MotionPath(plan.system, maneuver::node_motion(plan.system, plan.solution)), plan.control, {0.0},
      {MatrixXd::Zero(6, 24)});
  plan.solution.feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
  const integrator::FeedbackLaw law = plan.law();
  for (std::uint64_t seed : {1U, 2U}) {
    maneuver::Problem off = plan.problem;
    off.start = maneuver::turned_start(plan.system, plan.problem.start, 1e-3, seed, MatrixXd::Identity(9, 9));
    const auto held = maneuver::tracking_of(law, follow(plan.system, off, law));
    const auto open = maneuver::tracking_of(none, follow(plan.system, off, none));
    EXPECT_GT(open.rotation_error, 5e-3) << "the motion is not unstable: the test says nothing";
    EXPECT_LT(held.rotation_error, 1e-3);
    EXPECT_LT(held.largest_rotation_error, 5e-3);
    EXPECT_EQ(open.largest_correction, 0.0);
    EXPECT_GT(held.largest_correction, 0.1);
    // another integrator, other inertia
    EXPECT_LT(maneuver::tracking_of(law, follow(plan.system, off, law, true)).rotation_error, 2e-2);
    EXPECT_GT(maneuver::tracking_of(none, follow(plan.system, off, none, true)).rotation_error, 0.1);
    for (model::BodyDescription& body : off.swimmer.bodies) {
      *body.mass_matrix *= seed == 1 ? 1.01 : 0.99;
      (*body.inertia_matrix)(0, 0) *= 1.01;
    }
    EXPECT_LT(maneuver::tracking_of(law, follow(model::System(off.swimmer), off, law)).rotation_error, 1e-2);
  }
}

TEST(Feedback, does_not_blow_up_over_total_momentum_that_no_moment_can_change) {
  Plan plan = chain_in_motion(60.0, 200, 1.0);
  plan.solution.feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
  const integrator::FeedbackLaw law = plan.law();
  for (const MatrixXd& gain : plan.solution.feedback.gain) EXPECT_LT(gain.cwiseAbs().maxCoeff(), 1e5);
  maneuver::Problem off = plan.problem;
  off.start.linear_velocity = Vector3d(0.02, -0.01, 0.01);
  const auto held = maneuver::tracking_of(law, follow(plan.system, off, law));
  EXPECT_LT(held.rotation_error, 2e-2);
  EXPECT_LT(held.position_error, 0.1);
}

TEST(Feedback, of_a_planar_swimmer_ignores_what_no_moment_can_reach) {
  Plan plan = chain_in_motion(60.0, 300, 1.0, true);
  plan.solution.feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
  double within = 0.0, across = 0.0;
  for (const MatrixXd& gain : plan.solution.feedback.gain)
    for (Eigen::Index c = 0; c < gain.cols(); ++c) {
      const Eigen::Index place = c % 12;
      const bool in_plane = place < 9 ? place % 3 == 2 : place < 11;
      double& size = in_plane ? within : across;
      size = std::max(size, gain.col(c).cwiseAbs().maxCoeff());
    }
  EXPECT_GT(within, 1.0);
  EXPECT_LE(across, tolerance(1e-10) * within);
  const MatrixXd turns = maneuver::answered_turns(plan.system, plan.solution.feedback);
  EXPECT_EQ(turns.cols(), 3);
  maneuver::Problem off = plan.problem;
  off.start = maneuver::turned_start(plan.system, plan.problem.start, 3e-3, 4, turns);
  for (const Vector3d& v : off.start.rotation) EXPECT_LE(v.head<2>().norm(), tolerance(1e-9));
  const integrator::FeedbackLaw law = plan.law();
  EXPECT_LT(maneuver::tracking_of(law, follow(plan.system, off, law)).rotation_error, 5e-3);
}

// The whole experiment seen from elsewhere: turned and shifted in the world.
TEST(Feedback, is_the_same_from_any_place_in_the_world) {
  Random random(13);
  Plan plan = chain_in_motion(60.0, 50, 0.25);
  const Matrix3d W = random.rotation();
  const Vector3d shift = random.vector();
  maneuver::Problem elsewhere = plan.problem;
  for (Vector3d& v : elsewhere.start.rotation) v = lie::log(W * lie::exp(v));
  elsewhere.start.position = shift;
  Plan moved(elsewhere, plan.control);
  const auto one = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
  const auto two = maneuver::design_feedback(moved.system, moved.problem, moved.solution);
  double largest = 0.0;
  for (const MatrixXd& gain : one.gain) largest = std::max(largest, gain.norm());
  for (std::size_t k = 0; k < one.gain.size(); ++k) {
    MatrixXd seen = two.gain[k];
    for (Eigen::Index first : {9, 21}) seen.middleCols(first, 3) *= W;
    EXPECT_LE((seen - one.gain[k]).norm(), tolerance(1e-8) * largest) << "node " << k;
  }
}

TEST(Feedback, comes_at_a_thousand_intervals_where_there_are_more_steps) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain();
  problem.swimmer.bodies.resize(2);
  problem.swimmer.joints.resize(1);
  problem.start.rotation.assign(2, Vector3d::Zero());
  problem.start.angular_velocity.assign(2, Vector3d::Zero());
  problem.duration.value = 0.5;
  problem.steps = 2500;
  Random random(4);
  const Plan plan(problem, waves(random, model::System(problem.swimmer), 20.0));
  const auto feedback = maneuver::design_feedback(plan.system, plan.problem, plan.solution);
  EXPECT_EQ(feedback.time.size(), 835U);  // every third node, and the last
  EXPECT_EQ(feedback.time.front(), 0.0);
  EXPECT_EQ(feedback.time[1], plan.time(3));
  EXPECT_EQ(feedback.time.back(), plan.time(2500));
  problem.steps = 500;
  const Plan coarse(problem, plan.control);
  const auto few = maneuver::design_feedback(coarse.system, coarse.problem, coarse.solution);
  const std::size_t middle = 417, same = 250;  // t = 0.2502 s and 0.25 s
  EXPECT_LE((feedback.gain[middle] - few.gain[same]).norm(), 0.05 * few.gain[same].norm());
}

TEST(Feedback, is_refused_where_stages_do_not_lead_where_the_nodes_are) {
  Plan plan = tree_in_motion(3, 3, Scheme::order4, 10, 0.2);
  plan.solution.control_stages[4][2][0].x() += 50.0;
  plan.solution.control_stages[4][2][1].x() += 50.0;
  EXPECT_THROW(maneuver::design_feedback(plan.system, plan.problem, plan.solution), std::domain_error);
}

// Gains cannot take momentum off: what starts beside its plan, or weighs otherwise, carries the plan's.
TEST(TurnedStart, carries_the_momentum_of_the_plan) {
  Random random(5);
  for (int trial = 0; trial < 6; ++trial) {
    const model::SwimmerDescription swimmer = random_swimmer(random, 4);
    const model::System system(swimmer);
    VectorXd velocity(system.velocity_count());
    for (double& entry : velocity) entry = random.normal();
    const maneuver::Start start = start_at(system, {random_rotations(random, system), random.vector(), velocity});
    model::SwimmerDescription heavier = swimmer;
    for (model::BodyDescription& body : heavier.bodies) {
      const model::Body& own = system.body(static_cast<int>(&body - heavier.bodies.data()));
      body.mass_matrix = 1.1 * own.mass_matrix;
      body.inertia_matrix = 1.2 * own.inertia_matrix;
    }
    const model::System other(heavier);
    const MatrixXd any = MatrixXd::Identity(system.velocity_count() - 3, system.velocity_count() - 3);
    const maneuver::Start off = maneuver::turned_start(system, start, 0.05, 7, any);
    const maneuver::Start carried = maneuver::with_momentum_of(system, start, other, off);
    const auto total = [](const model::System& of, const maneuver::Start& at) {
      const integrator::State state = maneuver::start_state(of, at);
      return mechanics::spatial_momentum(of, state.rotation, state.position, state.momentum);
    };
    const auto asked = total(system, start), found = total(other, carried), before = total(other, off);
    const double size = maneuver::start_state(system, start).momentum.norm();
    EXPECT_GT((before.angular - asked.angular).norm(), 1e-3 * size);
    EXPECT_LE((found.angular - asked.angular).norm(), tolerance(1e-11 * size));
    EXPECT_LE((found.linear - asked.linear).norm(), tolerance(1e-11 * size));
    EXPECT_EQ(carried.rotation, off.rotation);
    // joints turn as they did; bodies that they lead have to be turned along first
    for (int j = 0; j < system.joint_count(); ++j) {
      if (!system.joint(j).free() || system.body(system.joint(j).parent).freedoms < 3) continue;
      const auto p = model::at(system.joint(j).parent), c = model::at(system.joint(j).child);
      const Matrix3d Q = lie::exp(off.rotation[p]).transpose() * lie::exp(off.rotation[c]);
      const Vector3d rate = off.angular_velocity[c] - Q.transpose() * off.angular_velocity[p];
      const Vector3d kept = carried.angular_velocity[c] - Q.transpose() * carried.angular_velocity[p];
      EXPECT_LE((rate - kept).norm(), tolerance(1e-11 * (1.0 + rate.norm())));
    }
    maneuver::Start still = start;
    still.angular_velocity.assign(start.rotation.size(), Vector3d::Zero());
    still.linear_velocity.setZero();
    EXPECT_EQ(maneuver::with_momentum_of(system, still, other, still).angular_velocity, still.angular_velocity);
  }
}

TEST(TurnedStart, turns_every_body_by_the_angle_and_keeps_the_joints) {
  Random random(21);
  for (int trial = 0; trial < 10; ++trial) {
    const model::System system(random_swimmer(random, 5));
    const mechanics::Rotations R = random_rotations(random, system);
    const maneuver::Start start = start_at(system, {R, Vector3d::Zero(), VectorXd::Zero(system.velocity_count())});
    const MatrixXd any = MatrixXd::Identity(system.velocity_count() - 3, system.velocity_count() - 3);
    const maneuver::Start off = maneuver::turned_start(system, start, 0.05, 7, any);
    mechanics::Rotations turned_by;
    for (const Vector3d& v : off.rotation) turned_by.push_back(lie::exp(v));
    const mechanics::Freedoms change = turns_between(system, R, turned_by);
    for (int i = 0; i < system.body_count(); ++i) {
      if (system.body(i).freedoms > 0) {
        EXPECT_NEAR(change[model::at(i)].norm(), 0.05, tolerance(1e-12));
      }
    }
    const mechanics::Rotations again = turned(system, R, change);  // led bodies where their angles say
    for (std::size_t i = 0; i < again.size(); ++i) EXPECT_LE((again[i] - turned_by[i]).norm(), tolerance(1e-12));
    EXPECT_EQ(maneuver::turned_start(system, start, 0.05, 7, any).rotation, off.rotation);
    EXPECT_NE(maneuver::turned_start(system, start, 0.05, 8, any).rotation, off.rotation);
  }
}

}  // namespace
}  // namespace lamprey::tests
