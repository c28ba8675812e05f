// Answers that no certificate may pass: files that tell of another problem's motion, bounds that hold nothing, and numbers
// whose size is a matter of units.
#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "certificate/verdict.hpp"
#include "evidence/limit_check.hpp"
#include "lie/so3.hpp"
#include "marched_answers.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/first_order.hpp"
#include "optimality/limit_pulls.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using certificate::Certificate;
using certificate::Verdict;

const certificate::Options unreplayed{.replay = false};

// The paper's translation in the plane, proved.
const MarchedAnswer& translation() {
  static const MarchedAnswer answer = [] {
    maneuver::Problem problem = chain_problem(40, 1.0);
    problem.goal->turn = Vector3d::Zero();
    problem.goal->move = {2.0, std::nullopt, std::nullopt};
    for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
    const model::System system(problem.swimmer);
    return MarchedAnswer{problem, study::answer(system, problem, {}).solution};
  }();
  return answer;
}

Certificate judged(const MarchedAnswer& answer) {
  return certificate::certify(model::System(answer.problem.swimmer), answer.problem, answer.solution, unreplayed);
}

TEST(Verdict, of_the_answer_itself_is_a_proved_minimum) {
  const Certificate proof = judged(translation());
  EXPECT_EQ(proof.verdict, Verdict::proved);
  EXPECT_LE(proof.time_error, tolerance(1e-14));
  EXPECT_LE(proof.cost_error, tolerance(1e-14));
}

TEST(Verdict, does_not_pass_another_cost) {
  MarchedAnswer answer = translation();
  answer.solution.cost *= 1.0 - 1e-6;
  EXPECT_NEAR(judged(answer).cost_error, 1e-6, tolerance(1e-9));
  EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
}

TEST(Verdict, does_not_pass_a_motion_that_takes_more_time_than_asked) {
  MarchedAnswer answer = translation();
  answer.problem.duration.value = 0.5;
  EXPECT_NEAR(judged(answer).time_error, 1.0, tolerance(1e-12));
  EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
}

TEST(Verdict, does_not_pass_steps_of_unequal_length) {
  MarchedAnswer answer = translation();
  answer.solution.time[7] += 1e-4;
  EXPECT_NEAR(judged(answer).time_error, 1e-4, tolerance(1e-9));
  EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
}

// What a reader plots, though nothing else in the certificate asks for it.
TEST(Verdict, does_not_pass_velocities_or_momenta_of_another_motion) {
  const auto error_with = [](auto&& change) {
    MarchedAnswer answer = translation();
    change(answer.solution);
    EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
    return judged(answer).velocity_error;
  };
  EXPECT_LE(judged(translation()).velocity_error, tolerance(1e-10));
  EXPECT_GT(error_with([](maneuver::Solution& answer) { answer.angular_velocity[3][1] *= 1.01; }), 1e-4);
  EXPECT_GT(error_with([](maneuver::Solution& answer) { answer.linear_velocity[3] *= 1.01; }), 1e-4);
  EXPECT_GT(error_with([](maneuver::Solution& answer) { answer.linear_momentum.fluid[3] *= 1.01; }), 1e-4);
  EXPECT_GT(error_with([](maneuver::Solution& answer) { answer.angular_momentum.bodies[3] *= 1.01; }), 1e-4);
  EXPECT_GT(error_with([](maneuver::Solution& answer) { answer.linear_velocity.pop_back(); }), 1.0);
  EXPECT_NEAR(error_with([](maneuver::Solution& answer) { answer.joint_angle[3][1].z() += 1e-3; }), 1e-3,
              tolerance(1e-9));
  EXPECT_GT(error_with([](maneuver::Solution& answer) { answer.joint_angle.pop_back(); }), 1.0);
}

TEST(Verdict, does_not_pass_another_start) {
  MarchedAnswer answer = translation();
  answer.problem.start.position.y() += 1e-6;
  EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
}

// Beside the actuation moments cost nothing, so that they are stationary whatever they are.
TEST(Verdict, does_not_pass_moments_about_axes_that_are_not_actuated) {
  MarchedAnswer answer = translation();
  for (model::JointDescription& joint : answer.problem.swimmer.joints) joint.control_axes = {Vector3d(0, 1, 0)};
  EXPECT_NEAR(judged(answer).control_error, 1.0, tolerance(1e-12));
  EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
}

// An interior-point method leaves a little of a multiplier on every bound. Where none is reached, none holds: the curvature
// is that of the problem without bounds.
TEST(Verdict, counts_no_bound_as_held_that_is_not_reached) {
  MarchedAnswer answer = translation();
  const double free = judged(answer).second_order->smallest_eigenvalue;
  answer.problem.limits.torque = 1e6;
  for (int joint = 0; joint < 2; ++joint) {
    maneuver::LimitMultiplier remainder;
    remainder.key = "limits.torque";
    remainder.joint = joint;
    remainder.multiplier.assign(answer.solution.time.size(), 1e-13);
    answer.solution.limit_multipliers.push_back(remainder);
  }
  const model::System system(answer.problem.swimmer);
  const evidence::StoredMotion motion(system, answer.problem, answer.solution);
  ASSERT_FALSE(optimality::pulling_bounds(motion).empty()) << "the multipliers belong to no bound";
  const Certificate proof = judged(answer);
  ASSERT_TRUE(proof.second_order);
  EXPECT_NEAR(proof.second_order->smallest_eigenvalue, free, tolerance(1e-8));
}

// The planar translation with moments about e_2 and e_3 at one joint, which lower the cost out of the plane, and a floor just
// below the root that nothing pushes against. Multipliers too small for the conditions of first order to show do not make
// the floor hold.
TEST(Verdict, counts_no_bound_as_held_whose_pull_nothing_needs) {
  for (std::size_t joint = 0; joint < 2; ++joint) {
    MarchedAnswer answer = translation();
    maneuver::Problem& problem = answer.problem;
    problem.swimmer.joints[joint].control_axes = {Vector3d(0, 1, 0), Vector3d(0, 0, 1)};
    const double free = judged(answer).second_order->smallest_eigenvalue;
    ASSERT_LT(free, -1.0) << "no saddle";
    const double lowest = problem.swimmer.bodies[0].semi_axes.z();
    problem.limits.half_spaces = {{Vector3d(0, 0, -lowest - 0.9e-6), Vector3d(0, 0, 1)}};
    maneuver::LimitMultiplier floor;
    floor.key = "limits.half_space";
    floor.body = floor.component = 0;
    for (const double pull : {1.9e-9, 1e-8, 1e-5, 1e-4})
      for (const int every : {1, 7}) {
        problem.search.tolerance = 10.0 * pull;  // as loose as they need
        floor.multiplier.assign(answer.solution.time.size(), 0.0);
        for (std::size_t k = 1; k < floor.multiplier.size(); k += static_cast<std::size_t>(every))
          floor.multiplier[k] = pull * answer.solution.cost;
        answer.solution.limit_multipliers = {floor};
        const model::System system(problem.swimmer);
        ASSERT_FALSE(optimality::pulling_bounds(evidence::StoredMotion(system, problem, answer.solution)).empty())
            << "the multipliers belong to no bound";
        const Certificate proof = judged(answer);
        ASSERT_EQ(proof.verdict, Verdict::stationary) << pull << ", kkt " << proof.kkt;
        EXPECT_NEAR(proof.second_order->smallest_eigenvalue, free, tolerance(1e-2 * std::abs(free)));
      }
  }
}

MarchedAnswer answered(const maneuver::Problem& problem) {
  search::SolveOptions options;
  options.refinement = false;
  return {problem, study::answer(model::System(problem.swimmer), problem, options).solution};
}

// A bound that pulls is one that is reached: with a little more room the cost falls, and what was a minimum is none.
TEST(Verdict, proves_nothing_by_the_pull_of_a_bound_that_is_not_reached) {
  maneuver::Problem problem = translation().problem;
  double largest = 0.0;
  for (const auto& moments : translation().solution.control) largest = std::max(largest, moments[0].norm());
  problem.limits.torque = 0.9 * largest;
  MarchedAnswer answer = answered(problem);
  ASSERT_EQ(judged(answer).verdict, Verdict::proved);
  ASSERT_FALSE(judged(answer).limits->reached.empty());
  for (const double room : {1e-4, 1e-3}) {
    answer.problem.limits.torque = (1.0 + room) * 0.9 * largest;
    const Certificate proof = judged(answer);
    EXPECT_EQ(proof.verdict, Verdict::not_optimal) << room << ", " << proof.limits->complementarity;
  }
}

// Bounds of the duration pull for all of it, whatever it is in seconds.
TEST(Verdict, proves_nothing_by_the_pull_of_a_duration_that_is_not_reached) {
  for (const double seconds : {1e-4, 1.0, 1e4}) {
    maneuver::Problem problem = translation().problem;
    problem.duration = {.free = true, .value = seconds, .min = 0.1 * seconds, .max = seconds};
    MarchedAnswer answer = answered(problem);
    ASSERT_EQ(judged(answer).verdict, Verdict::proved) << seconds << ": " << answer.solution.message;
    ASSERT_NEAR(answer.solution.time.back() / seconds, 1.0, 1e-9);
    for (const double room : {1e-4, -1e-4}) {
      answer.problem.duration.max = (1.0 + room) * seconds;
      EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal) << seconds << ", " << room;
    }
  }
}

// A motion without moments is no answer where time has a price: a little faster costs next to nothing.
TEST(Verdict, does_not_pass_a_motion_without_moments_where_time_costs) {
  maneuver::Problem resting = translation().problem;
  resting.goal->move = {0.0, 0.0, 0.0};
  maneuver::Problem drifting = chain_problem(40, 1.5);
  drifting.start.linear_velocity = Vector3d(0.3, 0.1, 0.0);
  drifting.start.angular_velocity.assign(3, Vector3d(0, 0, 0.1));
  drifting.goal->turn = std::nullopt;
  drifting.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  drifting.goal->rest = false;
  for (maneuver::Problem problem : {resting, drifting}) {
    problem.duration = {.free = false, .value = 1.5};
    MarchedAnswer answer = answered(problem);
    ASSERT_EQ(judged(answer).verdict, Verdict::proved) << answer.solution.message;
    answer.problem.duration = {.free = true, .value = 1.5, .min = 1.0, .max = 2.0};
    answer.problem.time_weight = 1.0;
    answer.solution.cost += 1.5;
    const Certificate proof = judged(answer);
    EXPECT_LE(proof.cost_error, tolerance(1e-12));
    EXPECT_GT(proof.kkt, 0.1);
    EXPECT_EQ(proof.verdict, Verdict::not_optimal);
  }
}

// The planar translation up to a wall that it touches at its end, where the goal's rows take up whatever the wall is said to pull.
MarchedAnswer up_to_a_wall(double pull) {
  constexpr int foremost = 1;
  MarchedAnswer answer = translation();
  answer.problem.limits.half_spaces = {{answer.solution.position.back(), Vector3d(-1, 0, 0)}};
  const evidence::LimitsKept beyond = *judged(answer).limits;
  EXPECT_EQ(beyond.time, answer.solution.time.back());
  answer.problem.limits.half_spaces[0].point.x() += beyond.violation;
  maneuver::LimitMultiplier wall;
  wall.key = "limits.half_space";
  wall.body = foremost;
  wall.component = 0;
  wall.multiplier.assign(answer.solution.time.size(), 0.0);
  wall.multiplier.back() = pull * answer.solution.cost;
  answer.solution.limit_multipliers = {wall};
  return answer;
}

TEST(Verdict, takes_no_measure_from_multipliers_that_the_goal_takes_up) {
  ASSERT_EQ(judged(up_to_a_wall(1e7)).verdict, Verdict::proved) << "the wall is not where the motion ends";
  MarchedAnswer longer = up_to_a_wall(1e7);  // would be cheaper, whoever forbids to be shorter
  longer.problem.duration = {.free = true, .value = 1.0, .min = 1.0, .max = 2.0};
  maneuver::LimitMultiplier least;
  least.key = "time.min";
  least.multiplier.assign(longer.solution.time.size(), 0.0);
  least.multiplier.back() = -3.0 * longer.solution.cost;
  longer.solution.limit_multipliers.push_back(least);
  EXPECT_EQ(judged(longer).verdict, Verdict::not_optimal) << judged(longer).kkt;

  std::vector<double> residual;
  for (const double pull : {0.0, 1e12}) {
    MarchedAnswer sideways = up_to_a_wall(pull);
    sideways.problem.cost_weights.displacement = Vector3d(0.0, 0.1 * sideways.solution.cost, 0.0);
    sideways.solution.cost -= sideways.problem.cost_weights.displacement.y() * sideways.solution.position.back().y();
    const Certificate proof = judged(sideways);
    EXPECT_LE(proof.cost_error, tolerance(1e-12));
    EXPECT_EQ(proof.verdict, Verdict::not_optimal);
    residual.push_back(proof.kkt);
  }
  EXPECT_GT(residual[0], 1e-2);
  EXPECT_NEAR(residual[1] / residual[0], 1.0, tolerance(1e-2));
}

// What marks of a marched motion allow is no matter of a word beside an answer.
TEST(Verdict, keeps_its_marks_whatever_an_answer_says_to_be_marched_by) {
  MarchedAnswer answer = translation();
  const double allowed = judged(answer).momentum_allowed();
  answer.solution.marched_by = "reference";
  EXPECT_EQ(judged(answer).momentum_allowed(), allowed);
}

// A gait whose first shape is free may begin beyond a face that no later node reaches.
TEST(Verdict, sees_the_first_node_of_gaits_in_what_is_kept_out_of) {
  MarchedAnswer answer = translation();
  answer.problem.goal->periodic = true;
  answer.problem.limits.half_spaces = {{Vector3d(0.0, 0.0, -5.0), Vector3d(0.0, 0.0, 1.0)}};
  for (std::size_t k = 1; k < answer.solution.position.size(); ++k) answer.solution.position[k].z() += 10.0;
  answer.solution.position[0].z() -= 10.0;
  const model::System system(answer.problem.swimmer);
  for (const bool free_shape : {true, false}) {
    answer.problem.start.free_shape = free_shape;
    const auto kept = evidence::check_limits(evidence::StoredMotion(system, answer.problem, answer.solution));
    EXPECT_EQ(kept.violation > 1.0, free_shape);
    EXPECT_TRUE(!free_shape || kept.time == 0.0);
  }
}

// Where the tolerance is loose, a motion may be called stationary by it, but a proof needs more.
TEST(Verdict, proves_nothing_by_a_loose_tolerance) {
  maneuver::Problem problem = translation().problem;
  Certificate proof = judged(translation());
  ASSERT_TRUE(proof.second_order->positive);
  problem.search.tolerance = 1e-2;
  for (const auto& [kkt, verdict] : {std::pair(0.5 * optimality::proof_mark, Verdict::proved),
                                     std::pair(2.0 * optimality::proof_mark, Verdict::stationary),
                                     std::pair(2.0 * problem.search.tolerance, Verdict::not_optimal)}) {
    proof.kkt = kkt;
    EXPECT_EQ(certificate::verdict(problem, proof), verdict) << kkt;
  }
}

TEST(Verdict, does_not_pass_matrices_that_are_no_rotations) {
  const auto drift_with = [](const auto& change) {
    MarchedAnswer answer = translation();
    for (std::size_t k = 1; k + 1 < answer.solution.rotation.size(); ++k) change(answer.solution.rotation[k][1]);
    const Certificate proof = judged(answer);
    EXPECT_EQ(proof.verdict, Verdict::not_optimal);
    return proof.rotation_drift;
  };
  EXPECT_NEAR(drift_with([](Matrix3d& R) { R *= 1.0 + 1e-9; }), 3e-9, tolerance(1e-12));
  EXPECT_NEAR(drift_with([](Matrix3d& R) { R.col(2) *= -1.0; }), 2.0, tolerance(1e-9));
  // alone, whatever else the certificate finds
  MarchedAnswer answer = translation();
  Certificate proof = judged(answer);
  proof.rotation_drift = 1e-9;
  EXPECT_EQ(certificate::verdict(answer.problem, proof), Verdict::not_optimal);
}

// A body next to nothing that stands off its fixed joint: no equation misses it.
TEST(Verdict, does_not_pass_led_bodies_off_their_joints) {
  MarchedAnswer answer = translation();
  model::BodyDescription speck;
  speck.name = "speck";
  speck.semi_axes = Vector3d::Constant(0.1);
  speck.mass = 1e-5;
  answer.problem.swimmer.bodies.push_back(speck);
  model::JointDescription joint;
  joint.kind = model::JointKind::fixed;
  joint.name = joint.child = "speck";
  joint.parent = answer.problem.swimmer.bodies[0].name;
  joint.parent_offset = Vector3d(1, 0, 0);
  joint.child_offset = Vector3d::Zero();
  answer.problem.swimmer.joints.push_back(joint);
  answer.problem.start.rotation.push_back(Vector3d::Zero());
  answer.problem.start.angular_velocity.push_back(Vector3d::Zero());
  const model::System system(answer.problem.swimmer);
  maneuver::Solution& motion = answer.solution = study::answer(system, answer.problem, {}).solution;
  EXPECT_EQ(judged(answer).verdict, Verdict::proved) << motion.message;
  for (std::size_t k = 1; k + 1 < motion.rotation.size(); ++k)
    motion.rotation[k].back() *= lie::exp(Vector3d(0, 0, 1e-3));
  motion.joint_angle.clear();  // as in files of early versions
  EXPECT_GE(judged(answer).velocity_error, 1e-3 - 1e-9);
  EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
}

// Questions whose answers no check here covers: above order 2, and of moments on splines, everything but effort and time.
TEST(Verdict, of_questions_that_are_not_checked_is_none) {
  for (const bool spline : {false, true}) {
    MarchedAnswer answer = translation();
    if (spline) {
      answer.problem.control = maneuver::ControlKind::spline;
      answer.problem.points = 11;
    } else {
      answer.problem.scheme = maneuver::Scheme::order4;
    }
    answer.solution = study::answer(model::System(answer.problem.swimmer), answer.problem, {}).solution;
    ASSERT_EQ(judged(answer).verdict, Verdict::proved) << answer.solution.message;
    const auto expect_none = [&](const char* what, const auto& ask) {
      MarchedAnswer other = answer;
      ask(other.problem);
      const Certificate proof = judged(other);
      EXPECT_EQ(proof.verdict, Verdict::not_optimal) << what;
      EXPECT_TRUE(std::isnan(proof.kkt)) << what;
    };
    expect_none("limit", [](maneuver::Problem& problem) { problem.limits.torque = 1e7; });
    expect_none("waypoint", [](maneuver::Problem& problem) {
      problem.waypoints = {{problem.duration.value / 2.0, {100.0, std::nullopt, std::nullopt}, {}, {}}};
    });
    expect_none("free duration", [](maneuver::Problem& problem) {
      problem.duration.free = true;
      problem.duration.min = 0.5;
      problem.duration.max = 2.0;
    });
    expect_none("gait", [](maneuver::Problem& problem) { problem.goal->periodic = true; });
    expect_none("work", [](maneuver::Problem& problem) { problem.cost_weights.work = 5.0; });
    expect_none("displacement", [](maneuver::Problem& problem) { problem.cost_weights.displacement.y() = 1e5; });
  }
}

// Of a scheme above order 2 the steps are marched under the moments of their stages: those of the nodes, and when the stages are,
// are told beside them.
TEST(Verdict, does_not_pass_moments_at_nodes_that_are_not_those_of_the_stages_beside_them) {
  for (const maneuver::Scheme scheme : {maneuver::Scheme::order4, maneuver::Scheme::order6}) {
    MarchedAnswer answer = translation();
    answer.problem.scheme = scheme;
    answer.solution = study::answer(model::System(answer.problem.swimmer), answer.problem, {}).solution;
    ASSERT_EQ(judged(answer).verdict, Verdict::proved) << answer.solution.message;
    double largest = 0.0;
    for (const auto& moments : answer.solution.control)
      for (const Vector3d& moment : moments) largest = std::max(largest, moment.norm());
    for (const std::size_t node : {std::size_t{0}, std::size_t{7}, answer.solution.control.size() - 1}) {
      MarchedAnswer other = answer;
      other.solution.control[node][0].z() += 1e-6 * largest;
      const Certificate proof = judged(other);
      EXPECT_GT(proof.control_error, 0.5e-6) << node;
      EXPECT_EQ(proof.verdict, Verdict::not_optimal) << node;
    }
    answer.solution.stage_time[5][1] += 1e-6 * answer.solution.time.back();
    EXPECT_NEAR(judged(answer).time_error, 1e-6, tolerance(1e-12));
    EXPECT_EQ(judged(answer).verdict, Verdict::not_optimal);
  }
}

// A duration that may be longer, at a motion that is the best of its own: longer would be cheaper. Masses in grams or in
// gigatons, the residual says so.
TEST(Verdict, residual_of_a_free_duration_does_not_depend_on_the_unit_of_mass) {
  std::vector<double> residual;
  for (const double unit : {1.0, 1e-11, 1e6}) {
    MarchedAnswer answer = translation();
    answer.problem.duration.free = true;
    answer.problem.duration.min = 0.5;
    answer.problem.duration.max = 2.0;
    for (model::BodyDescription& body : answer.problem.swimmer.bodies) {
      *body.mass_matrix *= unit;
      *body.inertia_matrix *= unit;
    }
    for (auto& moments : answer.solution.control)
      for (Vector3d& moment : moments) moment *= unit;
    answer.solution.cost *= unit * unit;
    const Certificate proof = judged(answer);
    EXPECT_LE(proof.equation_residual, tolerance(1e-11));
    EXPECT_EQ(proof.verdict, Verdict::not_optimal);
    residual.push_back(proof.kkt);
  }
  EXPECT_GT(residual[0], 1e-3);
  EXPECT_NEAR(residual[1] / residual[0], 1.0, tolerance(1e-6));
  EXPECT_NEAR(residual[2] / residual[0], 1.0, tolerance(1e-6));
}

// One step is too few for a closed motion to have any freedom but to stay, which costs nothing.
TEST(Verdict, of_a_gait_of_one_step_is_to_stay) {
  maneuver::Problem problem = chain_problem(1, 0.1);
  problem.goal->periodic = true;
  problem.goal->rest = false;
  problem.goal->turn.reset();
  problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  const model::System system(problem.swimmer);
  const study::Answer answer = study::answer(system, problem, {});
  EXPECT_FALSE(answer.solution.message.empty());
  EXPECT_EQ(answer.solution.cost, 0.0);
  EXPECT_EQ(answer.certificate.verdict, Verdict::proved);
  EXPECT_TRUE(answer.certificate.second_order->costs_nothing);
}

// A tail that nothing drives has no work. Said to be driven about axes that the motion does not turn it about, its powers are
// round-off times round-off, and must hold no direction still in the second-order test: the planar motion is a saddle there.
TEST(Verdict, does_not_take_powers_of_a_joint_that_is_not_used_for_held) {
  MarchedAnswer answer = translation();
  maneuver::Problem& problem = answer.problem;
  problem.steps = 24;
  problem.cost_weights.work = 5.0;
  model::BodyDescription tail = problem.swimmer.bodies.back();
  model::JointDescription joint = problem.swimmer.joints.back();
  joint.parent = tail.name;
  joint.name = joint.child = tail.name = "tail";
  joint.parent_offset = {-5.5, 0.0, 0.0};
  joint.child_offset = {5.5, 0.0, 0.0};
  joint.actuated = false;
  joint.control_axes.reset();
  problem.swimmer.bodies.push_back(tail);
  problem.swimmer.joints.push_back(joint);
  problem.start.rotation.emplace_back(Vector3d::Zero());
  problem.start.angular_velocity.emplace_back(Vector3d::Zero());
  problem.goal->rotation["tail"] = std::nullopt;
  answer.solution = study::answer(model::System(problem.swimmer), problem, {}).solution;
  ASSERT_EQ(judged(answer).verdict, Verdict::proved) << answer.solution.message;
  problem.swimmer.joints.back().actuated = true;
  problem.swimmer.joints.back().control_axes = {Vector3d(0, 1, 0), Vector3d(1, 0, 0)};
  Random random(1);
  for (const double noise : {0.0, 1e-13, 1e-11}) {
    for (maneuver::Vectors& moments : answer.solution.control) moments.back() = random.vector(noise);
    for (maneuver::Vectors& moments : answer.solution.control) moments.back().z() = 0.0;
    const Certificate proof = judged(answer);
    EXPECT_LE(proof.kkt, 1e-8) << noise;
    EXPECT_NE(proof.verdict, Verdict::proved) << noise;
  }
}

// A start that hardly moves: moments of round-off are a motion that goes on by itself, others are held to their own gradient.
TEST(Verdict, of_starts_in_motion_asks_more_of_moments_that_are_more_than_round_off) {
  maneuver::Problem problem = chain_problem(400, 0.4);
  problem.start.angular_velocity[0] = Vector3d(0.0, 0.0, 1e-30);
  const model::System system(problem.swimmer);
  const auto worth_over_own = [&](double moment) {
    const NodeMoments even(401, mechanics::Moments{Vector3d(0.0, 0.0, moment), Vector3d(0.0, 0.0, -moment)});
    const MarchedAnswer answer = march(problem, even);
    const evidence::StoredMotion motion(system, answer.problem, answer.solution);
    return optimality::gradient_of_coasting(motion) / (optimality::node_weights(motion).maxCoeff() * moment);
  };
  EXPECT_GT(worth_over_own(1e-9), 1e6);
  EXPECT_NEAR(worth_over_own(1e-2), optimality::proof_mark / problem.search.tolerance, 1e-6);
  EXPECT_LT(worth_over_own(1e3), 0.1);
}

}  // namespace
}  // namespace lamprey::tests
